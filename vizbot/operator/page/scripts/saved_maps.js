// @ts-check
/**
 * Maps that are kept: the robot's own under a name, another one instead of it, an empty one.
 *
 * @typedef {import("./http.js").Reply} Reply
 */

import { byId, field, make, show } from "./dom.js";
import { BETWEEN_STEPS, request } from "./http.js";

const NAME = /^[\p{L}\p{N}_][\p{L}\p{N}_ -]{0,59}$/u;

export function createMaps() {
  /** @type {string[]} */
  let names = [];
  let agreed = () => {};

  /** @param {string} text */
  const say = (text) => show(byId("maps-said"), text);

  /** Nothing is asked of the robot before the person has agreed. */
  function ask(/** @type {string} */ question, /** @type {string} */ yes, /** @type {() => void} */ onYes) {
    agreed = onYes;
    say("");
    show(byId("maps-question"), question);
    show(byId("maps-yes"), yes);
    byId("maps-ask").hidden = false;
    byId("maps-ask").focus();
  }

  function close() {
    byId("maps-ask").hidden = true;
    byId("map-new").focus();
  }

  /** @returns {Promise<boolean>} Whether the robot has told them. */
  async function renew() {
    const { said, against } = await request("GET", "/maps");
    if (against !== null) return false;
    if (JSON.stringify(said.names) === JSON.stringify(names)) return true;
    names = said.names;
    const empty = names.length ? [] : [make("li", "None yet.", "quiet")];
    byId("maps").replaceChildren(...names.map(item), ...empty);
    return true;
  }

  /** @param {string} name */
  function item(name) {
    const use = make("button", "Use");
    use.setAttribute("aria-label", `Use ${name}`);
    use.addEventListener("click", () =>
      ask(`Leave the map it has now and go on in “${name}”?`, "Use it", () =>
        begin(`/maps/${encodeURIComponent(name)}/begin`, `It goes on in “${name}”.`),
      ),
    );
    const line = make("li", "");
    line.append(make("b", name), use);
    return line;
  }

  /** @param {string} path @param {string} done */
  async function begin(path, done) {
    say("Telling the robot.");
    const { said, against } = await request("POST", path, undefined, BETWEEN_STEPS);
    if (against !== null) {
      say(`Not done: ${against}.`);
      return;
    }
    const left = said.left === null
      ? "The map it left held too little to be kept."
      : `The map it left is kept as “${said.left}”.`;
    say(`${done} ${left}`);
    await renew();
  }

  /** @param {string} name @param {boolean} replace */
  async function keep(name, replace) {
    say("Telling the robot.");
    const path = `/maps/${encodeURIComponent(name)}`;
    const { status, against } = await request("PUT", path, { replace }, BETWEEN_STEPS);
    await renew();
    if (status === 409 && !replace && names.includes(name)) {
      ask(`There is a map “${name}” already. Replace it?`, "Replace it", () => keep(name, true));
      return;
    }
    say(against === null ? `Kept as “${name}”.` : `Not kept: ${against}.`);
    if (against === null) field("map-name").value = "";
  }

  byId("keep-form").addEventListener("submit", (event) => {
    event.preventDefault();
    const name = field("map-name").value.trim();
    byId("maps-ask").hidden = true;
    if (NAME.test(name)) keep(name, false);
    else say("Give it a name of letters, digits, spaces and -.");
  });
  byId("map-new").addEventListener("click", () =>
    ask("Leave the map it has now and begin an empty one?", "Begin", () =>
      begin("/map/new", "It has begun an empty map."),
    ),
  );
  byId("maps-yes").addEventListener("click", () => {
    close();
    agreed();
  });
  byId("maps-no").addEventListener("click", close);
  return { renew };
}
