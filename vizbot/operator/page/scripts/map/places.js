// @ts-check
/**
 * Places on the map: the one where a person may send the robot, the one that was asked for.
 *
 * @typedef {import("./view.js").MapPicture} MapPicture
 * @typedef {import("../state_view.js").Point} Point
 */

import { byId } from "../dom.js";
import { refusalText } from "../http.js";

const nothing = () => {};

/**
 * @param {import("../http.js").PendingRequests} requests
 * @param {MapPicture} map
 * @param {(lines: string[]) => void} showAnswer
 */
export function createPlaces(requests, map, showAnswer) {
  /** @type {Point | null} */
  let chosen = null;

  /** @param {Point | null} point */
  function choose(point) {
    chosen = point;
    map.overlay.mark({ chosen });
    byId("chosen").hidden = chosen === null;
    byId("map-tools").hidden = chosen !== null;
    map.showText(chosen === null ? "" : `Chosen: ${map.describe(chosen)}.`);
  }

  /** @param {boolean} atOnce */
  async function go(atOnce) {
    if (chosen === null) return;
    const [x, y] = chosen;
    unchoose();
    const { error } = await requests.post("/place", { x, y, at_once: atOnce });
    showAnswer([error === null ? "Asked to go to the place on the map." : refusalText(error)]);
  }

  /** The buttons vanish; the keyboard's focus must not vanish with them. */
  function unchoose() {
    choose(null);
    map.focus();
  }

  byId("go-here").addEventListener("click", () => go(false));
  byId("go-here-now").addEventListener("click", () => go(true));
  byId("not-here").addEventListener("click", unchoose);

  return {
    /** @param {Point | null} found Where what somebody asked for is. */
    markFound: (found) => map.overlay.mark({ found }),
    /** @type {import("./gestures.js").Tool} A place is chosen first: a stray tap sends no robot. */
    tool: { drags: false, press: nothing, move: nothing, cancel: nothing, release: choose, reset: () => choose(null) },
  };
}
