// @ts-check
/**
 * The picture of the map, on which a person points by mouse, by finger, or with the arrow keys.
 *
 * @typedef {import("./gestures.js").Tool} Tool
 * @typedef {import("../state_view.js").Point} Point
 * @typedef {import("../state_view.js").State} State
 */

import { byId, setText } from "../dom.js";
import { createGestures } from "./gestures.js";
import { createOverlay } from "./overlay.js";
import { clampToView, floorAt, toFloorAxes, toPictureAxes } from "./projection.js";

/** How far one press of an arrow key moves the cross, and with Shift [m]. */
const STEP = 0.1;
const LONG_STEP = 0.5;
/** Points that are so near count as the same place [m]. */
const SAME_PLACE = 0.05;
/** @type {Record<string, Point>} To the right and up in the picture. */
const ARROWS = { ArrowUp: [0, 1], ArrowDown: [0, -1], ArrowLeft: [-1, 0], ArrowRight: [1, 0] };
const HELP =
  "Arrow keys move the cross, with Shift farther; Enter takes the place under it; + and - enlarge and reduce, 0 shows all.";

/** @param {() => boolean} isDriving Whether the arrow keys drive the robot now. */
export function createMap(isDriving) {
  const surface = byId("map");
  const overlay = createOverlay();
  const { zoom } = overlay;
  /** @type {Tool | null} */
  let tool = null;
  /** @type {Point | null} */
  let cross = null;
  /** @type {Point | null} */
  let robot = null;
  const gestures = createGestures(surface, () => tool, overlay, (point) => {
    cross = point;
  });
  /** @type {Record<string, () => void>} */
  const zoomKeys = { "+": zoom.in, "=": zoom.in, "-": zoom.out, 0: zoom.reset };

  /** @param {string} text Shown in place of the picture's caption. */
  function showText(text) {
    setText(byId("map-said"), text);
    byId("map-caption").hidden = text !== "";
  }

  /** @param {Point} point @returns {string} Where it is, seen from the robot. */
  function describe([x, y]) {
    const view = overlay.view();
    if (robot === null || view === null) return "";
    const [right, up] = toPictureAxes(view, [x - robot[0], y - robot[1]]);
    const offsets = [
      ...(Math.abs(right) < SAME_PLACE ? [] : [`${Math.abs(right).toFixed(1)} m ${right > 0 ? "right" : "left"}`]),
      ...(Math.abs(up) < SAME_PLACE ? [] : [`${Math.abs(up).toFixed(1)} m ${up > 0 ? "up" : "down"}`]),
    ];
    return offsets.length ? `${offsets.join(" and ")} from the robot` : "where the robot is";
  }

  /** @param {Point} offset To the right and up in the picture [m]. */
  function moveCross(offset) {
    const view = overlay.view();
    if (!view) return;
    const [x, y] = cross ?? robot ?? floorAt(view, [view.width / 2, view.height / 2]);
    const [right, up] = toFloorAxes(view, offset);
    cross = clampToView(view, [x + right, y + up]);
    overlay.include(cross);
    overlay.mark({ cross });
  }

  function resetTool() {
    gestures.reset();
    tool?.reset();
  }

  function showZoom() {
    surface.classList.toggle("enlarged", zoom.scale() > 1);
  }

  listenToKeys();
  overlay.listenToZoom(showZoom);
  byId("zoom-in").addEventListener("click", zoom.in);
  byId("zoom-out").addEventListener("click", zoom.out);
  byId("zoom-all").addEventListener("click", zoom.reset);

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
      if (event.ctrlKey || event.altKey || event.metaKey || !overlay.view()) return;
      if (event.key in zoomKeys) zoomKeys[event.key]?.();
      if (isDriving()) return;
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
        overlay.mark({ cross, found: null, rooms: [] });
      }
      robot = position ?? null;
      overlay.setView(view);
    },
  };
}

/** @typedef {ReturnType<typeof createMap>} MapPicture */
