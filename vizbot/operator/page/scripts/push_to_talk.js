// @ts-check
/**
 * Push-to-talk: what is said while a button or a key is held is sent when it is let go.
 *
 * @typedef {import("./goal_form.js").Answer} Answer
 */

import { byId, show } from "./dom.js";
import { refusal } from "./http.js";

/** Nobody is listened to for longer [ms]. */
const LONGEST = 15000;
/** Of the recording: speech needs no more [bits/s]. */
const RATE = 32000;
/** For what the robot takes to understand it [ms]. */
const PATIENCE = 60000;
const IDLE = "Hold to talk";
const INSECURE =
  "To talk to it, open this page on the robot's own machine or over https: browsers give the microphone" +
  " to no other page.";
/** @type {Record<string, string>} By the name of the browser's error. */
const REFUSALS = {
  NotAllowedError: "This page may not use the microphone; allow it in the browser.",
  NotFoundError: "There is no microphone here.",
};

/** Why this browser lets nobody talk; null where it does. */
function reasonForSilence() {
  if (!window.isSecureContext) return INSECURE;
  const able = "mediaDevices" in navigator && "MediaRecorder" in window;
  return able ? null : "This browser cannot record what you say; type it instead.";
}

/** @typedef {{recorder: MediaRecorder | null, wanted: boolean}} Hold */

/**
 * @param {import("./http.js").Wishes} wishes
 * @param {() => string} who
 * @param {(lines: string[]) => void} tell
 * @param {(answer: Answer, atOnce: boolean) => void} answer
 */
export function createTalk(wishes, who, tell, answer) {
  const button = byId("talk");
  /** @type {Hold | null} */
  let held = null;
  let timer = 0;

  async function hold() {
    if (held || button.hidden) return;
    /** @type {Hold} */
    const mine = { recorder: null, wanted: false };
    held = mine;
    look("Just a moment");
    try {
      const stream = await navigator.mediaDevices.getUserMedia({ audio: true });
      // it may have asked the person, and taken as long
      if (held === mine) mine.recorder = record(stream, mine);
      else hangUp(stream);
    } catch (error) {
      if (held !== mine) return;
      rest();
      const { name, message } = /** @type {Error} */ (error);
      tell([REFUSALS[name] ?? `The microphone does not work: ${message}.`]);
    }
  }

  /**
   * @param {MediaStream} stream
   * @param {Hold} mine
   */
  function record(stream, mine) {
    /** @type {Blob[]} */
    const parts = [];
    const recorder = new MediaRecorder(stream, { audioBitsPerSecond: RATE });
    recorder.ondataavailable = ({ data }) => parts.push(data);
    recorder.onstop = () => {
      hangUp(stream);
      if (held === mine) rest(); // the microphone was pulled out
      if (mine.wanted) send(new Blob(parts, { type: recorder.mimeType }));
      else tell(["What you said was not sent."]);
    };
    recorder.start();
    timer = setTimeout(release, LONGEST);
    look("Let go to send");
    tell(["Listening."]);
    return recorder;
  }

  /** @param {Blob} recording */
  async function send(recording) {
    tell(["Working out what you said."]);
    const path = `/heard?${new URLSearchParams({ who: who() })}`;
    const { said, against } = await wishes.ask(path, recording, PATIENCE);
    if (against === null) answer(said, false);
    else tell([refusal(against)]);
  }

  /** @param {boolean} sends */
  function end(sends) {
    const mine = held;
    if (mine === null) return;
    rest();
    mine.wanted = sends;
    if (mine.recorder) mine.recorder.stop();
    else tell(["Hold it for as long as you speak."]);
  }

  const release = () => end(true);
  const drop = () => end(false);

  function rest() {
    clearTimeout(timer);
    held = null;
    look(IDLE);
  }

  /** @param {string} text */
  function look(text) {
    show(byId("talk-text"), text);
    button.setAttribute("aria-pressed", `${held !== null}`);
  }

  listenToButton(button, { hold, release, drop });
  const silent = reasonForSilence();
  button.hidden = silent !== null;
  byId("no-talk").hidden = silent === null;
  show(byId("no-talk"), silent ?? "");
  return { hold, release, drop };
}

/**
 * @param {HTMLElement} button
 * @param {Record<"hold" | "release" | "drop", () => void>} talk
 */
function listenToButton(button, { hold, release, drop }) {
  button.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    button.setPointerCapture(event.pointerId);
    hold();
  });
  button.addEventListener("pointerup", release);
  button.addEventListener("pointercancel", drop);
  // a finger that rests on it is no wish for a menu
  button.addEventListener("contextmenu", (event) => event.preventDefault());
  button.addEventListener("keydown", (event) => {
    if (event.code === "Enter" && !event.repeat) hold();
  });
  button.addEventListener("keyup", (event) => {
    if (event.code === "Enter") release();
  });
  button.addEventListener("blur", drop);
}

/** @param {MediaStream} stream */
function hangUp(stream) {
  for (const track of stream.getTracks()) track.stop();
}
