// @ts-check
/**
 * What the robot was asked for: each task with what can be done about it.
 *
 * @typedef {import("./state_view.js").Point} Point
 * @typedef {import("./state_view.js").State} State
 * @typedef {import("./state_view.js").TaskState} TaskState
 */

import { byId, capitalised, createElement, updateList } from "./dom.js";
import { refusalText, request } from "./http.js";
import { getOwnName, plainWords, withPeople } from "./words.js";

/** @type {Record<string, string>} Of what is no search. */
const OUTCOMES = {
  arrived: "Arrived",
  located: "Done",
  explored: "Has seen all there is",
  gave_up: "Not done",
  stuck: "Got stuck",
};
const GOOD = ["arrived", "located", "explored"];

/**
 * @param {import("./http.js").PendingRequests} requests
 * @param {() => string} who
 * @param {(place: Point) => void} showPlace
 * @param {(lines: string[]) => void} showAnswer
 */
export function createTaskList(requests, who, showPlace, showAnswer) {
  /** @type {Record<string, (path: string) => Promise<import("./http.js").Reply>>} By button. */
  const changes = {
    cancel: (path) => request("DELETE", path, { who: who() }),
    next: (path) => request("POST", `${path}/next`),
    again: (path) => requests.post(`${path}/again`),
  };

  byId("goals").addEventListener("click", async ({ target }) => {
    const { action = "", task, place } = /** @type {HTMLElement} */ (target).dataset;
    if (place) showPlace(JSON.parse(place));
    const reply = await changes[action]?.(`/tasks/${task}`);
    if (reply?.error) showAnswer([refusalText(reply.error)]);
  });
  byId("clear").addEventListener("click", async () => {
    byId("goals").focus({ preventScroll: true }); // the button vanishes
    const { error } = await request("DELETE", "/tasks");
    if (error !== null) showAnswer([refusalText(error)]);
  });
}

/** @param {State} state */
export function showTasks({ goals, stopped, wheel }) {
  const over = goals.filter((goal) => goal.outcome !== null).reverse();
  const ahead = goals.filter((goal) => goal.outcome === null);
  const first = stopped || wheel !== null ? "Waits" : "Doing this now";
  byId("go-on").hidden = !(stopped && ahead.length);
  byId("clear").hidden = over.length === 0;
  updateList(byId("goals"), JSON.stringify([goals, first, getOwnName()]), () => [
    ...ahead.map((task, index) => aheadItem(task, index, first)),
    ...over.map(overItem),
    ...(goals.length ? [] : [createElement("li", "Nothing yet.", "quiet")]),
  ]);
}

/**
 * @param {TaskState} task
 * @param {number} index 0 for the running one, 1 for the next.
 * @param {string} first What is said of the running one.
 */
function aheadItem(task, index, first) {
  const status = index ? "Waits for its turn" : first;
  return taskItem(task, status, index ? "" : "running", [
    ...(index > 1 ? [actionButton("next", "Next", `Do ${task.text} next`, task)] : []),
    actionButton("cancel", "\u00d7", `Cancel ${task.text}`, task),
  ]);
}

/** @param {TaskState} task */
function overItem(task) {
  const buttons = [actionButton("again", "Ask again", `Ask again: ${task.text}`, task)];
  if (task.position !== null) {
    const show = actionButton("show", "Show on the map", `Show ${task.text} on the map`, task);
    show.dataset.place = JSON.stringify(task.position.slice(0, 2));
    buttons.push(show);
  }
  return taskItem(task, outcomeText(task), isGood(task) ? "good" : "poor", buttons);
}

/** @param {TaskState} task */
function isGood({ outcome }) {
  return outcome !== null && GOOD.includes(outcome);
}

/** @param {TaskState} task */
function outcomeText({ headline, outcome, reason }) {
  const why = withPeople(plainWords(reason));
  if (headline !== null) return capitalised(why);
  const word = OUTCOMES[outcome ?? ""] ?? outcome ?? "";
  return why ? `${word}: ${why}` : word;
}

/**
 * @param {TaskState} task
 * @param {string} status
 * @param {string} className
 * @param {HTMLElement[]} buttons
 */
function taskItem({ text, headline }, status, className, buttons) {
  const item = createElement("li", "", className);
  const words = createElement("div", "");
  words.append(createElement("b", headline ?? capitalised(text)), createElement("span", status));
  const row = createElement("div", "", "row");
  row.append(...buttons);
  item.append(words, row);
  return item;
}

/**
 * @param {string} action
 * @param {string} text
 * @param {string} name What a screen reader calls it.
 * @param {TaskState} task
 */
function actionButton(action, text, name, { number }) {
  const button = createElement("button", text);
  button.id = `${action}-${number}`;
  button.title = name;
  button.setAttribute("aria-label", name);
  Object.assign(button.dataset, { action, task: number });
  return button;
}
