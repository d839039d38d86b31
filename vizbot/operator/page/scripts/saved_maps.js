// @ts-check
/**
 * Saved maps: saving the robot's map under a name, changing to another map or to an empty one.
 */

import { byId, field, createElement, setText } from "./dom.js";
import { STEP_TIMEOUT, request } from "./http.js";

const NAME = /^[\p{L}\p{N}_][\p{L}\p{N}_ -]{0,59}$/u;

export function createSavedMaps() {
  /** @type {string[]} */
  let names = [];
  let onConfirm = () => {};

  /** @param {string} text */
  const showText = (text) => setText(byId("maps-said"), text);

  /** @param {string} question @param {string} yes @param {() => void} onYes */
  function confirm(question, yes, onYes) {
    onConfirm = onYes;
    showText("");
    setText(byId("maps-question"), question);
    setText(byId("maps-yes"), yes);
    byId("maps-ask").hidden = false;
    byId("maps-ask").focus();
  }

  function close() {
    byId("maps-ask").hidden = true;
    byId("map-new").focus();
  }

  /** @returns {Promise<boolean>} Whether the robot has answered. */
  async function refresh() {
    const { answer, error } = await request("GET", "/maps");
    if (error !== null) return false;
    if (JSON.stringify(answer.names) === JSON.stringify(names)) return true;
    names = answer.names;
    const empty = names.length ? [] : [createElement("li", "None yet.", "quiet")];
    byId("maps").replaceChildren(...names.map(item), ...empty);
    return true;
  }

  /** @param {string} name */
  function item(name) {
    const use = createElement("button", "Use");
    use.setAttribute("aria-label", `Use ${name}`);
    use.addEventListener("click", () =>
      confirm(`Leave the map it has now and go on in “${name}”?`, "Use it", () =>
        begin(`/maps/${encodeURIComponent(name)}/begin`, `It goes on in “${name}”.`),
      ),
    );
    const line = createElement("li", "");
    line.append(createElement("b", name), use);
    return line;
  }

  /** @param {string} path @param {string} success */
  async function begin(path, success) {
    showText("Telling the robot.");
    const { answer, error } = await request("POST", path, undefined, STEP_TIMEOUT);
    if (error !== null) {
      showText(`Not done: ${error}.`);
      return;
    }
    const left = answer.left === null
      ? "The map it left held too little to be kept."
      : `The map it left is kept as “${answer.left}”.`;
    showText(`${success} ${left}`);
    await refresh();
  }

  /** @param {string} name @param {boolean} replace */
  async function save(name, replace) {
    showText("Telling the robot.");
    const path = `/maps/${encodeURIComponent(name)}`;
    const { status, error } = await request("PUT", path, { replace }, STEP_TIMEOUT);
    await refresh();
    if (status === 409 && !replace && names.includes(name)) {
      confirm(`There is a map “${name}” already. Replace it?`, "Replace it", () => save(name, true));
      return;
    }
    showText(error === null ? `Kept as “${name}”.` : `Not kept: ${error}.`);
    if (error === null) field("map-name").value = "";
  }

  byId("keep-form").addEventListener("submit", (event) => {
    event.preventDefault();
    const name = field("map-name").value.trim();
    byId("maps-ask").hidden = true;
    if (NAME.test(name)) save(name, false);
    else showText("Give it a name of letters, digits, spaces and -.");
  });
  byId("map-new").addEventListener("click", () =>
    confirm("Leave the map it has now and begin an empty one?", "Begin", () =>
      begin("/map/new", "It has begun an empty map."),
    ),
  );
  byId("maps-yes").addEventListener("click", () => {
    close();
    onConfirm();
  });
  byId("maps-no").addEventListener("click", close);
  return { refresh };
}
