// @ts-check
/**
 * The prompt to let the base drive again, after it has stopped obeying for its own safety.
 *
 * @typedef {import("./state_view.js").Base} Base
 * @typedef {import("./state_view.js").State} State
 */

import { byId, setText } from "./dom.js";

/**
 * @param {State} state
 * @param {boolean} driving Whether this page drives.
 */
export function showResumePrompt({ base, activity }, driving) {
  const disobeys = base !== null && (base.mode === "passive" || base.mode === "off");
  const docks = activity === "docking" || activity === "on the dock";
  const reason = disobeys && !docks ? reasonText(base, driving) : null;
  byId("held").hidden = reason === null;
  setText(byId("held-why"), reason ?? "");
}

/**
 * @param {Base} base
 * @param {boolean} driving
 */
function reasonText({ wheel_drops, cliffs, plugged_in, feels }, driving) {
  if (wheel_drops.includes(true)) return "The robot was stopped because it was lifted. Put it on the floor.";
  if (cliffs.includes(true)) {
    return "The robot was stopped at an edge. Put it on the floor away from there, or drive it straight back.";
  }
  if (plugged_in) return "The robot does not drive while it is plugged in. Pull out its cable.";
  if (feels.some((contact) => contact.startsWith("on charger"))) {
    return driving ? "The robot stands on its charger and does not drive." : null; // charging is intended
  }
  return "The robot was stopped by an edge, by being lifted, or by a button on it. Put it on the floor.";
}
