// @ts-check
/**
 * Keep-out zones: drawn on the map by two opposite corners, listed, removed.
 *
 * @typedef {import("./view.js").MapPicture} MapPicture
 * @typedef {import("./gestures.js").Tool} Tool
 * @typedef {import("../state_view.js").Point} Point
 */

import { byId, createElement, setText } from "../dom.js";
import { rectangleOf, toPictureAxes } from "./projection.js";
import { STEP_TIMEOUT, request } from "../http.js";

/** The least width and height of a zone [m]. */
const MIN_SIZE = 0.1;
const INSTRUCTIONS = "Draw over the floor that the robot should keep out of, or give two opposite corners.";

/**
 * @param {MapPicture} map
 * @param {Tool} defaultTool What pointing at the map does while no zone is drawn.
 */
export function createZones(map, defaultTool) {
  /** @type {Point[][]} */
  let zones = [];
  /** @type {Point | null} */
  let firstCorner = null;
  let isFirstPress = false;

  /** @param {Point | null} corner */
  function startAt(corner) {
    firstCorner = corner;
    map.overlay.mark({ rectangle: corner && [corner, corner] });
  }

  /** @type {Tool} */
  const tool = {
    drags: true,
    press: (point) => {
      isFirstPress = firstCorner === null;
      if (isFirstPress) startAt(point);
    },
    move: (point) => {
      if (firstCorner) map.overlay.mark({ rectangle: [firstCorner, point] });
    },
    release: (point) => {
      const view = map.overlay.view();
      if (firstCorner === null || view === null) return;
      const [width, height] = toPictureAxes(view, [point[0] - firstCorner[0], point[1] - firstCorner[1]]);
      if (Math.min(Math.abs(width), Math.abs(height)) >= MIN_SIZE) {
        const zone = rectangleOf(view, [firstCorner, point]);
        firstCorner = null;
        change("POST", zone, "It keeps out of there now.").then(() => {
          if (firstCorner === null) startAt(null);
        });
      } else {
        map.showText(isFirstPress ? "Now the opposite corner." : "That is too narrow; take another corner.");
      }
    },
    cancel: () => {
      if (isFirstPress) startAt(null);
    },
    reset: () => startAt(null),
  };

  /**
   * Adds or removes one zone; zones that others have drawn meanwhile stay.
   *
   * @param {"POST" | "DELETE"} method
   * @param {Point[]} corners
   * @param {string} success
   */
  async function change(method, corners, success) {
    map.showText("Telling the robot.");
    const { error } = await request(method, "/map/keep-out", { corners }, STEP_TIMEOUT);
    map.showText(error === null ? success : `Not changed: ${error}.`);
    await refresh();
  }

  /** @returns {Promise<boolean>} Whether the robot has answered. */
  async function refresh() {
    const { answer, error } = await request("GET", "/map/keep-out", undefined, STEP_TIMEOUT);
    if (error !== null) return false;
    if (JSON.stringify(answer.zones) === JSON.stringify(zones)) return true;
    zones = answer.zones;
    map.overlay.mark({ zones, highlighted: null });
    listZones();
    return true;
  }

  function listZones() {
    setText(byId("zones-open"), zones.length ? `Keep-out zones (${zones.length})` : "Keep-out zones");
    byId("zones").replaceChildren(...zones.map(item));
  }

  /** @param {Point[]} corners @param {number} index */
  function item(corners, index) {
    const size = sizeText(corners, map.overlay.view() ?? { turn: 0 });
    const line = createElement("li", "");
    const remove = createElement("button", "Remove");
    remove.setAttribute("aria-label", `Remove zone ${index + 1}`);
    remove.addEventListener("click", () => {
      byId("zones-done").focus();
      change("DELETE", corners, "Removed.");
    });
    for (const [event, highlighted] of /** @type {[string, number | null][]} */ ([
      ["pointerenter", index], ["pointerleave", null], ["focusin", index], ["focusout", null],
    ])) {
      line.addEventListener(event, () => map.overlay.mark({ highlighted }));
    }
    line.append(createElement("b", `Zone ${index + 1}`), createElement("span", size), remove);
    return line;
  }

  /** @param {boolean} opens */
  function open(opens) {
    map.setTool(opens ? tool : defaultTool);
    byId("map").classList.toggle("drawing", opens);
    for (const id of ["zones", "zones-done"]) byId(id).hidden = !opens;
    byId("map-tools").hidden = opens;
    if (opens) map.focus();
    else byId("zones-open").focus();
    map.showText(opens ? INSTRUCTIONS : "");
  }

  byId("zones-open").addEventListener("click", () => open(true));
  byId("zones-done").addEventListener("click", () => open(false));
  return { refresh };
}

/**
 * @param {Point[]} corners
 * @param {{turn: number}} view
 */
function sizeText(corners, view) {
  const turned = corners.map((corner) => toPictureAxes(view, corner));
  /** @param {0 | 1} axis */
  const size = (axis) => {
    const values = turned.map((corner) => corner[axis]);
    return (Math.max(...values) - Math.min(...values)).toFixed(1);
  };
  return `${size(0)} m by ${size(1)} m`;
}
