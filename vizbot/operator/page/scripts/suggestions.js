// @ts-check
/** What the map finds, offered while a person types: the name that the last words begin. */

import { field } from "./dom.js";
import { STEP_TIMEOUT, request } from "./http.js";

/** What the map finds is asked for again after this time [ms]. */
const PERIOD = 10000;
const MOST = 8;

/**
 * @param {string} text What is typed so far.
 * @param {string[]} phrases
 * @returns {string[]} The text with its last words completed to each phrase that they begin.
 */
export function completions(text, phrases) {
  const starts = [...text.matchAll(/(?<!\S)\S/g)].map((found) => found.index);
  const found = phrases.flatMap((phrase) => {
    const start = starts.find((place) => phrase.startsWith(text.slice(place).toLowerCase()));
    return start === undefined || text.slice(start) === phrase ? [] : [text.slice(0, start) + phrase];
  });
  return found.slice(0, MOST);
}

/** Offers names in the field where a person types. */
export function createSuggestions() {
  const goal = field("goal");
  const list = document.createElement("datalist");
  list.id = "suggestions";
  goal.after(list);
  goal.setAttribute("list", list.id);
  /** @type {string[]} */
  let phrases = [];
  let askedAt = -Infinity;

  async function learn() {
    if (performance.now() - askedAt < PERIOD) return;
    askedAt = performance.now();
    const { answer, error } = await request("GET", "/map/vocabulary", undefined, STEP_TIMEOUT);
    if (error === null) phrases = answer.phrases;
    offer();
  }

  function offer() {
    const options = completions(goal.value, phrases).map((text) => new Option(text, text));
    list.replaceChildren(...options);
  }

  goal.addEventListener("focus", learn);
  goal.addEventListener("input", () => {
    learn();
    offer();
  });
}
