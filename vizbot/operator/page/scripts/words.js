// @ts-check
/**
 * The robot's words in those of a person at home.
 */

/** @type {Record<string, string>} Plainer words for some activities. */
const ACTIVITIES = {
  mapping: "mapping what it sees",
  "standing still, to learn the gyroscope's bias": "standing still, to get its bearings",
};

/** @param {string} text */
export function plainWords(text) {
  const remedied = text.replace(/; (press Clean and )?launch again/, "; let it drive again");
  return ACTIVITIES[text] ?? remedied.replace("similarity", "likeness");
}
