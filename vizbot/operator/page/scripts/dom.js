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
 * Builds the items of a list only where they have changed. The keyboard's focus stays on the button
 * of the same name; where that is gone, the list has it.
 *
 * @param {HTMLElement} list
 * @param {string} version
 * @param {() => HTMLElement[]} items
 */
export function updateList(list, version, items) {
  if (list.dataset.version === version) return;
  list.dataset.version = version;
  const focused = list.contains(document.activeElement) ? document.activeElement : null;
  list.replaceChildren(...items());
  if (focused === null || focused === list) return;
  const buttons = [...list.querySelectorAll("button")];
  (buttons.find(({ id }) => id === focused.id) ?? list).focus({ preventScroll: true });
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
