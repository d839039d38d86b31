// @ts-check
/**
 * Rows of buttons of which one is pressed.
 */

import { PICTURES } from "./connection.js";

/**
 * A row of buttons of which one is pressed.
 *
 * @param {NodeListOf<HTMLElement>} buttons
 * @param {string} key Name of their `data-` attribute.
 * @param {string} first
 * @param {(value: string) => void} onChoice
 */
export function createChoice(buttons, key, first, onChoice) {
  /** @param {string} value */
  const choose = (value) => {
    for (const button of buttons) {
      button.setAttribute("aria-pressed", `${button.dataset[key] === value}`);
    }
    onChoice(value);
  };
  for (const button of buttons) {
    button.addEventListener("click", () => choose(button.dataset[key] ?? first));
  }
  choose(first);
  return choose;
}

/**
 * Shows one picture on a phone and all on a wide screen; only what is shown is sent.
 *
 * @param {() => void} onChange
 */
export function createPictureChoice(onChange) {
  const wide = matchMedia("(min-width: 60rem)");
  let chosen = "colour";
  const choose = createChoice(document.querySelectorAll("#choices button"), "picture", chosen, (name) => {
    chosen = name;
    for (const figure of document.querySelectorAll("figure")) {
      figure.classList.toggle("shown", figure.dataset.picture === name);
    }
    onChange();
  });
  wide.addEventListener("change", onChange);
  return { choose, wanted: () => (wide.matches ? PICTURES : [chosen]) };
}
