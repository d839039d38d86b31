// @ts-check
/**
 * A base that has ceased to obey, for its own safety, until a person lets it drive again.
 *
 * @typedef {import("./state_view.js").Base} Base
 * @typedef {import("./state_view.js").State} State
 */

import { byId, show } from "./dom.js";

/**
 * @param {State} state
 * @param {boolean} driving Whether it is us who drive.
 */
export function showObeying({ base, activity }, driving) {
  const disobeys = base !== null && (base.mode === "passive" || base.mode === "off");
  const docks = activity === "docking" || activity === "on the dock";
  const why = disobeys && !docks ? reasonOf(base, driving) : null;
  byId("held").hidden = why === null;
  show(byId("held-why"), why ?? "");
}

/**
 * @param {Base} base
 * @param {boolean} driving
 */
function reasonOf({ wheel_drops, cliffs, plugged_in, feels }, driving) {
  if (wheel_drops.includes(true)) return "The robot was stopped because it was lifted. Put it on the floor.";
  if (cliffs.includes(true)) {
    return "The robot was stopped at an edge. Put it on the floor away from there, or drive it straight back.";
  }
  if (plugged_in) return "The robot does not drive while it is plugged in. Pull out its cable.";
  if (feels.some((one) => one.startsWith("on charger"))) {
    return driving ? "The robot stands on its charger and does not drive." : null; // it is to charge
  }
  return "The robot was stopped by an edge, by being lifted, or by a button on it. Put it on the floor.";
}
