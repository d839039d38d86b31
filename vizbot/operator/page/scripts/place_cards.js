// @ts-check
/**
 * The cards that show a place and ask whether that is what was asked for: where the robot has
 * arrived, and the candidate that it approaches meanwhile.
 *
 * @typedef {object} Arrival
 * @property {number} number Of the task.
 * @property {string} text
 * @property {string} headline The outcome in words.
 * @property {boolean | null} confirmed What somebody has said.
 *
 * @typedef {object} Candidate
 * @property {number} number
 * @property {string} text
 * @property {string} headline
 * @property {boolean} confirmed Whether somebody has said to go there.
 *
 * @typedef {object} Place
 * @property {number} number The same as long as the card is of one place.
 * @property {string} headline
 * @property {string} text What was asked for.
 * @property {string} picture Its address.
 * @property {string} said
 * @property {boolean} takesYes
 * @property {boolean} takesNo
 *
 * @typedef {import("./http.js").PendingRequests} PendingRequests
 */

import { byId, capitalised, setText, showBlob } from "./dom.js";
import { STEP_TIMEOUT, refusalText, requestPicture } from "./http.js";

/**
 * @param {PendingRequests} requests
 * @param {() => string} who
 */
export function createArrivalCard(requests, who) {
  const card = createCard("arrival", (_number, confirmed) =>
    requests.post("/verdict", { confirmed, who: who() }, STEP_TIMEOUT),
  );

  /** @param {Arrival | null} arrival */
  function update(arrival) {
    card.show(
      arrival && {
        ...arrival,
        picture: `/pictures/arrival.jpg?task=${arrival.number}`,
        said: arrivalText(arrival),
        takesYes: arrival.confirmed === null,
        takesNo: arrival.confirmed === null,
      },
    );
  }
  return { update };
}

/** @param {Arrival} arrival */
function arrivalText({ confirmed }) {
  if (confirmed === null) return "Is this it?";
  return confirmed ? "Yes: this is it." : "No: this is not it, and it searches on.";
}

/**
 * @param {PendingRequests} requests
 * @param {() => string} who
 */
export function createCandidateCard(requests, who) {
  const card = createCard("candidate", (number, confirmed) =>
    requests.post(`/candidates/${number}/verdict`, { confirmed, who: who() }, STEP_TIMEOUT),
  );

  /** @param {Candidate | null} candidate */
  function update(candidate) {
    card.show(
      candidate && {
        ...candidate,
        picture: `/candidates/${candidate.number}/picture.jpg`,
        said: candidate.confirmed ? "It goes there, and stops there." : "It takes a closer look.",
        takesYes: !candidate.confirmed,
        takesNo: true,
      },
    );
  }
  return { update };
}

/**
 * @param {string} id
 * @param {(number: number, confirmed: boolean) => Promise<import("./http.js").Reply>} judge
 */
function createCard(id, judge) {
  const image = /** @type {HTMLImageElement} */ (byId(`${id}-picture`));
  let shown = -1;
  let refusal = "";

  /** @param {Place | null} place */
  function show(place) {
    byId(id).hidden = place === null;
    if (place === null) {
      shown = -1;
      return;
    }
    if (place.number !== shown) {
      shown = place.number;
      refusal = "";
      image.alt = `What it took for “${place.text}”, in a green box`;
      showPicture(place);
    }
    setText(byId(`${id}-title`), place.headline);
    setText(byId(`${id}-question`), refusal || place.said);
    byId(`${id}-yes`).hidden = !place.takesYes;
    byId(`${id}-no`).hidden = !place.takesNo;
    byId(`${id}-answers`).hidden = !place.takesYes && !place.takesNo;
  }

  /** @param {Place} place */
  async function showPicture({ number, picture: path }) {
    image.removeAttribute("src"); // its room is kept, so that nothing moves under a finger
    image.hidden = false;
    byId(`${id}-missing`).hidden = true;
    const { picture, missing } = await requestPicture(path);
    if (number !== shown) return;
    image.hidden = picture === null;
    if (picture) showBlob(image, picture);
    byId(`${id}-missing`).hidden = missing === null;
    setText(byId(`${id}-missing`), missing === null ? "" : `${capitalised(missing)}.`);
  }

  /** @param {boolean} confirmed */
  async function answer(confirmed) {
    const { error } = await judge(shown, confirmed);
    refusal = error === null ? "" : refusalText(error);
    byId(id).focus({ preventScroll: true }); // the buttons vanish
  }

  byId(`${id}-yes`).addEventListener("click", () => answer(true));
  byId(`${id}-no`).addEventListener("click", () => answer(false));
  return { show };
}
