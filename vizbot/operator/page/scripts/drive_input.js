// @ts-check
/**
 * What a person drives with: keys, the stick, a gamepad.
 *
 * @typedef {{forward: number, left: number}} DriveVector From -1 to 1 each.
 */

import { byId } from "./dom.js";

const DEAD_ZONE = 0.12;
/** @type {DriveVector} */
const REST = Object.freeze({ forward: 0, left: 0 });
/** @type {Record<string, DriveVector>} By position on the keyboard, whatever is printed there. */
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
function clamp(value) {
  return Math.max(-1, Math.min(1, value));
}

/** @param {(pressed: boolean) => void} onGamepadButton */
export function createDriveInput(onGamepadButton) {
  /** @type {Set<string>} */
  const pressed = new Set();
  /** @type {DriveVector} */
  let stick = REST;
  /** A gamepad's stick that was held when driving began, or at a reset, counts once it was centred. */
  let centred = false;

  /** @returns {DriveVector} */
  function gamepad() {
    const pads = navigator.getGamepads?.() ?? [];
    const pad = [...pads].find((one) => one?.connected);
    if (!pad) return REST;
    onGamepadButton(pad.buttons.some((button) => button.pressed));
    const [x, y] = [pad.axes[0] ?? 0, pad.axes[1] ?? 0];
    const still = Math.hypot(x, y) < DEAD_ZONE;
    centred = centred || still;
    return still || !centred ? REST : { forward: -y, left: -x };
  }

  /** @returns {DriveVector} The sum of all inputs. */
  function read() {
    const vectors = [...[...pressed].flatMap((code) => KEYS[code] ?? []), stick, gamepad()];
    if (document.visibilityState !== "visible" || !document.hasFocus()) return REST;
    const sum = (/** @type {keyof DriveVector} */ axis) =>
      clamp(vectors.reduce((total, vector) => total + vector[axis], 0));
    return { forward: sum("forward"), left: sum("left") };
  }

  return {
    read,
    /** @param {string} code */
    pressKey: (code) => pressed.add(code),
    /** @param {string} code */
    releaseKey: (code) => pressed.delete(code),
    /** @param {DriveVector} vector */
    moveStick: (vector) => {
      stick = vector;
    },
    reset: () => {
      pressed.clear();
      stick = REST;
      centred = false;
    },
  };
}

/**
 * @param {(vector: DriveVector) => void} onMove Called when the stick moves, and with rest on its release.
 * @returns {{release: () => void, show: (vector: DriveVector) => void}} `show` moves the knob as if
 *   the stick were pulled there, unless somebody holds it.
 */
export function createStick(onMove) {
  const [stick, knob] = [byId("stick"), byId("knob")];
  /** @type {number | null} */
  let pointerId = null;

  /** @param {PointerEvent} event */
  function move(event) {
    if (event.pointerId !== pointerId) return;
    const box = stick.getBoundingClientRect();
    const radius = box.width / 2;
    let x = (event.clientX - box.left - radius) / radius;
    let y = (event.clientY - box.top - radius) / radius;
    const reach = Math.max(1, Math.hypot(x, y));
    [x, y] = [x / reach, y / reach];
    place(x, y);
    onMove(Math.hypot(x, y) < DEAD_ZONE ? REST : { forward: -y, left: -x });
  }

  /** @param {number} x @param {number} y From -1 to 1, down and to the right. */
  function place(x, y) {
    const radius = 0.6 * (stick.clientWidth / 2);
    knob.style.transform = x === 0 && y === 0 ? "" : `translate(${x * radius}px, ${y * radius}px)`;
  }

  function release() {
    pointerId = null;
    knob.style.transform = "";
    onMove(REST);
  }

  stick.addEventListener("pointerdown", (event) => {
    if (pointerId !== null) return;
    pointerId = event.pointerId;
    stick.setPointerCapture(pointerId);
    move(event);
  });
  stick.addEventListener("pointermove", move);
  for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
    stick.addEventListener(end, (event) => {
      if (/** @type {PointerEvent} */ (event).pointerId === pointerId) release();
    });
  }
  return {
    release,
    show: ({ forward, left }) => {
      if (pointerId !== null) return;
      const reach = Math.max(1, Math.hypot(forward, left));
      place(-left / reach, -forward / reach);
    },
  };
}
