// @ts-check
/**
 * Which part of the picture of the map is shown, and how large.
 *
 * @typedef {import("../state_view.js").MapView} MapView
 * @typedef {import("./projection.js").Pixel} Pixel
 */

import { clamp, floorAt, pixelOf } from "./projection.js";

/** The most that the picture is enlarged by. */
const MOST = 10;
const STEP = 1.5;

/** @param {() => void} onChange */
export function createZoom(onChange) {
  /** @type {MapView | null} */
  let view = null;
  /** How many times as large as the whole it is shown, and the pixel at the upper left. */
  let [scale, left, top] = [1, 0, 0];

  /**
   * Keeps to the picture.
   *
   * @param {number} newScale
   * @param {number} newLeft
   * @param {number} newTop
   */
  function set(newScale, newLeft, newTop) {
    if (!view) return;
    scale = clamp(newScale, 1, MOST);
    left = clamp(newLeft, 0, view.width * (1 - 1 / scale));
    top = clamp(newTop, 0, view.height * (1 - 1 / scale));
    onChange();
  }

  /** @returns {Pixel} Of the whole picture, that stands in the middle. */
  function middle() {
    const { width, height } = view ?? { width: 0, height: 0 };
    return [left + width / 2 / scale, top + height / 2 / scale];
  }

  /** @param {Pixel} pixel In the whole picture. @returns {Pixel} Where it is shown. */
  const shown = ([column, row]) => [(column - left) * scale, (row - top) * scale];

  /** @param {number} factor @param {Pixel} [fixed] Stays where it is shown. */
  function by(factor, fixed = middle()) {
    const next = clamp(scale * factor, 1, MOST);
    const ratio = scale / next;
    set(next, fixed[0] - (fixed[0] - left) * ratio, fixed[1] - (fixed[1] - top) * ratio);
  }

  return {
    scale: () => scale,
    shown,
    /** @param {Pixel} place Where something is shown. @returns {Pixel} In the whole picture. */
    pixelAt: ([column, row]) => /** @type {Pixel} */ ([left + column / scale, top + row / scale]),
    by,
    in: () => by(STEP),
    out: () => by(1 / STEP),
    reset: () => set(1, 0, 0),
    /**
     * Moves what is shown, in pixels as they are shown.
     *
     * @param {number} right
     * @param {number} down
     */
    pan: (right, down) => set(scale, left - right / scale, top - down / scale),
    /**
     * Moves what is shown no farther than it must, so that a pixel is inside.
     *
     * @param {Pixel} pixel
     */
    include: ([column, row]) => {
      if (!view) return;
      const [width, height] = [view.width / scale, view.height / scale];
      const newLeft = clamp(left, column - 0.9 * width, column - 0.1 * width);
      set(scale, newLeft, clamp(top, row - 0.9 * height, row - 0.1 * height));
    },
    /**
     * Shows the same part of the floor in another picture.
     *
     * @param {MapView | null} newView
     */
    setView: (newView) => {
      const before = view;
      view = newView;
      if (!view || !before || scale === 1) {
        set(1, 0, 0);
        return;
      }
      const kept = /** @type {Pixel} */ ([left + before.width / 2 / scale, top + before.height / 2 / scale]);
      const [column, row] = pixelOf(view, floorAt(before, kept));
      const newScale = clamp((scale * view.metres_per_pixel) / before.metres_per_pixel, 1, MOST);
      set(newScale, column - view.width / 2 / newScale, row - view.height / 2 / newScale);
    },
    /** As a CSS transform of the whole picture about its upper left corner. */
    transform: () => {
      const { width, height } = view ?? { width: 1, height: 1 };
      const [right, down] = shown([0, 0]);
      return scale === 1 ? "" : `translate(${(100 * right) / width}%, ${(100 * down) / height}%) scale(${scale})`;
    },
  };
}

/** @typedef {ReturnType<typeof createZoom>} Zoom */
