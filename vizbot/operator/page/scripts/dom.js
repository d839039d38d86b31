// @ts-check
/**
 * Elements of the page, and text put into them as text.
 */

/**
 * @param {string} id
 * @returns {HTMLElement}
 */
export function byId(id) {
  const element = document.getElementById(id);
  if (!element) throw new Error(`the page has no ${id}`);
  return element;
}

/**
 * @param {string} id
 * @returns {HTMLInputElement}
 */
export function field(id) {
  return /** @type {HTMLInputElement} */ (byId(id));
}

/**
 * Only what has changed is written, so that nothing is read out twice.
 *
 * @param {HTMLElement} element
 * @param {string} text
 */
export function show(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

/**
 * @param {string} tag
 * @param {string} text
 * @param {string} [className]
 */
export function make(tag, text, className = "") {
  const element = document.createElement(tag);
  element.textContent = text;
  element.className = className;
  return element;
}

/** @param {string} text */
export function capitalised(text) {
  return text.charAt(0).toUpperCase() + text.slice(1);
}

/**
 * One line for each thing that is wrong; no line hides another one.
 *
 * @param {string} about
 * @param {string | null} text
 */
export function raise(about, text) {
  const alarm = byId("alarm");
  const line = alarm.querySelector(`[data-about="${about}"]`) ?? make("p", "");
  /** @type {HTMLElement} */ (line).dataset.about = about;
  if (text === null) line.remove();
  else if (!line.isConnected) alarm.append(line);
  show(/** @type {HTMLElement} */ (line), text ?? "");
  alarm.hidden = alarm.childElementCount === 0;
}
