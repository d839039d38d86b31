// @ts-check
/**
 * The console: watches the robot, asks it, drives it by hand, stops it.
 *
 * @typedef {import("./state_view.js").State} State
 */

import { createAsking } from "./goal_form.js";
import { createChoice, createPictureChoice } from "./button_rows.js";
import { byId, field } from "./dom.js";
import { createHands, createStick, KEYS } from "./drive_input.js";
import { createLive, createStop, keepToken, takeTokenFromAddress } from "./connection.js";
import { createMap } from "./map_view.js";
import { createMaps } from "./saved_maps.js";
import { createPlaces } from "./map_places.js";
import { createRenewal } from "./refresh.js";
import { createWishes } from "./http.js";
import { showLink, showPicture, showState, showWheel } from "./state_view.js";
import { createTalk } from "./push_to_talk.js";
import { createWheel, SPEEDS, STOPPED } from "./drive.js";
import { createZones } from "./keep_out_zones.js";

const TALK_KEY = "KeyT";

function listenToToken() {
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
 * @param {ReturnType<typeof createTalk>} talk
 * @param {() => void} stop
 */
function listenToKeys(hands, wheel, talk, stop) {
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
    } else if (event.code === TALK_KEY && !isTyping(event)) {
      if (!event.repeat) talk.hold();
    }
  });
  document.addEventListener("keyup", (event) => {
    hands.lift(event.code);
    if (event.code === TALK_KEY) talk.release();
    if (event.code === "Space" && !isTyping(event)) event.preventDefault();
  });
}

/**
 * @param {ReturnType<typeof createWheel>} wheel
 * @param {ReturnType<typeof createTalk>} talk
 */
function listenToLeaving(wheel, talk) {
  const letGo = () => {
    wheel.letGo();
    talk.drop();
  };
  window.addEventListener("blur", letGo);
  document.addEventListener("visibilitychange", letGo);
  document.addEventListener("focusin", (event) => {
    if (isTyping(event)) wheel.letGo();
  });
  window.addEventListener("pagehide", () => wheel.leave());
}

function start() {
  takeTokenFromAddress();
  watchViewport();
  const who = createName();
  const wishes = createWishes();
  const { stop: sendStop, repeat: repeatStop } = createStop(who);
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
    wishes.callOff();
    asking.forget();
    sendStop();
    wheel.leave();
    talk.drop(); // what was being said is not to set it going again
  }

  /** @param {State} newest */
  function onState(newest) {
    if (newest.stopped && state?.stopped === false && wheel.holds()) wheel.leave(STOPPED);
    if (state?.stopped && !newest.stopped) ended = "";
    if (newest.wheel !== state?.wheel && state?.wheel === null) ended = "";
    state = newest;
    map.follow(state);
    renewal.follow(state);
    showState(state, wheel.holds());
    showWheel(state, wheel.holds(), state.wheel === null ? ended : "");
  }

  /** @type {{open: () => void} | null} */
  let live = null;
  const pictures = createPictureChoice(() => live?.open());
  const map = createMap(wheel.holds);
  /** @type {(place: [number, number] | null) => void} */
  const showPlace = (place) => {
    places.find(place);
    if (place && !wheel.holds()) pictures.choose("map");
  };
  byId("goals").addEventListener("click", ({ target }) => {
    const place = /** @type {HTMLElement} */ (target).dataset.place;
    if (place) showPlace(JSON.parse(place));
  });
  const asking = createAsking(wishes, who, showPlace);
  const places = createPlaces(wishes, map, asking.tell);
  const talk = createTalk(wishes, who, asking.tell, asking.show);
  const renewal = createRenewal([createZones(map, places.tool).renew, createMaps().renew]);
  map.use(places.tool);
  live = createLive({
    onState,
    onPicture: showPicture,
    onLink: (link) => {
      showLink(link);
      if (link !== "live") return;
      repeatStop();
      renewal.start();
    },
    wanted: pictures.wanted,
  });
  createChoice(document.querySelectorAll("#speeds button"), "speed", pace, (value) => {
    pace = value;
  });
  byId("stop").addEventListener("pointerdown", stop); // a second finger makes no click
  byId("stop-form").addEventListener("submit", (event) => {
    event.preventDefault();
    stop();
  });
  byId("wheel").addEventListener("click", () => {
    if (wheel.holds()) wheel.giveBack();
    else wheel.take(who(), (state?.wheel ?? null) !== null);
  });
  listenToToken();
  listenToKeys(hands, wheel, talk, stop);
  listenToLeaving(wheel, talk);
  live.open();
}

/** Tells the style sheet what of the page's height is out of sight, above and below [px]. */
function watchViewport() {
  const seen = window.visualViewport;
  if (!seen) return;
  const page = document.documentElement;

  function measure() {
    if (!seen) return;
    const below = page.clientHeight - seen.offsetTop - seen.height;
    page.style.setProperty("--unseen-above", `${Math.max(0, seen.offsetTop)}px`);
    page.style.setProperty("--unseen-below", `${Math.max(0, below)}px`);
  }

  seen.addEventListener("resize", measure);
  seen.addEventListener("scroll", measure);
  measure();
}

start();
