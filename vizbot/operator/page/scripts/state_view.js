// @ts-check
/**
 * The robot's state, shown in plain words.
 *
 * @typedef {object} TaskState
 * @property {number} number
 * @property {string} text
 * @property {string | null} headline How a search ended, in words.
 * @property {string | null} outcome
 * @property {string} reason
 * @property {[number, number, number] | null} position Where the goal was found, on the map [m].
 * @typedef {object} Base
 * @property {string} mode
 * @property {number | null} battery
 * @property {string} charging
 * @property {string[]} feels
 * @property {boolean[]} wheel_drops
 * @property {boolean[]} cliffs
 * @property {boolean} plugged_in
 * @typedef {{time: number, code: string, text: string}} LogLine
 * @typedef {[number, number]} Point x and y on the map [m].
 * @typedef {object} MapView Which part of the map its picture shows.
 * @property {Point} corner The picture's lower left corner.
 * @property {number} metres_per_pixel
 * @property {number} width [px]
 * @property {number} height [px]
 * @property {number} turn Direction of the picture's rows on the map, counterclockwise [rad].
 * @typedef {object} State
 * @property {boolean} stopped
 * @property {string | null} wheel Who drives by hand.
 * @property {TaskState[]} goals Those that are over first, then the running one, then the waiting.
 * @property {Base | null} base
 * @property {import("./place_cards.js").Arrival | null} arrival Where it has arrived last.
 * @property {import("./place_cards.js").Candidate | null} candidate What it approaches.
 * @property {string | null} question What it asks before it does anything more.
 * @property {LogLine[]} log
 * @property {string | null} run Its folder, on the robot's machine.
 * @property {number | null} step
 * @property {string} activity
 * @property {MapView | null} map_view
 * @property {Point} [position]
 * @property {string} [goal]
 * @property {string} [likeness] What the picture of that name is for.
 * @property {string} [tracking]
 * @property {string} [why] Why it does what it does.
 * @property {number | null} [score]
 * @property {string | null} [measure] What a score is.
 * @property {number} [threshold]
 * @property {number | null} [distance_to_go] [m]
 * @typedef {import("./connection.js").Link} Link
 */

import { byId, capitalised, createElement, setAlarm, setText, showBlob, updateList } from "./dom.js";
import { showTasks } from "./task_list.js";
import { getOwnName, personOf, plainWords, withPeople } from "./words.js";

const LOW_BATTERY = 0.15;
/** The charge of a base that is silent is shown for so long [ms]. */
const BATTERY_KEPT = 10000;
let batteryAt = -BATTERY_KEPT;
/** Whether this page has ever shown a state of the robot. */
let hasShown = false;
/** @type {Record<string, string>} */
const MODES = {
  off: "off",
  passive: "not listening",
  safe: "ready",
  full: "ready, without their own guards",
};
/** @type {Record<string, string>} */
const CHARGING = {
  "not charging": "",
  waiting: ", waits to charge",
  fault: ", cannot charge",
};
/** @type {Record<string, string>} */
const TRACKING = {
  tracking: "yes",
  "wheels only": "roughly, by its wheels",
  lost: "no, it is lost",
  relocalised: "yes, again",
};
const LOST = "It does not know where it is on the map: asked for something, it looks for its place first.";

/**
 * @param {State} state
 * @param {boolean} driving Whether this page drives.
 */
export function showState(state, driving) {
  hasShown = true;
  setText(byId("activity"), headline(state, driving));
  setText(byId("detail"), detail(state, driving));
  setText(byId("likeness"), state.likeness ? `to “${state.likeness}”: red is most alike` : "nothing is asked for");
  showFacts(state);
  showResumePrompt(state, driving);
  showTasks(state);
  showLog(state.log);
}

/**
 * @param {State} state
 * @param {boolean} driving
 */
function headline({ stopped, wheel, activity, goal }, driving) {
  if (stopped) return "Stopped";
  if (driving) return "You drive";
  if (wheel !== null) return capitalised(handText(wheel));
  if (goal) return `Looking for “${goal}”`;
  return capitalised(plainWords(activity));
}

/** @param {string} wheel Who drives, at another page than this. */
function handText(wheel) {
  return wheel === getOwnName() ? "you drive by hand, at another page" : `${personOf(wheel)} drives by hand`;
}

/**
 * @param {State} state
 * @param {boolean} driving
 */
function detail({ stopped, wheel, goals, goal, activity, tracking, why, distance_to_go: toGo }, driving) {
  const running = goals.some((task) => task.outcome === null);
  const lost = tracking === "lost" ? ` ${LOST}` : "";
  if (stopped && running) return "It rests until somebody has it go on, or drives.";
  if (stopped) return `It rests until somebody asks for something or drives.${lost}`;
  if (driving || wheel !== null) {
    return running ? "What it was asked for waits until the wheel is given back." : "";
  }
  if (!running) return `Nothing is asked for.${lost}`;
  const distance = toGo == null ? [] : [`${toGo.toFixed(1)} m to go`];
  const doing = capitalised([...(goal ? [plainWords(activity)] : []), ...distance].join(", "));
  return why ? `${doing}. ${capitalised(plainWords(why))}.` : doing;
}

