// @ts-check
/**
 * The console: watches the robot, asks it, drives it by hand, stops it.
 *
 * @typedef {import("./showing.js").State} State
 */

import { byId, field, show } from "./elements.js";
import { createHands, createStick, KEYS } from "./hands.js";
import { createLive, createStop, keepToken, PICTURES, post, takeTokenFromAddress } from "./links.js";
import { showLink, showPicture, showState, showWheel } from "./showing.js";
import { createWheel, SPEEDS } from "./wheel.js";

/**
 * A row of buttons of which one is pressed.
 *
 * @param {NodeListOf<HTMLElement>} buttons
 * @param {string} key Of their `data-`.
 * @param {string} first
 * @param {(value: string) => void} onChoice
 */
function createChoice(buttons, key, first, onChoice) {
  /** @param {string} value */
  const choose = (value) => {
    for (const button of buttons) {
      button.setAttribute("aria-pressed", `${button.dataset[key] === value}`);
    }
    onChoice(value);
  };
  for (const button of buttons) {
    button.addEventListener("click", () => choose(button.dataset[key] ?? first));
  }
  choose(first);
}

/** @param {() => void} onChange */
function createPictureChoice(onChange) {
  const wide = matchMedia("(min-width: 60rem)");
  let chosen = "colour";
  createChoice(document.querySelectorAll("#choices button"), "picture", chosen, (name) => {
    chosen = name;
    for (const figure of document.querySelectorAll("figure")) {
      figure.classList.toggle("shown", figure.dataset.picture === name);
    }
    onChange();
  });
  wide.addEventListener("change", onChange);
  return () => (wide.matches ? PICTURES : [chosen]);
}

function listenToAsking() {
  /** @param {string} text */
  const answer = (text) => show(byId("answer"), text);

  byId("ask-form").addEventListener("submit", async (event) => {
    event.preventDefault();
    const { submitter } = /** @type {SubmitEvent} */ (event);
    const button = /** @type {HTMLButtonElement | null} */ (submitter);
    const text = field("goal").value.trim();
    if (text === "") {
      answer("Say what to go to, for example: yellow chair.");
      field("goal").focus();
      return;
    }
    const against = await post("/goals", { texts: [text], at_once: button?.value === "now" });
    answer(against === null ? `Asked for “${text}”.` : `Not asked: ${against}.`);
    if (against === null) field("goal").value = "";
  });
  byId("explore").addEventListener("click", async () => {
    const against = await post("/explore");
    answer(against === null ? "Asked to explore." : `Not asked: ${against}.`);
  });
  byId("go-on").addEventListener("click", async () => {
    const against = await post("/continue");
    answer(against === null ? "Asked to go on." : `Not asked: ${against}.`);
  });
  byId("token-form").addEventListener("submit", (event) => {
    event.preventDefault();
    keepToken(field("token").value.trim());
    field("token").value = "";
  });
}

/** @returns {() => string} The name of whoever looks at this page. */
function createName() {
  const name = field("name");
  const unnamed = matchMedia("(pointer: coarse)").matches ? "a phone" : "a computer";
  name.placeholder = unnamed;
  try {
    name.value = localStorage.getItem("name") ?? "";
    name.addEventListener("change", () => localStorage.setItem("name", name.value.trim()));
  } catch {
    // this browser keeps nothing; the page does without
  }
  return () => name.value.trim() || unnamed;
}

/** @param {Event} event */
function isTyping({ target }) {
  return target instanceof HTMLInputElement;
}

/**
 * @param {ReturnType<typeof createHands>} hands
 * @param {ReturnType<typeof createWheel>} wheel
 * @param {() => void} stop
 */
function listenToKeys(hands, wheel, stop) {
  document.addEventListener("keydown", (event) => {
    const stops = event.code === "Escape" || (event.code === "Space" && !isTyping(event));
    if (stops) {
      event.preventDefault();
      if (!event.repeat) stop();
    } else if (event.ctrlKey || event.altKey || event.metaKey) {
      wheel.letGo(); // some systems tell of no key that is lifted meanwhile
    } else if (event.code in KEYS && !isTyping(event) && wheel.holds()) {
      event.preventDefault();
      if (!event.repeat) hands.press(event.code);
    }
  });
  document.addEventListener("keyup", (event) => {
    hands.lift(event.code);
    if (event.code === "Space" && !isTyping(event)) event.preventDefault();
  });
}

/** @param {ReturnType<typeof createWheel>} wheel */
function listenToLeaving(wheel) {
  window.addEventListener("blur", () => wheel.letGo());
  document.addEventListener("visibilitychange", () => wheel.letGo());
  document.addEventListener("focusin", (event) => {
    if (isTyping(event)) wheel.letGo();
  });
  window.addEventListener("pagehide", () => wheel.leave());
}

function start() {
  takeTokenFromAddress();
  const who = createName();
  const sendStop = createStop(who);
  /** @type {State | null} */
  let state = null;
  let [pace, ended, buttonDown] = ["normal", "", false];

  const hands = createHands((pressed) => {
    if (pressed && !buttonDown) stop();
    buttonDown = pressed;
  });
  const letGoOfStick = createStick(hands.pull);
  const wheel = createWheel({
    wish: hands.wish,
    speed: () => SPEEDS[pace],
    letGo: () => {
      letGoOfStick();
      hands.letGo();
    },
    onChange: (driving, why) => {
      ended = why;
      if (driving) scrollTo({ top: 0 });
      if (driving && state) showState(state, true);
      showWheel(driving ? state : null, driving, why);
    },
  });

  function stop() {
    sendStop();
    wheel.leave();
  }

  /** @param {State} newest */
  function onState(newest) {
    if (newest.stopped && state?.stopped === false && wheel.holds()) wheel.leave();
    if (newest.wheel !== state?.wheel && state?.wheel === null) ended = "";
    state = newest;
    showState(state, wheel.holds());
    showWheel(state, wheel.holds(), state.wheel === null ? ended : "");
  }

  /** @type {{open: () => void} | null} */
  let live = null;
  const wanted = createPictureChoice(() => live?.open());
  live = createLive({ onState, onPicture: showPicture, onLink: showLink, wanted });
  createChoice(document.querySelectorAll("#speeds button"), "speed", pace, (value) => {
    pace = value;
  });
  byId("stop-form").addEventListener("submit", (event) => {
    event.preventDefault();
    stop();
  });
  byId("wheel").addEventListener("click", () => {
    if (wheel.holds()) wheel.giveBack();
    else wheel.take(who(), (state?.wheel ?? null) !== null);
  });
  listenToAsking();
  listenToKeys(hands, wheel, stop);
  listenToLeaving(wheel);
  live.open();
}

start();
