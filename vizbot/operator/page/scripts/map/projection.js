// @ts-check
/**
 * How the floor lies in the picture of the map, which is turned so that walls stand upright.
 *
 * @typedef {import("../state_view.js").MapView} MapView
 * @typedef {import("../state_view.js").Point} Point
 * @typedef {[number, number]} Pixel Column and row in the whole picture, from its upper left corner.
 */

/** Steps of a coordinate in a metre: the robot is sent millimetres. */
const PER_METRE = 1000;

/**
 * @param {Pick<MapView, "turn">} view
 * @param {Point} offset On the floor.
 * @returns {Point} To the right and up in the picture [m].
 */
export function toPictureAxes({ turn }, [x, y]) {
  const [cos, sin] = [Math.cos(turn), Math.sin(turn)];
  return [cos * x + sin * y, cos * y - sin * x];
}

/**
 * @param {Pick<MapView, "turn">} view
 * @param {Point} offset To the right and up in the picture [m].
 * @returns {Point} On the floor.
 */
export function toFloorAxes({ turn }, offset) {
  return toPictureAxes({ turn: -turn }, offset);
}

/**
 * @param {MapView} view
 * @param {Point} point
 * @returns {Pixel}
 */
export function pixelOf(view, [x, y]) {
  const { corner, height, metres_per_pixel: scale } = view;
  const [right, up] = toPictureAxes(view, [x - corner[0], y - corner[1]]);
  return [right / scale, height - up / scale];
}

/**
 * @param {MapView} view
 * @param {Pixel} pixel
 * @returns {Point}
 */
export function floorAt(view, [column, row]) {
  const { corner, height, metres_per_pixel: scale } = view;
  const [x, y] = toFloorAxes(view, [column * scale, (height - row) * scale]);
  return [corner[0] + x, corner[1] + y];
}

/**
 * The nearest point inside the picture, rounded to the millimetre.
 *
 * @param {MapView} view
 * @param {Point} point
 * @returns {Point}
 */
export function clampToView(view, point) {
  const [column, row] = pixelOf(view, point);
  const inside = floorAt(view, [clamp(column, 0, view.width), clamp(row, 0, view.height)]);
  return rounded(inside);
}

/**
 * A rectangle that stands upright in the picture.
 *
 * @param {MapView} view
 * @param {[Point, Point]} corners Two opposite ones.
 * @returns {Point[]}
 */
export function rectangleOf(view, corners) {
  const [[left, top], [right, bottom]] = /** @type {[Pixel, Pixel]} */ (corners.map((one) => pixelOf(view, one)));
  /** @type {Pixel[]} */
  const pixels = [[left, top], [right, top], [right, bottom], [left, bottom]];
  return pixels.map((pixel) => rounded(floorAt(view, pixel)));
}

/** @param {number} value @param {number} low @param {number} high */
export function clamp(value, low, high) {
  return Math.max(low, Math.min(high, value));
}

/** @param {Point} point @returns {Point} */
function rounded([x, y]) {
  return [Math.round(x * PER_METRE) / PER_METRE, Math.round(y * PER_METRE) / PER_METRE];
}
