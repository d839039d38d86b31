// @ts-check
/**
 * What the page draws over the picture of the map, in the size that people see it.
 *
 * @typedef {import("../state_view.js").MapView} MapView
 * @typedef {import("../state_view.js").Point} Point
 * @typedef {import("./projection.js").Pixel} Pixel
 * @typedef {{name: string, position: Point}} Room
 * @typedef {object} Marks
 * @property {Point[][]} zones Corners of each.
 * @property {number | null} highlighted Index of the zone that stands out.
 * @property {[Point, Point] | null} rectangle Two opposite corners of the zone that is being drawn.
 * @property {Point | null} cross Where the arrow keys point.
 * @property {Point | null} chosen Where a person may send the robot.
 * @property {Point | null} found Where what somebody asked for is.
 * @property {Room[]} rooms
 */

import { byId } from "../dom.js";
import { clampToView, floorAt, pixelOf, rectangleOf } from "./projection.js";
import { createZoom } from "./zoom.js";

const SVG = "http://www.w3.org/2000/svg";
/** Lengths of the bar [m]. */
const SCALES = [0.5, 1, 2, 5, 10, 20];
const PIN = "M0 0 C-3 -8 -9 -11 -9 -18 A9 9 0 1 1 9 -18 C9 -11 3 -8 0 0 Z";

export function createOverlay() {
  const svg = /** @type {SVGSVGElement} */ (/** @type {unknown} */ (byId("overlay")));
  const image = /** @type {HTMLElement} */ (byId("map").querySelector("img"));
  /** @type {MapView | null} */
  let view = null;
  let onZoom = () => {};
  /** @type {Marks} */
  const marks = {
    zones: [], highlighted: null, rectangle: null, cross: null, chosen: null, found: null, rooms: [],
  };

  const zoom = createZoom(() => {
    image.style.transform = zoom.transform();
    draw();
    onZoom();
  });

  function draw() {
    svg.replaceChildren(...(view === null ? [] : shapes(marks, view, zoom)));
  }

  /** @param {{clientX: number, clientY: number}} event @returns {Pixel} Of the part that is shown. */
  function pixelAt({ clientX, clientY }) {
    const { left, top } = svg.getBoundingClientRect();
    const size = picturePixels();
    return [(clientX - left) * size, (clientY - top) * size];
  }

  /** @returns {number} Pixels of the picture in one of the page. */
  const picturePixels = () => (view === null ? 0 : view.width / svg.getBoundingClientRect().width);

  return {
    zoom,
    pixelAt,
    picturePixels,
    view: () => view,
    /** @param {MapView | null} newView */
    setView: (newView) => {
      if (JSON.stringify(newView) === JSON.stringify(view)) return;
      view = newView;
      if (view) svg.setAttribute("viewBox", `0 0 ${view.width} ${view.height}`);
      zoom.setView(view);
      draw();
    },
    /** @param {Partial<Marks>} changes */
    mark: (changes) => {
      Object.assign(marks, changes);
      draw();
    },
    /** @param {Point} point Is moved into the part that is shown. */
    include: (point) => {
      if (view) zoom.include(pixelOf(view, point));
    },
    /**
     * @param {PointerEvent} event
     * @returns {Point | null} On the map; null before there is one.
     */
    pointAt: (event) => view && clampToView(view, floorAt(view, zoom.pixelAt(pixelAt(event)))),
    /** @param {() => void} listener Called when another part of the map is shown. */
    listenToZoom: (listener) => {
      onZoom = listener;
    },
  };
}

/** @typedef {ReturnType<typeof createOverlay>} Overlay */

/**
 * @param {Marks} marks
 * @param {MapView} view
 * @param {import("./zoom.js").Zoom} zoom
 */
function shapes({ zones, highlighted, rectangle, cross, chosen, found, rooms }, view, zoom) {
  /** @param {Point} point */
  const pixel = (point) => zoom.shown(pixelOf(view, point));
  /** @param {Point[]} corners @param {string} className */
  const polygon = (corners, className) =>
    shape("polygon", className, { points: corners.map(pixel).join(" ") });
  /** @param {Point | null} point @param {string} className @param {string} path */
  const symbol = (point, className, path) =>
    point === null ? [] : [shape("path", className, { d: path, transform: `translate(${pixel(point)})` })];
  return [
    ...zones.map((corners, index) => polygon(corners, index === highlighted ? "zone shown" : "zone")),
    ...rooms.map(({ name, position }) => label("room", pixel(position), name)),
    ...zones.map((corners, index) => label("number", pixel(centre(corners)), `${index + 1}`)),
    ...(rectangle ? [polygon(rectangleOf(view, rectangle), "rectangle")] : []),
    ...symbol(found, "pin", PIN),
    ...symbol(chosen, "chosen halo", "M-11 0 a11 11 0 1 0 22 0 a11 11 0 1 0 -22 0 M0 0 v.01"),
    ...symbol(chosen, "chosen", "M-11 0 a11 11 0 1 0 22 0 a11 11 0 1 0 -22 0 M0 0 v.01"),
    ...symbol(cross, "cross halo", "M-16 0 H-3 M3 0 H16 M0 -16 V-3 M0 3 V16"),
    ...symbol(cross, "cross", "M-16 0 H-3 M3 0 H16 M0 -16 V-3 M0 3 V16"),
    ...scaleBar(view, view.metres_per_pixel / zoom.scale()),
  ];
}

/**
 * @param {MapView} view
 * @param {number} scale Metres in a pixel as it is shown.
 * @returns {SVGElement[]} A bar of whole metres at the lower left.
 */
function scaleBar({ width, height }, scale) {
  const metres = SCALES.findLast((length) => length / scale <= width / 4) ?? SCALES[0] ?? 1;
  const bar = `M12 ${height - 18} v6 h${metres / scale} v-6`;
  return [
    shape("path", "scale halo", { d: bar }),
    shape("path", "scale", { d: bar }),
    label("metres", [16, height - 20], `${metres} m`),
  ];
}

/** @param {Point[]} corners @returns {Point} */
function centre(corners) {
  /** @param {0 | 1} axis */
  const mean = (axis) => corners.reduce((sum, corner) => sum + corner[axis], 0) / corners.length;
  return [mean(0), mean(1)];
}

/** @param {string} className @param {Pixel} pixel @param {string} text */
function label(className, [x, y], text) {
  const element = shape("text", className, { x: `${x}`, y: `${y}` });
  element.textContent = text;
  return element;
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
