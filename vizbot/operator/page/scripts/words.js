// @ts-check
/**
 * The robot's words in those of a person at home.
 */

/** @type {Record<string, string>} Plainer words for some activities. */
const ACTIVITIES = {
  mapping: "mapping what it sees",
  "lost, looking around": "turning to find its place on the map",
  "standing still, to learn the gyroscope's bias": "standing still, to get its bearings",
};

/** @param {string} text */
export function plainWords(text) {
  const remedied = text.replace(/; (press Clean and )?launch again/, "; let it drive again");
  return ACTIVITIES[text] ?? remedied.replace("similarity", "likeness");
}

/** What the robot calls people who give no name: it tells them apart by letters that nobody is shown. */
const UNNAMED = /\bsomebody [0-9a-z]{6}\b/g;
let ownName = "";

/** @param {string} name Of the person at this page, as the robot has it. */
export function setOwnName(name) {
  ownName = name;
}

export function getOwnName() {
  return ownName;
}

/** @returns {string} What is sent to the robot in place of a name. */
export function makeUnnamed() {
  const [letters] = crypto.getRandomValues(new Uint32Array(1));
  return `somebody ${(letters ?? 0).toString(36).padStart(6, "0").slice(-6)}`;
}

/**
 * A person as this page calls them.
 *
 * @param {string} who As the robot has it.
 */
export function personOf(who) {
  return who === ownName ? "you" : who.replace(UNNAMED, "somebody else");
}

/**
 * A line of the robot's about what people did, as this page tells it.
 *
 * @param {string} text
 */
export function withPeople(text) {
  const name = ownName.replace(/[\\^$.*+?()[\]{}|]/g, "\\$&");
  const own = new RegExp(`(^| by | instead of |: )${name}(?=$|\\)| drives| says| instead)`, "g");
  return text
    .replace(own, "$1you")
    .replace(/(^|: )you (drive|say)s/, "$1you $2")
    .replace(UNNAMED, "somebody else");
}
