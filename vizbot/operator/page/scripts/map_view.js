// @ts-check
/**
 * The picture of the map, at which a person points: by mouse, by finger, with the arrow keys.
 *
 * @typedef {import("./state_view.js").Point} Point
 * @typedef {import("./state_view.js").State} State
 * @typedef {object} Tool What pointing does. A key or a tap presses and lifts at one place.
 * @property {(at: Point) => void} press
 * @property {(at: Point) => void} move While it is pressed, and where the arrow keys go.
 * @property {(at: Point) => void} lift
 * @property {() => void} cancel What was pressed was not meant: the finger scrolls the page.
 * @property {() => void} drop Nothing that was pointed at counts any more.
 */

import { byId, show } from "./dom.js";
import { createOverlay, within } from "./map_overlay.js";

/** By which one press of an arrow key moves the cross, and with Shift [m]. */
const STEP = 0.1;
const LONG_STEP = 0.5;
/** What is so near counts as the same place [m]. */
const HERE = 0.05;
/** @type {Record<string, Point>} */
const ARROWS = { ArrowUp: [0, 1], ArrowDown: [0, -1], ArrowLeft: [-1, 0], ArrowRight: [1, 0] };
const HELP = "Arrow keys move the cross, with Shift farther; Enter takes the place under it.";

/** @param {() => boolean} drives Whether the arrow keys drive the robot now. */
export function createMap(drives) {
  const surface = byId("map");
  const overlay = createOverlay();
  /** @type {Tool | null} */
  let tool = null;
  /** @type {Point | null} */
  let cross = null;
  /** @type {Point | null} */
  let robot = null;
  /** @type {number | null} */
  let finger = null;

  /** @param {string} text In the place of the picture's caption. */
  function say(text) {
    show(byId("map-said"), text);
    byId("map-caption").hidden = text !== "";
  }

  /** @param {Point} at */
  function where([x, y]) {
    if (robot === null) return "";
    const [right, up] = [x - robot[0], y - robot[1]];
    const ways = [
      ...(Math.abs(right) < HERE ? [] : [`${Math.abs(right).toFixed(1)} m ${right > 0 ? "right" : "left"}`]),
      ...(Math.abs(up) < HERE ? [] : [`${Math.abs(up).toFixed(1)} m ${up > 0 ? "up" : "down"}`]),
    ];
    return ways.length ? `${ways.join(" and ")} from the robot` : "where the robot is";
  }

  /** @param {Point} by */
  function moveCross([right, up]) {
    const view = overlay.view();
    if (!view) return;
    const { corner, width, height, metres_per_pixel: scale } = view;
    const [x, y] = cross ?? robot ?? [corner[0] + (width * scale) / 2, corner[1] + (height * scale) / 2];
    cross = within(view, [x + right, y + up]);
    overlay.mark({ cross });
  }

  function abandon() {
    finger = null;
    tool?.drop();
  }

  listenToPointer();
  listenToKeys();

  function listenToPointer() {
    surface.addEventListener("pointerdown", (event) => {
      const at = overlay.pointAt(event);
      if (finger !== null || event.button !== 0 || at === null) return;
      finger = event.pointerId;
      surface.setPointerCapture(finger);
      tool?.press(at);
    });
    surface.addEventListener("pointermove", (event) => {
      const at = overlay.pointAt(event);
      if (event.pointerId === finger && at !== null) tool?.move(at);
    });
    surface.addEventListener("pointerup", (event) => {
      const at = overlay.pointAt(event);
      if (event.pointerId !== finger) return;
      finger = null;
      if (at === null) return;
      cross = at;
      tool?.lift(at);
    });
    surface.addEventListener("pointercancel", (event) => {
      if (event.pointerId !== finger) return;
      finger = null;
      tool?.cancel();
    });
  }

  function listenToKeys() {
    surface.addEventListener("focus", () => {
      if (!surface.matches(":focus-visible") || drives()) return;
      moveCross([0, 0]);
      say(HELP);
    });
    surface.addEventListener("blur", () => {
      overlay.mark({ cross: null });
      if (byId("map-said").textContent === HELP) say("");
    });
    surface.addEventListener("keydown", (event) => {
      const arrow = ARROWS[event.code];
      const other = event.ctrlKey || event.altKey || event.metaKey;
      if (drives() || other || !overlay.view()) return;
      if (arrow) {
        event.preventDefault();
        const step = event.shiftKey ? LONG_STEP : STEP;
        moveCross([arrow[0] * step, arrow[1] * step]);
        if (cross) {
          tool?.move(cross);
          say(`The cross is ${where(cross)}.`);
        }
      } else if (event.code === "Enter" && !event.repeat) {
        moveCross([0, 0]);
        if (cross) {
          tool?.press(cross);
          tool?.lift(cross);
        }
      }
    });
  }

  return {
    overlay,
    say,
    where,
    focus: () => surface.focus({ preventScroll: true }),
    /** @param {Tool} other */
    use: (other) => {
      abandon();
      tool = other;
    },
    /** @param {State} state */
    follow: ({ map_view: view, position }) => {
      if (view === null && overlay.view() !== null) {
        abandon();
        cross = null;
        overlay.mark({ cross, found: null });
      }
      robot = position ?? null;
      overlay.follow(view);
    },
  };
}

/** @typedef {ReturnType<typeof createMap>} MapPicture */
