// @ts-check
/** The names of the rooms that the robot knows, written on the map. */

import { STEP_TIMEOUT, request } from "../http.js";

/** Between two questions [ms]: the robot explores slowly. */
const PERIOD = 15000;

/**
 * @param {import("./overlay.js").Overlay} overlay
 * @param {() => boolean} isShown Whether anybody sees the map.
 */
export function createRooms(overlay, isShown) {
  let [busy, askedAt] = [false, -PERIOD];

  /** @returns {Promise<boolean>} Whether the robot has answered. */
  async function refresh() {
    [busy, askedAt] = [true, performance.now()];
    const { answer, error } = await request("GET", "/map/rooms", undefined, STEP_TIMEOUT);
    busy = false;
    if (error === null) overlay.mark({ rooms: answer.rooms });
    return error === null;
  }

  setInterval(() => {
    const due = performance.now() - askedAt >= PERIOD && document.visibilityState === "visible";
    if (due && !busy && isShown() && overlay.view() !== null) refresh();
  }, 1000);
  return { refresh };
}
