// @ts-check
/**
 * The console: watches the robot, asks it, drives it by hand, stops it.
 *
 * @typedef {import("./state_view.js").State} State
 */

import { createGoalForm } from "./goal_form.js";
import { createChoice, createPictureChoice } from "./button_rows.js";
import { byId, field, hideBrokenImages, setText } from "./dom.js";
import { createDriveInput, createStick, KEYS } from "./drive_input.js";
import { createLiveLink, createStop, storeToken, moveTokenOutOfAddress } from "./connection.js";
import { createMap } from "./map/view.js";
import { createSavedMaps } from "./saved_maps.js";
import { createArrivalCard, createCandidateCard } from "./place_cards.js";
import { createPlaces } from "./map/places.js";
import { createRooms } from "./map/rooms.js";
import { createRefresh } from "./refresh.js";
import { createPendingRequests } from "./http.js";
import { showDriving, showLink, showPicture, showState } from "./state_view.js";
import { createSuggestions } from "./suggestions.js";
import { createTalk } from "./push_to_talk.js";
import { createTaskList } from "./task_list.js";
import { createDriveLease, SPEEDS, STOPPED } from "./drive.js";
import { createZones } from "./map/keep_out_zones.js";
import { makeUnnamed, setOwnName } from "./words.js";

const TALK_KEY = "KeyT";

/** @param {() => void} retry */
function listenToToken(retry) {
  byId("token-form").addEventListener("submit", (event) => {
    event.preventDefault();
    storeToken(field("token").value.trim());
    field("token").value = "";
    setText(byId("token-refused"), "");
    retry();
  });
}

/**
 * Asks once for the name of the person at this page, which the browser keeps.
 *
 * @returns {() => string} The name that is sent to the robot.
 */
function createName() {
  const name = field("name");
  const unnamed = stored("unnamed") ?? makeUnnamed();
  store("unnamed", unnamed);
  const who = () => name.value.trim() || unnamed;

  /** @param {boolean} asks */
  function ask(asks) {
    byId("name-asked").hidden = !asks;
    byId("name-known").hidden = asks;
    setText(byId("name-shown"), `Others see you as ${name.value.trim() || "somebody else"}.`);
  }

  function keep() {
    setOwnName(who());
    store("name", name.value.trim());
  }

  name.value = stored("name") ?? "";
  ask(stored("name") === null);
  setOwnName(who());
  name.addEventListener("change", keep);
  byId("name-form").addEventListener("submit", (event) => {
    event.preventDefault();
    keep();
    ask(false);
    byId("name-change").focus();
  });
  byId("name-change").addEventListener("click", () => {
    ask(true);
    name.focus();
  });
  return who;
}

/** @param {string} key */
function stored(key) {
  try {
    return localStorage.getItem(key);
  } catch {
    return null; // this browser stores nothing; the page does without
  }
}

/**
 * @param {string} key
 * @param {string} value
 */
function store(key, value) {
  try {
    localStorage.setItem(key, value);
  } catch {
    // this browser stores nothing; the page does without
  }
}

/** @param {Event} event */
function isTyping({ target }) {
  return target instanceof HTMLInputElement;
}

/**
 * @param {ReturnType<typeof createDriveInput>} driveInput
 * @param {ReturnType<typeof createDriveLease>} lease
 * @param {ReturnType<typeof createTalk>} talk
 * @param {() => void} stop
 */
function listenToKeys(driveInput, lease, talk, stop) {
  document.addEventListener("keydown", (event) => {
    const stops = event.code === "Escape" || (event.code === "Space" && !isTyping(event));
    if (stops) {
      event.preventDefault();
      if (!event.repeat) stop();
    } else if (event.ctrlKey || event.altKey || event.metaKey) {
      lease.stopMotion(); // some systems report no key that is released meanwhile
    } else if (event.code in KEYS && !isTyping(event) && lease.isHeld()) {
      event.preventDefault();
      if (!event.repeat) driveInput.pressKey(event.code);
    } else if (event.code === TALK_KEY && !isTyping(event)) {
      if (!event.repeat) talk.hold();
    }
  });
  document.addEventListener("keyup", (event) => {
    driveInput.releaseKey(event.code);
    if (event.code === TALK_KEY) talk.release();
    if (event.code === "Space" && !isTyping(event)) event.preventDefault();
  });
}

/**
 * @param {ReturnType<typeof createDriveLease>} lease
 * @param {ReturnType<typeof createTalk>} talk
 */
function listenToLeaving(lease, talk) {
  const stopInput = () => {
    lease.stopMotion();
    talk.cancel();
  };
  window.addEventListener("blur", stopInput);
  document.addEventListener("visibilitychange", stopInput);
  document.addEventListener("focusin", (event) => {
    if (isTyping(event)) lease.stopMotion();
  });
  window.addEventListener("pagehide", () => lease.abandon());
}

