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
 * @param {HTMLImageElement} image
 * @param {Blob} picture
 */
export function showBlob(image, picture) {
  const address = URL.createObjectURL(picture);
  image.onload = image.onerror = () => URL.revokeObjectURL(address);
  image.src = address;
}

/** Shows nothing in place of a picture that does not come, where browsers show a broken one. */
export function hideBrokenImages() {
  const hide = (/** @type {Event} */ { target }) => {
    if (target instanceof HTMLImageElement) target.removeAttribute("src");
  };
  document.addEventListener("error", hide, { capture: true });
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
 * Builds the items of a list where they have changed. What has not stays the same element, since a
 * press on a button that is replaced before it is let go is no click. The keyboard's focus stays on
 * the button of the same name; where that is gone, the list has it.
 *
 * @param {HTMLElement} list
 * @param {string} version
 * @param {() => HTMLElement[]} items
 */
export function updateList(list, version, items) {
  if (list.dataset.version === version) return;
  list.dataset.version = version;
  const focused = list.contains(document.activeElement) ? document.activeElement : null;
  const old = [...list.children];
  for (const item of items()) {
    const place = old.findIndex((each) => each.isEqualNode(item));
    if (place < 0) list.insertBefore(item, old[0] ?? null);
    else for (const gone of old.splice(0, place + 1).slice(0, -1)) gone.remove();
  }
  for (const gone of old) gone.remove();
  if (focused === null || focused === list || list.contains(focused)) return;
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
