// @ts-check
/**
 * The picture of the map, on which a person points by mouse, by finger, or with the arrow keys.
 *
 * @typedef {import("./state_view.js").Point} Point
 * @typedef {import("./state_view.js").State} State
 * @typedef {object} Tool What pointing does. A key or a tap presses and releases at one point.
 * @property {(point: Point) => void} press
 * @property {(point: Point) => void} move Called while the pointer is down, and by the arrow keys.
 * @property {(point: Point) => void} release
 * @property {() => void} cancel Undoes a press that was not meant: the finger scrolls the page.
 * @property {() => void} reset Forgets all points.
 */

import { byId, setText } from "./dom.js";
import { clampToView, createOverlay } from "./map_overlay.js";

/** How far one press of an arrow key moves the cross, and with Shift [m]. */
const STEP = 0.1;
const LONG_STEP = 0.5;
/** Points that are so near count as the same place [m]. */
const SAME_PLACE = 0.05;
/** @type {Record<string, Point>} */
const ARROWS = { ArrowUp: [0, 1], ArrowDown: [0, -1], ArrowLeft: [-1, 0], ArrowRight: [1, 0] };
const HELP = "Arrow keys move the cross, with Shift farther; Enter takes the place under it.";

/** @param {() => boolean} isDriving Whether the arrow keys drive the robot now. */
export function createMap(isDriving) {
  const surface = byId("map");
  const overlay = createOverlay();
  /** @type {Tool | null} */
  let tool = null;
  /** @type {Point | null} */
  let cross = null;
  /** @type {Point | null} */
  let robot = null;
  /** @type {number | null} */
  let pointerId = null;

  /** @param {string} text Shown in place of the picture's caption. */
  function showText(text) {
    setText(byId("map-said"), text);
    byId("map-caption").hidden = text !== "";
  }

  /** @param {Point} point @returns {string} Where it is, seen from the robot. */
  function describe([x, y]) {
    if (robot === null) return "";
    const [right, up] = [x - robot[0], y - robot[1]];
    const offsets = [
      ...(Math.abs(right) < SAME_PLACE ? [] : [`${Math.abs(right).toFixed(1)} m ${right > 0 ? "right" : "left"}`]),
      ...(Math.abs(up) < SAME_PLACE ? [] : [`${Math.abs(up).toFixed(1)} m ${up > 0 ? "up" : "down"}`]),
    ];
    return offsets.length ? `${offsets.join(" and ")} from the robot` : "where the robot is";
  }

  /** @param {Point} offset */
  function moveCross([right, up]) {
    const view = overlay.view();
    if (!view) return;
    const { corner, width, height, metres_per_pixel: scale } = view;
    const [x, y] = cross ?? robot ?? [corner[0] + (width * scale) / 2, corner[1] + (height * scale) / 2];
    cross = clampToView(view, [x + right, y + up]);
    overlay.mark({ cross });
  }

  function resetTool() {
    pointerId = null;
    tool?.reset();
  }

  listenToPointer();
  listenToKeys();

  function listenToPointer() {
    surface.addEventListener("pointerdown", (event) => {
      const point = overlay.pointAt(event);
      if (pointerId !== null || event.button !== 0 || point === null) return;
      pointerId = event.pointerId;
      surface.setPointerCapture(pointerId);
      tool?.press(point);
    });
    surface.addEventListener("pointermove", (event) => {
      const point = overlay.pointAt(event);
      if (event.pointerId === pointerId && point !== null) tool?.move(point);
    });
    surface.addEventListener("pointerup", (event) => {
      const point = overlay.pointAt(event);
      if (event.pointerId !== pointerId) return;
      pointerId = null;
      if (point === null) return;
      cross = point;
      tool?.release(point);
    });
    surface.addEventListener("pointercancel", (event) => {
      if (event.pointerId !== pointerId) return;
      pointerId = null;
      tool?.cancel();
    });
  }

  function listenToKeys() {
    surface.addEventListener("focus", () => {
      if (!surface.matches(":focus-visible") || isDriving()) return;
      moveCross([0, 0]);
      showText(HELP);
    });
    surface.addEventListener("blur", () => {
      overlay.mark({ cross: null });
      if (byId("map-said").textContent === HELP) showText("");
    });
    surface.addEventListener("keydown", (event) => {
      const arrow = ARROWS[event.code];
      const modified = event.ctrlKey || event.altKey || event.metaKey;
      if (isDriving() || modified || !overlay.view()) return;
      if (arrow) {
        event.preventDefault();
        const step = event.shiftKey ? LONG_STEP : STEP;
        moveCross([arrow[0] * step, arrow[1] * step]);
        if (cross) {
          tool?.move(cross);
          showText(`The cross is ${describe(cross)}.`);
        }
      } else if (event.code === "Enter" && !event.repeat) {
        moveCross([0, 0]);
        if (cross) {
          tool?.press(cross);
          tool?.release(cross);
        }
      }
    });
  }

  return {
    overlay,
    showText,
    describe,
    focus: () => surface.focus({ preventScroll: true }),
    /** @param {Tool} newTool */
    setTool: (newTool) => {
      resetTool();
      tool = newTool;
    },
    /** @param {State} state */
    update: ({ map_view: view, position }) => {
      if (view === null && overlay.view() !== null) {
        resetTool();
        cross = null;
        overlay.mark({ cross, found: null });
      }
      robot = position ?? null;
      overlay.setView(view);
    },
  };
}

/** @typedef {ReturnType<typeof createMap>} MapPicture */
