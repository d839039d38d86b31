// @ts-check
/**
 * Push-to-talk: records speech while a button or a key is held, and sends it on release.
 *
 * @typedef {import("./goal_form.js").Answer} Answer
 */

import { byId, setText } from "./dom.js";
import { refusalText } from "./http.js";

/** Of a recording [ms]. */
const MAX_DURATION = 15000;
/** Of the recording: speech needs no more [bits/s]. */
const BIT_RATE = 32000;
/** Of the request: the robot takes its time to understand speech [ms]. */
const SPEECH_TIMEOUT = 60000;
const IDLE = "Hold to talk";
const INSECURE =
  "To talk to it, open this page on the robot's own machine or over https: browsers give the microphone" +
  " to no other page.";
/** @type {Record<string, string>} By the name of the browser's error. */
const REFUSALS = {
  NotAllowedError: "This page may not use the microphone; allow it in the browser.",
  NotFoundError: "There is no microphone here.",
};

/** Why this browser cannot record speech; null where it can. */
function unsupportedReason() {
  if (!window.isSecureContext) return INSECURE;
  const able = "mediaDevices" in navigator && "MediaRecorder" in window;
  return able ? null : "This browser cannot record what you say; type it instead.";
}

/** @typedef {{recorder: MediaRecorder | null, wanted: boolean}} Hold */

/**
 * @param {import("./http.js").PendingRequests} requests
 * @param {() => string} who
 * @param {(lines: string[]) => void} showLines
 * @param {(answer: Answer, atOnce: boolean) => void} showAnswer
 */
export function createTalk(requests, who, showLines, showAnswer) {
  const button = byId("talk");
  /** @type {Hold | null} */
  let held = null;
  let timer = 0;

  async function hold() {
    if (held || button.hidden) return;
    /** @type {Hold} */
    const current = { recorder: null, wanted: false };
    held = current;
    setLabel("Just a moment");
    try {
      const stream = await navigator.mediaDevices.getUserMedia({ audio: true });
      // the browser may have asked the person, who has released the button since
      if (held === current) current.recorder = record(stream, current);
      else stopTracks(stream);
    } catch (error) {
      if (held !== current) return;
      reset();
      const { name, message } = /** @type {Error} */ (error);
      showLines([REFUSALS[name] ?? `The microphone does not work: ${message}.`]);
    }
  }

  /**
   * @param {MediaStream} stream
   * @param {Hold} current
   */
  function record(stream, current) {
    /** @type {Blob[]} */
    const parts = [];
    const recorder = new MediaRecorder(stream, { audioBitsPerSecond: BIT_RATE });
    recorder.ondataavailable = ({ data }) => parts.push(data);
    recorder.onstop = () => {
      stopTracks(stream);
      if (held === current) reset(); // the microphone was pulled out
      if (current.wanted) send(new Blob(parts, { type: recorder.mimeType }));
      else showLines(["What you said was not sent."]);
    };
    recorder.start();
    timer = setTimeout(release, MAX_DURATION);
    setLabel("Let go to send");
    showLines(["Listening."]);
    return recorder;
  }

  /** @param {Blob} recording */
  async function send(recording) {
    showLines(["Working out what you said."]);
    const path = `/heard?${new URLSearchParams({ who: who() })}`;
    const { answer, error } = await requests.post(path, recording, SPEECH_TIMEOUT);
    if (error === null) showAnswer(answer, false);
    else showLines([refusalText(error)]);
  }

  /** @param {boolean} sends */
  function end(sends) {
    const current = held;
    if (current === null) return;
    reset();
    current.wanted = sends;
    if (current.recorder) current.recorder.stop();
    else showLines(["Hold it for as long as you speak."]);
  }

  const release = () => end(true);
  const cancel = () => end(false);

  function reset() {
    clearTimeout(timer);
    held = null;
    setLabel(IDLE);
  }

  /** @param {string} text */
  function setLabel(text) {
    setText(byId("talk-text"), text);
    button.setAttribute("aria-pressed", `${held !== null}`);
  }

  listenToButton(button, { hold, release, cancel });
  const unsupported = unsupportedReason();
  button.hidden = unsupported !== null;
  byId("no-talk").hidden = unsupported === null;
  setText(byId("no-talk"), unsupported ?? "");
  return { hold, release, cancel };
}

/**
 * @param {HTMLElement} button
 * @param {Record<"hold" | "release" | "cancel", () => void>} talk
 */
function listenToButton(button, { hold, release, cancel }) {
  button.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    button.setPointerCapture(event.pointerId);
    hold();
  });
  button.addEventListener("pointerup", release);
  button.addEventListener("pointercancel", cancel);
  // a finger that rests on the button asks for no menu
  button.addEventListener("contextmenu", (event) => event.preventDefault());
  button.addEventListener("keydown", (event) => {
    if (event.code === "Enter" && !event.repeat) hold();
  });
  button.addEventListener("keyup", (event) => {
    if (event.code === "Enter") release();
  });
  button.addEventListener("blur", cancel);
}

/** @param {MediaStream} stream */
function stopTracks(stream) {
  for (const track of stream.getTracks()) track.stop();
}
