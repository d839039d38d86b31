// @ts-check
/**
 * Keep-out zones: drawn on the map by two opposite corners, listed, removed.
 *
 * @typedef {import("./map_view.js").MapPicture} MapPicture
 * @typedef {import("./map_view.js").Tool} Tool
 * @typedef {import("./state_view.js").Point} Point
 */

import { byId, make, show } from "./dom.js";
import { rectangleOf } from "./map_overlay.js";
import { BETWEEN_STEPS, request } from "./http.js";

/** A zone is at least so wide and so high [m]. */
const LEAST = 0.1;
const HOW = "Draw over the floor it shall keep out of, or give two opposite corners.";

/**
 * @param {MapPicture} map
 * @param {Tool} otherwise What pointing at the map does while no zones are drawn.
 */
export function createZones(map, otherwise) {
  /** @type {Point[][]} */
  let zones = [];
  /** @type {Point | null} */
  let first = null;
  let fresh = false;

  /** @param {Point | null} corner */
  function begin(corner) {
    first = corner;
    map.overlay.mark({ rectangle: corner && [corner, corner] });
  }

  /** @type {Tool} */
  const tool = {
    press: (at) => {
      fresh = first === null;
      if (fresh) begin(at);
    },
    move: (at) => {
      if (first) map.overlay.mark({ rectangle: [first, at] });
    },
    lift: (at) => {
      if (first === null) return;
      if (Math.min(Math.abs(at[0] - first[0]), Math.abs(at[1] - first[1])) >= LEAST) {
        const zone = rectangleOf([first, at]);
        first = null;
        change("POST", zone, "It keeps out of there now.").then(() => {
          if (first === null) begin(null);
        });
      } else {
        map.say(fresh ? "Now the opposite corner." : "That is too narrow; take another corner.");
      }
    },
    cancel: () => begin(null),
    drop: () => begin(null),
  };

  /**
   * One zone comes or goes; what others have drawn meanwhile stays.
   *
   * @param {"POST" | "DELETE"} method
   * @param {Point[]} corners
   * @param {string} done
   */
  async function change(method, corners, done) {
    map.say("Telling the robot.");
    const { against } = await request(method, "/map/keep-out", { corners }, BETWEEN_STEPS);
    map.say(against === null ? done : `Not changed: ${against}.`);
    await renew();
  }

  /** @returns {Promise<boolean>} Whether the robot has told its zones. */
  async function renew() {
    const { said, against } = await request("GET", "/map/keep-out", undefined, BETWEEN_STEPS);
    if (against !== null) return false;
    if (JSON.stringify(said.zones) === JSON.stringify(zones)) return true;
    zones = said.zones;
    map.overlay.mark({ zones, shown: null });
    list();
    return true;
  }

  function list() {
    show(byId("zones-open"), zones.length ? `Keep-out zones (${zones.length})` : "Keep-out zones");
    byId("zones").replaceChildren(...zones.map(item));
  }

  /** @param {Point[]} corners @param {number} place */
  function item(corners, place) {
    const line = make("li", "");
    const remove = make("button", "Remove");
    remove.setAttribute("aria-label", `Remove zone ${place + 1}`);
    remove.addEventListener("click", () => {
      byId("zones-done").focus();
      change("DELETE", corners, "Removed.");
    });
    for (const [event, shown] of /** @type {[string, number | null][]} */ ([
      ["pointerenter", place], ["pointerleave", null], ["focusin", place], ["focusout", null],
    ])) {
      line.addEventListener(event, () => map.overlay.mark({ shown }));
    }
    line.append(make("b", `Zone ${place + 1}`), make("span", sizeOf(corners)), remove);
    return line;
  }

  /** @param {boolean} opens */
  function open(opens) {
    map.use(opens ? tool : otherwise);
    byId("map").classList.toggle("drawing", opens);
    for (const id of ["zones", "zones-done"]) byId(id).hidden = !opens;
    byId("map-tools").hidden = opens;
    if (opens) map.focus();
    else byId("zones-open").focus();
    map.say(opens ? HOW : "");
  }

  byId("zones-open").addEventListener("click", () => open(true));
  byId("zones-done").addEventListener("click", () => open(false));
  return { renew };
}

/** @param {Point[]} corners */
function sizeOf(corners) {
  /** @param {0 | 1} axis */
  const size = (axis) => {
    const values = corners.map((corner) => corner[axis]);
    return (Math.max(...values) - Math.min(...values)).toFixed(1);
  };
  return `${size(0)} m by ${size(1)} m`;
}
