// @ts-check
/**
 * What hands ask for: keys, the stick, a gamepad.
 *
 * @typedef {{forward: number, left: number}} Wish From -1 to 1 each.
 */

import { byId } from "./dom.js";

const DEAD_ZONE = 0.12;
/** @type {Wish} */
const REST = Object.freeze({ forward: 0, left: 0 });
/** @type {Record<string, Wish>} By place on the keyboard, whatever is printed there. */
export const KEYS = {
  KeyW: { forward: 1, left: 0 },
  ArrowUp: { forward: 1, left: 0 },
  KeyS: { forward: -1, left: 0 },
  ArrowDown: { forward: -1, left: 0 },
  KeyA: { forward: 0, left: 1 },
  ArrowLeft: { forward: 0, left: 1 },
  KeyD: { forward: 0, left: -1 },
  ArrowRight: { forward: 0, left: -1 },
};

/** @param {number} value */
function within(value) {
  return Math.max(-1, Math.min(1, value));
}

/** @param {(pressed: boolean) => void} onGamepadButton */
export function createHands(onGamepadButton) {
  /** @type {Set<string>} */
  const held = new Set();
  /** @type {Wish} */
  let pulled = REST;
  /** A stick that was held when driving began, or when all was let go, counts after its rest. */
  let rested = false;

  /** @returns {Wish} */
  function gamepad() {
    const pads = navigator.getGamepads?.() ?? [];
    const pad = [...pads].find((one) => one?.connected);
    if (!pad) return REST;
    onGamepadButton(pad.buttons.some((button) => button.pressed));
    const [x, y] = [pad.axes[0] ?? 0, pad.axes[1] ?? 0];
    const still = Math.hypot(x, y) < DEAD_ZONE;
    rested = rested || still;
    return still || !rested ? REST : { forward: -y, left: -x };
  }

  /** @returns {Wish} */
  function wish() {
    const wishes = [...held].map((code) => KEYS[code]).concat(pulled, gamepad());
    if (document.visibilityState !== "visible" || !document.hasFocus()) return REST;
    const sum = (/** @type {keyof Wish} */ way) => within(wishes.reduce((all, one) => all + one[way], 0));
    return { forward: sum("forward"), left: sum("left") };
  }

  return {
    wish,
    /** @param {string} code */
    press: (code) => held.add(code),
    /** @param {string} code */
    lift: (code) => held.delete(code),
    /** @param {Wish} to */
    pull: (to) => {
      pulled = to;
    },
    letGo: () => {
      held.clear();
      pulled = REST;
      rested = false;
    },
  };
}

/**
 * @param {(to: Wish) => void} pull Called when the stick moves, and with rest when it is let go.
 * @returns {() => void} Lets go of it.
 */
export function createStick(pull) {
  const [stick, knob] = [byId("stick"), byId("knob")];
  /** @type {number | null} */
  let finger = null;

  /** @param {PointerEvent} event */
  function move(event) {
    if (event.pointerId !== finger) return;
    const box = stick.getBoundingClientRect();
    const radius = box.width / 2;
    let x = (event.clientX - box.left - radius) / radius;
    let y = (event.clientY - box.top - radius) / radius;
    const reach = Math.max(1, Math.hypot(x, y));
    [x, y] = [x / reach, y / reach];
    knob.style.transform = `translate(${x * radius * 0.6}px, ${y * radius * 0.6}px)`;
    pull(Math.hypot(x, y) < DEAD_ZONE ? REST : { forward: -y, left: -x });
  }

  function letGo() {
    finger = null;
    knob.style.transform = "";
    pull(REST);
  }

  stick.addEventListener("pointerdown", (event) => {
    if (finger !== null) return;
    finger = event.pointerId;
    stick.setPointerCapture(finger);
    move(event);
  });
  stick.addEventListener("pointermove", move);
  for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
    stick.addEventListener(end, (event) => {
      if (/** @type {PointerEvent} */ (event).pointerId === finger) letGo();
    });
  }
  return letGo;
}
