// @ts-check
/**
 * Places on the map: one that a person chooses to send the robot to, one that was asked for.
 *
 * @typedef {import("./map_view.js").MapPicture} MapPicture
 * @typedef {import("./state_view.js").Point} Point
 */

import { byId } from "./dom.js";
import { refusal } from "./http.js";

const nothing = () => {};

/**
 * @param {import("./http.js").Wishes} wishes
 * @param {MapPicture} map
 * @param {(lines: string[]) => void} tell
 */
export function createPlaces(wishes, map, tell) {
  /** @type {Point | null} */
  let chosen = null;

  /** @param {Point | null} at */
  function choose(at) {
    chosen = at;
    map.overlay.mark({ chosen });
    byId("chosen").hidden = chosen === null;
    byId("map-tools").hidden = chosen !== null;
    map.say(chosen === null ? "" : `Chosen: ${map.where(chosen)}.`);
  }

  /** @param {boolean} atOnce */
  async function go(atOnce) {
    if (chosen === null) return;
    const [x, y] = chosen;
    leave();
    const { against } = await wishes.ask("/place", { x, y, at_once: atOnce });
    tell([against === null ? "Asked to go to the place on the map." : refusal(against)]);
  }

  /** The buttons vanish; whoever is at the keyboard is not to be lost with them. */
  function leave() {
    choose(null);
    map.focus();
  }

  byId("go-here").addEventListener("click", () => go(false));
  byId("go-here-now").addEventListener("click", () => go(true));
  byId("not-here").addEventListener("click", leave);

  return {
    /** @param {Point | null} at Of what somebody has asked for. */
    find: (at) => map.overlay.mark({ found: at }),
    /** @type {import("./map_view.js").Tool} A place is chosen first: a stray tap sends no robot. */
    tool: { press: nothing, move: nothing, cancel: nothing, lift: choose, drop: () => choose(null) },
  };
}
