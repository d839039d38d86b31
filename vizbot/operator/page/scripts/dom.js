// @ts-check
/**
 * Access to the elements of the page. Text is set as text, never as HTML.
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
 * Writes only a text that has changed, so that no screen reader reads it out twice.
 *
 * @param {HTMLElement} element
 * @param {string} text
 */
export function setText(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

/**
 * @param {string} tag
 * @param {string} text
 * @param {string} [className]
 */
export function createElement(tag, text, className = "") {
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
 * Shows one line for each thing that is wrong; null removes the line.
 *
 * @param {string} subject
 * @param {string | null} text
 */
export function setAlarm(subject, text) {
  const alarm = byId("alarm");
  const line = alarm.querySelector(`[data-about="${subject}"]`) ?? createElement("p", "");
  /** @type {HTMLElement} */ (line).dataset.about = subject;
  if (text === null) line.remove();
  else if (!line.isConnected) alarm.append(line);
  setText(/** @type {HTMLElement} */ (line), text ?? "");
  alarm.hidden = alarm.childElementCount === 0;
}