function start() {
  hideBrokenImages();
  moveTokenOutOfAddress();
  watchViewport();
  const who = createName();
  const requests = createPendingRequests();
  const { stop: sendStop, resend: resendStop } = createStop(who);
  /** @type {State | null} */
  let state = null;
  /** @type {keyof typeof SPEEDS} */
  let pace = "normal";
  let [endReason, buttonDown] = ["", false];

  const driveInput = createDriveInput((pressed) => {
    if (pressed && !buttonDown) stop();
    buttonDown = pressed;
  });
  const stick = createStick(driveInput.moveStick);
  const lease = createDriveLease({
    input: () => {
      const vector = driveInput.read();
      stick.show(vector);
      return vector;
    },
    speed: () => SPEEDS[pace],
    resetInput: () => {
      stick.release();
      driveInput.reset();
    },
    onChange: (driving, reason) => {
      endReason = reason;
      if (driving) [globalThis, byId("page"), byId("side")].forEach((each) => each.scrollTo({ top: 0 }));
      if (driving && state) showState(state, true);
      showDriving(driving ? state : null, driving, reason);
    },
  });

  function stop() {
    requests.abortAll();
    goalForm.dismissQuestion();
    sendStop();
    lease.abandon();
    talk.cancel(); // a sentence that is being spoken must not start the robot again
  }

  /** @param {State} newest */
  function onState(newest) {
    if (newest.stopped && state?.stopped === false && lease.isHeld()) lease.abandon(STOPPED);
    if (state?.stopped && !newest.stopped) endReason = "";
    if (newest.wheel !== state?.wheel && state?.wheel === null) endReason = "";
    state = newest;
    map.update(state);
    refresh.update(state);
    arrivalCard.update(state.arrival);
    candidateCard.update(state.candidate);
    showState(state, lease.isHeld());
    showDriving(state, lease.isHeld(), state.wheel === null ? endReason : "");
  }

  /** @type {ReturnType<typeof createLiveLink> | null} */
  let live = null;
  const pictures = createPictureChoice(() => live?.open());
  const map = createMap(lease.isHeld);
  /** @type {(place: [number, number] | null) => void} */
  const showPlace = (place) => {
    places.markFound(place);
    if (place && !lease.isHeld()) pictures.choose("map");
  };
  const goalForm = createGoalForm(requests, who, showPlace);
  createTaskList(requests, who, showPlace, goalForm.showLines);
  const arrivalCard = createArrivalCard(requests, who);
  const candidateCard = createCandidateCard(requests, who);
  createSuggestions();
  const places = createPlaces(requests, map, goalForm.showLines);
  const talk = createTalk(requests, who, goalForm.showLines, goalForm.showAnswer);
  const zones = createZones(map, places.tool);
  const rooms = createRooms(map.overlay, () => pictures.wanted().includes("map"));
  const refresh = createRefresh([zones.refresh, createSavedMaps().refresh, rooms.refresh]);
  map.setTool(places.tool);
  live = createLiveLink({
    onState,
    onPicture: showPicture,
    onLink: (link) => {
      showLink(link);
      if (link !== "live") return;
      resendStop();
      refresh.invalidate();
    },
    wanted: pictures.wanted,
  });
  createChoice(document.querySelectorAll("#speeds button"), "speed", pace, (value) => {
    pace = /** @type {keyof typeof SPEEDS} */ (value);
  });
  byId("stop").addEventListener("pointerdown", stop); // a second finger makes no click
  byId("stop-form").addEventListener("submit", (event) => {
    event.preventDefault();
    stop();
  });
  byId("wheel").addEventListener("click", () => {
    if (lease.isHeld()) lease.giveBack();
    else lease.take(who(), (state?.wheel ?? null) !== null);
  });
  listenToToken(live.retry);
  listenToKeys(driveInput, lease, talk, stop);
  listenToLeaving(lease, talk);
  live.open();
}

/** Gives the style sheet the height of the page that is out of sight, above and below [px]. */
function watchViewport() {
  const viewport = window.visualViewport;
  if (!viewport) return;
  const page = document.documentElement;

  function measure() {
    if (!viewport) return;
    const below = page.clientHeight - viewport.offsetTop - viewport.height;
    page.style.setProperty("--unseen-above", `${Math.max(0, viewport.offsetTop)}px`);
    page.style.setProperty("--unseen-below", `${Math.max(0, below)}px`);
  }

  viewport.addEventListener("resize", measure);
  viewport.addEventListener("scroll", measure);
  measure();
}

start();