/** @param {State} state */
function showFacts({ base, tracking, score: best, measure, threshold }) {
  showBattery(base);
  const mode = base?.mode ?? "";
  setFact("mode", base ? (MODES[mode] ?? mode) : "unknown", mode === "off" || mode === "passive");
  const feels = base?.feels ?? [];
  const contacts = feels.join(", ") || "nothing unusual";
  setFact("feels", base ? contacts : "unknown", feels.some((contact) => !contact.startsWith("on charger")));
  setFact("tracking", TRACKING[tracking ?? ""] ?? "not yet", tracking === "lost");
  const enough = `(${scoreText(threshold ?? 0, measure)} is enough)`;
  setFact("best", best == null ? "nothing asked" : `${scoreText(best, measure)} ${enough}`, false);
}

/**
 * What was last known stays for a while: a robot whose computer is busy reports late.
 *
 * @param {Base | null} base
 */
function showBattery(base) {
  const now = performance.now();
  if (base !== null) batteryAt = now;
  else if (now - batteryAt < BATTERY_KEPT) return;
  const battery = base?.battery ?? null;
  const charge = battery === null ? "unknown" : `${Math.round(100 * battery)} %`;
  const charging = CHARGING[base?.charging ?? "not charging"] ?? ", charging";
  setFact("battery", charge + charging, battery !== null && battery < LOW_BATTERY);
}

/**
 * @param {number} score
 * @param {string | null | undefined} measure
 */
function scoreText(score, measure) {
  return measure === "probability" ? `${Math.round(100 * score)} %` : score.toFixed(2);
}

/**
 * @param {string} id
 * @param {string} text
 * @param {boolean} alarming
 */
function setFact(id, text, alarming) {
  setText(byId(id), text);
  byId(id).classList.toggle("alarming", alarming);
}

/**
 * The prompt to let the base drive again, after it has stopped obeying for its own safety.
 *
 * @param {State} state
 * @param {boolean} driving Whether this page drives.
 */
function showResumePrompt({ base, activity, question }, driving) {
  byId("asks").hidden = question === null;
  setText(byId("asks-what"), question === null ? "" : capitalised(question));
  const disobeys = question === null && base !== null && (base.mode === "passive" || base.mode === "off");
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

/** @param {LogLine[]} log */
function showLog(log) {
  updateList(byId("log"), JSON.stringify([log.length, log.at(-1), getOwnName()]), () => log.map(lineItem).reverse());
}

/** @param {LogLine} line */
function lineItem({ time, code, text }) {
  const at = new Date(1000 * time);
  const stamp = /** @type {HTMLTimeElement} */ (createElement("time", at.toLocaleTimeString()));
  stamp.dateTime = at.toISOString();
  const item = createElement("li", "");
  const words = code === "goal" ? `asked for: ${text}` : withPeople(plainWords(text));
  item.append(stamp, createElement("span", words));
  return item;
}

/**
 * @param {string} name
 * @param {Blob} jpeg
 */
export function showPicture(name, jpeg) {
  const image = /** @type {HTMLImageElement} */ (
    document.querySelector(`figure[data-picture="${name}"] img`)
  );
  showBlob(image, jpeg);
}

/** @type {Record<Link, string>} */
const LINKS = {
  live: "live",
  lost: "no link",
  ended: "ended",
  locked: "locked",
  refused: "locked",
  crowded: "full",
};
/** @type {Partial<Record<Link, string>>} What is wrong with a link. */
const BROKEN = {
  lost:
    "The link to the robot is lost; trying again. If it was driven by hand, it has stopped and rests." +
    " Else it goes on with what it was asked for, as long as its program runs.",
  ended: "The robot's program has ended, and does nothing more. This page goes on when it is started again.",
  crowded:
    "Too many pages watch the robot already; trying again. Close one that nobody needs." +
    " STOP works all the same.",
};

/** @param {Link} link */
export function showLink(link) {
  byId("link").className = `link ${link}`;
  setText(byId("link"), LINKS[link]);
  const locked = link === "locked" || link === "refused";
  byId("token-form").hidden = !locked;
  setText(byId("token-refused"), link === "refused" ? "That is not this robot's token." : "");
  document.body.classList.toggle("stale", link !== "live");
  if (link !== "live" && hasShown) {
    setText(byId("activity"), "Out of touch");
    setText(byId("detail"), "What is shown here is how it was.");
  } else if (link !== "live") {
    setText(byId("activity"), locked ? "It wants its token" : "Connecting to the robot");
  }
  setAlarm("link", BROKEN[link] ?? null);
}

/**
 * @param {State | null} state
 * @param {boolean} driving
 * @param {string} reason What ended the driving.
 */
export function showDriving(state, driving, reason) {
  const other = driving ? null : (state?.wheel ?? null);
  const contacts = state?.base?.feels.length ? ` It notices: ${state.base.feels.join(", ")}.` : "";
  document.body.classList.toggle("driving", driving);
  byId("controls").hidden = !driving;
  const nobody = other === null ? "Nobody drives by hand." : `${capitalised(handText(other))}.`;
  setText(byId("holder"), driving ? `You drive.${contacts}` : reason || nobody);
  const taking = other === null ? "Take the wheel" : `Take the wheel from ${other === getOwnName() ? "the other page" : personOf(other)}`;
  setText(byId("wheel"), driving ? "Give the wheel back" : taking);
}
