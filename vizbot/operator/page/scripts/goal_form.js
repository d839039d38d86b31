// @ts-check
/**
 * Where a person asks the robot for something, and its answers.
 *
 * @typedef {object} Answer
 * @property {string[]} said
 * @property {string | null} question
 * @property {string | null} meant To be said by whoever answers the question with yes.
 * @property {import("./state_view.js").Point | null} place Of what was asked for.
 * @property {string | null} [heard]
 */

import { byId, capitalised, field, make } from "./dom.js";
import { BETWEEN_STEPS, refusal } from "./http.js";

/** What says yes to a question when it is spoken. */
const SPOKEN_YES = /^\W*(yes|yeah|yep|sure|correct|right|exactly)(,? please|,? that one)?\W*$/i;
/** @type {Record<string, [string, string]>} Path and answer by button. */
const WISHES = {
  explore: ["/explore", "Asked to explore."],
  "come-back": ["/come-back", "Asked to come back."],
  dock: ["/dock", "Asked to go to its charger."],
  "go-on": ["/continue", "Asked to go on."],
  "let-drive": ["/resume", "Asked to let it drive again."],
};

/**
 * @param {import("./http.js").Wishes} wishes
 * @param {() => string} who
 * @param {(place: Answer["place"]) => void} onPlace Told with each answer.
 */
export function createAsking(wishes, who, onPlace) {
  /** @type {(() => void) | null} Where a question waits for yes. */
  let agree = null;
  let asked = 0;

  /** @param {string[]} lines */
  function tell(lines) {
    asked += 1;
    byId("doubt").hidden = true;
    byId("answer").replaceChildren(...lines.map((line) => make("p", capitalised(line))));
  }

  /**
   * @param {Answer} answer
   * @param {boolean} atOnce As it was asked.
   */
  function show({ said, question, meant, place, heard }, atOnce) {
    if (agree && heard && SPOKEN_YES.test(heard)) {
      agree();
      return;
    }
    const lines = [...(heard ? [`Heard: “${heard}”`] : []), ...said, ...(question ? [question] : [])];
    tell(place ? [...lines, "It is marked on the map."] : lines);
    byId("doubt").hidden = !(question && meant);
    agree = question && meant ? () => ask(meant, atOnce) : null;
    onPlace(place);
  }

  /**
   * @param {string} text
   * @param {boolean} atOnce
   * @returns {Promise<boolean>} Whether the robot has taken it.
   */
  async function ask(text, atOnce) {
    tell(["Asking."]);
    const mine = asked;
    agree = null;
    const content = { text, at_once: atOnce, who: who() };
    const { said, against } = await wishes.ask("/said", content, BETWEEN_STEPS);
    if (mine !== asked) return against === null;
    if (against === null) show(said, atOnce);
    else tell([refusal(against)]);
    return against === null;
  }

  byId("ask-form").addEventListener("submit", async (event) => {
    event.preventDefault();
    const { submitter } = /** @type {SubmitEvent} */ (event);
    const button = /** @type {HTMLButtonElement | null} */ (submitter);
    const text = field("goal").value.trim();
    if (text === "") {
      tell(["Say what to go to, for example: yellow chair."]);
      field("goal").focus();
      return;
    }
    const taken = await ask(text, button?.value === "now");
    if (taken && field("goal").value.trim() === text) field("goal").value = "";
  });
  for (const [id, [path, done]] of Object.entries(WISHES)) {
    byId(id).addEventListener("click", async () => {
      const { against } = await wishes.ask(path);
      tell([against === null ? done : refusal(against)]);
    });
  }
  byId("yes").addEventListener("click", () => {
    byId("answer").focus(); // the button vanishes; the text field would bring up a phone's keyboard
    agree?.();
  });
  byId("no").addEventListener("click", () => {
    forget();
    byId("answer").focus();
    tell(["Nothing was asked for."]);
  });
  /** The question that waits, if one does, waits no more. */
  function forget() {
    agree = null;
    byId("doubt").hidden = true;
  }

  return { show, tell, forget };
}
