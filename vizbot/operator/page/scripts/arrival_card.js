// @ts-check
/**
 * The card that asks, after an arrival, whether that is what was asked for.
 *
 * @typedef {object} Arrival
 * @property {number} number Of the task.
 * @property {string} text
 * @property {string} headline The outcome in words.
 * @property {boolean} has_picture
 * @property {boolean | null} confirmed What somebody has said.
 */

import { byId, setText } from "./dom.js";
import { STEP_TIMEOUT, refusalText } from "./http.js";

/**
 * @param {import("./http.js").PendingRequests} requests
 * @param {() => string} who
 */
export function createArrivalCard(requests, who) {
  const image = /** @type {HTMLImageElement} */ (byId("arrival-picture"));
  let shown = 0;
  let refusal = "";

  /** @param {Arrival | null} arrival */
  function update(arrival) {
    byId("arrival").hidden = arrival === null;
    if (arrival === null) {
      shown = 0;
      return;
    }
    if (arrival.number !== shown) {
      shown = arrival.number;
      refusal = "";
      image.hidden = !arrival.has_picture;
      if (arrival.has_picture) image.src = `/pictures/arrival.jpg?task=${arrival.number}`;
      image.alt = `What it took for “${arrival.text}”, in a green box`;
    }
    setText(byId("arrival-title"), arrival.headline);
    setText(byId("arrival-question"), refusal || questionText(arrival.confirmed));
    byId("arrival-answers").hidden = arrival.confirmed !== null;
  }

  /** @param {boolean} confirmed */
  async function judge(confirmed) {
    const content = { confirmed, who: who() };
    const { error } = await requests.post("/verdict", content, STEP_TIMEOUT);
    refusal = error === null ? "" : refusalText(error);
    byId("arrival").focus({ preventScroll: true }); // the buttons vanish
  }

  byId("arrival-yes").addEventListener("click", () => judge(true));
  byId("arrival-no").addEventListener("click", () => judge(false));
  return { update };
}

/** @param {boolean | null} confirmed */
function questionText(confirmed) {
  if (confirmed === null) return "Is this it?";
  return confirmed ? "Yes: this is it." : "No: this is not it, and it searches on.";
}
