// @ts-check
/**
 * The form in which a person asks the robot for something, and its answers.
 *
 * @typedef {object} Answer
 * @property {string[]} said
 * @property {string | null} question
 * @property {string | null} meant The sentence that says yes to the question.
 * @property {import("./state_view.js").Point | null} place Where what was asked for is.
 * @property {string | null} [heard]
 */

import { byId, capitalised, field, createElement } from "./dom.js";
import { STEP_TIMEOUT, refusalText } from "./http.js";

/** @type {Record<string, [string, string]>} The path and the text on success, by button. */
const TASK_BUTTONS = {
  explore: ["/explore", "Asked to explore."],
  "come-back": ["/come-back", "Asked to come back."],
  dock: ["/dock", "Asked to go to its charger."],
  "go-on": ["/continue", "Asked to go on."],
  "asks-go-on": ["/continue", "Asked to go on: it sees where it is first."],
  "let-drive": ["/resume", "Asked to let it drive again."],
};

/**
 * @param {import("./http.js").PendingRequests} requests
 * @param {() => string} who
 * @param {(place: Answer["place"]) => void} onPlace Called with the place of each answer.
 */
export function createGoalForm(requests, who, onPlace) {
  /** @type {(() => void) | null} Says yes; null where no question waits. */
  let sayYes = null;
  let newest = 0;

  /** @param {string[]} lines */
  function showLines(lines) {
    newest += 1;
    byId("doubt").hidden = true;
    byId("answer").replaceChildren(...lines.map((line) => createElement("p", capitalised(line))));
  }

  /**
   * @param {Answer} answer
   * @param {boolean} atOnce As it was asked.
   */
  function showAnswer({ said, question, meant, place, heard }, atOnce) {
    const lines = [...(heard ? [`Heard: “${heard}”`] : []), ...said, ...(question ? [question] : [])];
    showLines(place ? [...lines, "It is marked on the map."] : lines);
    byId("doubt").hidden = !(question && meant);
    sayYes = question && meant ? () => ask(meant, atOnce) : null;
    onPlace(place);
  }

  /**
   * @param {string} text
   * @param {boolean} atOnce
   * @returns {Promise<boolean>} Whether the robot has accepted it.
   */
  async function ask(text, atOnce) {
    showLines(["Asking."]);
    const number = newest;
    sayYes = null;
    const content = { text, at_once: atOnce, who: who() };
    const { answer, error } = await requests.post("/said", content, STEP_TIMEOUT);
    if (number !== newest) return error === null;
    if (error === null) showAnswer(answer, atOnce);
    else showLines([refusalText(error)]);
    return error === null;
  }

  byId("ask-form").addEventListener("submit", async (event) => {
    event.preventDefault();
    const { submitter } = /** @type {SubmitEvent} */ (event);
    const button = /** @type {HTMLButtonElement | null} */ (submitter);
    const text = field("goal").value.trim();
    if (text === "") {
      showLines(["Say what to go to, for example: yellow chair."]);
      field("goal").focus();
      return;
    }
    const accepted = await ask(text, button?.value === "now");
    if (accepted && field("goal").value.trim() === text) field("goal").value = "";
  });
  for (const [id, [path, success]] of Object.entries(TASK_BUTTONS)) {
    byId(id).addEventListener("click", async () => {
      const { error } = await requests.post(path);
      showLines([error === null ? success : refusalText(error)]);
    });
  }
  byId("yes").addEventListener("click", () => {
    byId("answer").focus(); // the button vanishes, and the text field would bring up a phone's keyboard
    sayYes?.();
  });
  byId("no").addEventListener("click", () => {
    dismissQuestion();
    byId("answer").focus();
    showLines(["Nothing was asked for."]);
  });
  function dismissQuestion() {
    sayYes = null;
    byId("doubt").hidden = true;
  }

  return { showAnswer, showLines, dismissQuestion };
}
