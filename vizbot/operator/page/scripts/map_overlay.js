// @ts-check
/**
 * What the page draws over the picture of the map.
 *
 * @typedef {import("./state_view.js").MapView} MapView
 * @typedef {import("./state_view.js").Point} Point
 * @typedef {object} Marks
 * @property {Point[][]} zones Corners of each.
 * @property {number | null} highlighted Index of the zone that stands out.
 * @property {[Point, Point] | null} rectangle Two opposite corners of the zone that is being drawn.
 * @property {Point | null} cross Where the arrow keys point.
 * @property {Point | null} chosen Where a person may send the robot.
 * @property {Point | null} found Where what somebody asked for is.
 */

import { byId } from "./dom.js";

const SVG = "http://www.w3.org/2000/svg";
/** Lengths of the bar [m]. */
const SCALES = [0.5, 1, 2, 5, 10, 20];
const PIN = "M0 0 C-3 -8 -9 -11 -9 -18 A9 9 0 1 1 9 -18 C9 -11 3 -8 0 0 Z";

export function createOverlay() {
  const svg = /** @type {SVGSVGElement} */ (/** @type {unknown} */ (byId("overlay")));
  /** @type {MapView | null} */
  let view = null;
  /** @type {Marks} */
  const marks = { zones: [], highlighted: null, rectangle: null, cross: null, chosen: null, found: null };

  function draw() {
    svg.replaceChildren(...(view === null ? [] : shapes(marks, view)));
  }

  return {
    view: () => view,
    /** @param {MapView | null} newView */
    setView: (newView) => {
      if (JSON.stringify(newView) === JSON.stringify(view)) return;
      view = newView;
      if (view) svg.setAttribute("viewBox", `0 0 ${view.width} ${view.height}`);
      draw();
    },
    /** @param {Partial<Marks>} changes */
    mark: (changes) => {
      Object.assign(marks, changes);
      draw();
    },
    /**
     * @param {PointerEvent} event
     * @returns {Point | null} On the map; null before there is one.
     */
    pointAt: ({ clientX, clientY }) => {
      const matrix = svg.getScreenCTM();
      if (!matrix || !view) return null;
      const { x, y } = new DOMPoint(clientX, clientY).matrixTransform(matrix.inverse());
      const { corner, height, metres_per_pixel: scale } = view;
      return clampToView(view, [corner[0] + x * scale, corner[1] + (height - y) * scale]);
    },
  };
}

/**
 * The nearest point inside the picture, rounded to the centimetre.
 *
 * @param {MapView} view
 * @param {Point} point
 * @returns {Point}
 */
export function clampToView({ corner, width, height, metres_per_pixel: scale }, [x, y]) {
  /** @param {number} value @param {number} low @param {number} size */
  const clamp = (value, low, size) => Math.max(low, Math.min(low + size * scale, value));
  const [nearX, nearY] = [clamp(x, corner[0], width), clamp(y, corner[1], height)];
  return [Math.round(100 * nearX) / 100, Math.round(100 * nearY) / 100];
}

/**
 * @param {[Point, Point]} corners Two opposite ones.
 * @returns {Point[]}
 */
export function rectangleOf([[x, y], [otherX, otherY]]) {
  return [[x, y], [otherX, y], [otherX, otherY], [x, otherY]];
}

/**
 * @param {Marks} marks
 * @param {MapView} view
 */
function shapes({ zones, highlighted, rectangle, cross, chosen, found }, view) {
  const { corner, height, metres_per_pixel: scale } = view;
  /** @param {Point} point @returns {Point} */
  const pixel = ([x, y]) => [(x - corner[0]) / scale, height - (y - corner[1]) / scale];
  /** @param {Point[]} corners @param {string} className */
  const polygon = (corners, className) =>
    shape("polygon", className, { points: corners.map(pixel).join(" ") });
  /** @param {Point | null} point @param {string} className @param {string} path */
  const symbol = (point, className, path) =>
    point === null ? [] : [shape("path", className, { d: path, transform: `translate(${pixel(point)})` })];
  return [
    ...zones.map((corners, index) => polygon(corners, index === highlighted ? "zone shown" : "zone")),
    ...zones.map((corners, index) => numberLabel(pixel(centre(corners)), index + 1)),
    ...(rectangle ? [polygon(rectangleOf(rectangle), "rectangle")] : []),
    ...symbol(found, "pin", PIN),
    ...symbol(chosen, "chosen halo", "M-11 0 a11 11 0 1 0 22 0 a11 11 0 1 0 -22 0 M0 0 v.01"),
    ...symbol(chosen, "chosen", "M-11 0 a11 11 0 1 0 22 0 a11 11 0 1 0 -22 0 M0 0 v.01"),
    ...symbol(cross, "cross halo", "M-16 0 H-3 M3 0 H16 M0 -16 V-3 M0 3 V16"),
    ...symbol(cross, "cross", "M-16 0 H-3 M3 0 H16 M0 -16 V-3 M0 3 V16"),
    ...scaleBar(view),
  ];
}

/** @param {MapView} view @returns {SVGElement[]} A bar of whole metres at the lower left. */
function scaleBar({ width, height, metres_per_pixel: scale }) {
  const metres = SCALES.findLast((length) => length / scale <= width / 4) ?? SCALES[0] ?? 1;
  const bar = `M12 ${height - 18} v6 h${metres / scale} v-6`;
  const text = shape("text", "metres", { x: "16", y: `${height - 20}` });
  text.textContent = `${metres} m`;
  return [shape("path", "scale halo", { d: bar }), shape("path", "scale", { d: bar }), text];
}

/** @param {Point[]} corners @returns {Point} */
function centre(corners) {
  /** @param {0 | 1} axis */
  const mean = (axis) => corners.reduce((sum, corner) => sum + corner[axis], 0) / corners.length;
  return [mean(0), mean(1)];
}

/** @param {Point} point @param {number} number */
function numberLabel([x, y], number) {
  const text = shape("text", "number", { x: `${x}`, y: `${y}` });
  text.textContent = `${number}`;
  return text;
}

/**
 * @param {string} tag
 * @param {string} className
 * @param {Record<string, string>} attributes
 */
function shape(tag, className, attributes) {
  const element = document.createElementNS(SVG, tag);
  element.setAttribute("class", className);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  return element;
}
