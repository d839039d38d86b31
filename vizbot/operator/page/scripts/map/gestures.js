// @ts-check
/**
 * What fingers, a mouse and its wheel do on the map: point, draw, pan, zoom.
 *
 * @typedef {import("../state_view.js").Point} Point
 * @typedef {object} Tool What pointing does. A key or a tap presses and releases at one point.
 * @property {boolean} drags Whether moving with a pressed pointer is for the tool; else it pans.
 * @property {(point: Point) => void} press
 * @property {(point: Point) => void} move Called while the pointer is down, and by the arrow keys.
 * @property {(point: Point) => void} release
 * @property {() => void} cancel Undoes a press that was not meant: the finger scrolls the page.
 * @property {() => void} reset Forgets all points.
 * @typedef {{x: number, y: number}} Place On the page [px].
 */

/** So far a pointer moves while it only points [px]. */
const SLOP = 8;
/** What a wheel's pixel enlarges by, as the logarithm; a line of some wheels is so many pixels. */
const WHEEL = 0.002;
const LINE = 30;

/**
 * @param {HTMLElement} surface
 * @param {() => Tool | null} currentTool
 * @param {import("./overlay.js").Overlay} overlay
 * @param {(point: Point) => void} onPoint Called with where a pointer was released.
 */
export function createGestures(surface, currentTool, overlay, onPoint) {
  const { zoom } = overlay;
  /** @type {Map<number, Place>} */
  const pointers = new Map();
  /** @type {"points" | "pans" | "pinches" | null} */
  let doing = null;
  let start = { x: 0, y: 0 };

  surface.addEventListener("pointerdown", (event) => {
    const point = overlay.pointAt(event);
    if (event.button !== 0 || pointers.size === 2 || point === null) return;
    pointers.set(event.pointerId, placeOf(event));
    surface.setPointerCapture(event.pointerId);
    if (pointers.size === 2) {
      if (doing === "points") currentTool()?.cancel();
      doing = "pinches";
    } else if (doing === null) {
      [doing, start] = ["points", placeOf(event)];
      currentTool()?.press(point);
    }
  });
  surface.addEventListener("pointermove", (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const others = [...pointers].filter(([id]) => id !== event.pointerId).map(([, place]) => place);
    const now = placeOf(event);
    pointers.set(event.pointerId, now);
    if (doing === "pinches") pinch(before, now, others[0]);
    else move(event, before, now);
  });
  surface.addEventListener("pointerup", (event) => {
    if (!pointers.delete(event.pointerId)) return;
    const [done, point] = [doing, overlay.pointAt(event)];
    if (pointers.size === 0) doing = null;
    if (done !== "points" || point === null) return;
    onPoint(point);
    currentTool()?.release(point);
  });
  surface.addEventListener("pointercancel", (event) => {
    if (!pointers.delete(event.pointerId)) return;
    if (doing === "points") currentTool()?.cancel();
    doing = pointers.size === 0 ? null : "pinches";
  });
  surface.addEventListener(
    "touchmove",
    (event) => {
      if (event.touches.length > 1) event.preventDefault(); // two fingers scroll and enlarge the map, not the page
    },
    { passive: false },
  );
  surface.addEventListener(
    "wheel",
    (event) => {
      const rolls = event.deltaY * (event.deltaMode === WheelEvent.DOM_DELTA_PIXEL ? 1 : LINE);
      if (!overlay.view() || (rolls > 0 && zoom.scale() === 1)) return; // the page scrolls
      event.preventDefault();
      zoom.by(Math.exp(-WHEEL * rolls), zoom.pixelAt(overlay.pixelAt(event)));
    },
    { passive: false },
  );

  /** @param {PointerEvent} event @param {Place} before @param {Place} now */
  function move(event, before, now) {
    const [tool, point] = [currentTool(), overlay.pointAt(event)];
    if (doing === "points" && tool?.drags && point !== null) tool.move(point);
    if (doing === "points" && !tool?.drags && distance(start, now) > SLOP) {
      tool?.cancel();
      doing = "pans";
    }
    if (doing === "pans") pan(before, now);
  }

  /** @param {Place} before @param {Place} now @param {Place} [other] The finger that rests meanwhile. */
  function pinch(before, now, other) {
    if (!other) return;
    const [was, is] = [between(before, other), between(now, other)];
    const fixed = zoom.pixelAt(overlay.pixelAt({ clientX: was.x, clientY: was.y }));
    zoom.by(distance(now, other) / Math.max(1, distance(before, other)), fixed);
    pan(was, is); // a map that is not enlarged yet would not move
  }

  /** @param {Place} before @param {Place} now */
  function pan(before, now) {
    const perPixel = overlay.picturePixels();
    zoom.pan((now.x - before.x) * perPixel, (now.y - before.y) * perPixel);
  }

  return {
    /** What is pressed now has no effect any more. */
    reset: () => {
      pointers.clear();
      doing = null;
    },
  };
}

/** @param {MouseEvent} event @returns {Place} */
function placeOf({ clientX, clientY }) {
  return { x: clientX, y: clientY };
}

/** @param {Place} one @param {Place} other */
function distance(one, other) {
  return Math.hypot(one.x - other.x, one.y - other.y);
}

/** @param {Place} one @param {Place} other @returns {Place} */
function between(one, other) {
  return { x: (one.x + other.x) / 2, y: (one.y + other.y) / 2 };
}
