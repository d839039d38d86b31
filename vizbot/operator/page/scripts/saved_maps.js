// @ts-check
/**
 * Saved maps: saving the robot's map under a name, changing to another map or to an empty one,
 * renaming and deleting those that are saved.
 *
 * @typedef {object} SavedMap
 * @property {string} name
 * @property {number} saved_at In seconds since 1970.
 * @property {boolean} in_use Whether a robot is in it.
 */

import { byId, field, createElement, setText, updateList } from "./dom.js";
import { STEP_TIMEOUT, request } from "./http.js";

const NAME = /^[\p{L}\p{N}_](?:[\p{L}\p{N}_ -]|(?<=\p{N})\.(?=\p{N})){0,59}$/u;
const NO_NAME = "Give it a name of letters, digits, spaces and -.";

export function createSavedMaps() {
  /** @type {SavedMap[]} */
  let maps = [];
  /** @type {string | null} The map whose new name is being typed. */
  let renamed = null;
  let onConfirm = () => {};

  /** @param {string} text */
  const showText = (text) => setText(byId("maps-said"), text);
  const isNamed = (/** @type {string} */ name) => maps.some((one) => one.name === name);

  /** @param {string} question @param {string} yes @param {() => void} onYes */
  function confirm(question, yes, onYes) {
    onConfirm = onYes;
    showText("");
    setText(byId("maps-question"), question);
    setText(byId("maps-yes"), yes);
    byId("maps-ask").hidden = false;
    byId("maps-ask").focus();
  }

  function close() {
    byId("maps-ask").hidden = true;
    byId("map-new").focus();
  }

  /** @returns {Promise<boolean>} Whether the robot has answered. */
  async function refresh() {
    const { answer, error } = await request("GET", "/maps");
    if (error !== null) return false;
    maps = answer.maps;
    showList();
    return true;
  }

  function showList() {
    updateList(byId("maps"), JSON.stringify([maps, renamed]), () =>
      maps.length ? maps.map(item) : [createElement("li", "None yet.", "quiet")],
    );
  }

  /** @param {SavedMap} map */
  function item({ name, saved_at: savedAt, in_use: inUse }) {
    const line = createElement("li", "");
    const picture = document.createElement("img");
    Object.assign(picture, { src: `${pathOf(name)}/picture.jpg?saved=${savedAt}`, alt: "", width: 80, height: 60 });
    if (renamed === name) {
      line.append(picture, nameForm(name));
      return line;
    }
    const words = createElement("div", "", "words");
    const date = new Date(1000 * savedAt).toLocaleString(undefined, { dateStyle: "medium", timeStyle: "short" });
    words.append(createElement("b", name), createElement("span", inUse ? `${date}, in use` : date));
    const row = createElement("div", "", "row");
    row.append(
      button("Use", name, () =>
        confirm(`Leave the map it has now and go on in “${name}”?`, "Use it", () =>
          begin(`${pathOf(name)}/begin`, `It goes on in “${name}”.`),
        ),
      ),
      button("Rename", name, () => {
        renamed = name;
        showList();
        field("map-new-name").focus();
        field("map-new-name").select();
      }),
    );
    if (!inUse) {
      row.append(button("Delete", name, () => confirm(`Delete “${name}” for good?`, "Delete it", () => remove(name))));
    }
    line.append(picture, words, row);
    return line;
  }

  /** @param {string} name Of the map that gets another one. */
  function nameForm(name) {
    const form = createElement("form", "", "row");
    const input = document.createElement("input");
    Object.assign(input, { id: "map-new-name", type: "text", value: name, maxLength: 60, autocomplete: "off" });
    input.setAttribute("aria-label", `New name of ${name}`);
    const submit = createElement("button", "Rename", "main");
    const cancel = createElement("button", "Cancel");
    cancel.setAttribute("type", "button");
    cancel.addEventListener("click", () => endRenaming(name));
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      rename(name, input.value.trim());
    });
    form.append(input, submit, cancel);
    return form;
  }

  /** @param {string} name Of the map that has the keyboard's focus then. */
  function endRenaming(name) {
    renamed = null;
    showList();
    document.getElementById(`Rename-${name}`)?.focus();
  }

  /** @param {string} path @param {string} success */
  async function begin(path, success) {
    showText("Telling the robot.");
    const { answer, error } = await request("POST", path, undefined, STEP_TIMEOUT);
    if (error !== null) {
      showText(`Not done: ${error}.`);
      return;
    }
    const left = answer.left === null
      ? "The map it left held too little to be saved."
      : `The map it left is saved as “${answer.left}”.`;
    showText(`${success} ${left}`);
    await refresh();
  }

  /** @param {string} name @param {boolean} replace */
  async function save(name, replace) {
    showText("Telling the robot.");
    const { status, error } = await request("PUT", pathOf(name), { replace }, STEP_TIMEOUT);
    await refresh();
    if (status === 409 && !replace && isNamed(name)) {
      confirm(`There is a map “${name}” already. Replace it?`, "Replace it", () => save(name, true));
      return;
    }
    showText(error === null ? `Saved as “${name}”.` : `Not saved: ${error}.`);
    if (error === null) field("map-name").value = "";
  }

  /** @param {string} name @param {string} newName */
  async function rename(name, newName) {
    if (newName === name) {
      endRenaming(name);
      return;
    }
    if (!NAME.test(newName)) {
      showText(NO_NAME);
      return;
    }
    const { error } = await request("POST", `${pathOf(name)}/rename`, { name: newName });
    showText(error === null ? `“${name}” is called “${newName}” now.` : `Not renamed: ${error}.`);
    if (error !== null) return;
    await refresh();
    endRenaming(newName);
  }

  /** @param {string} name */
  async function remove(name) {
    const { error } = await request("DELETE", pathOf(name));
    showText(error === null ? `“${name}” is deleted.` : `Not deleted: ${error}.`);
    await refresh();
  }

  byId("save-form").addEventListener("submit", (event) => {
    event.preventDefault();
    const name = field("map-name").value.trim();
    byId("maps-ask").hidden = true;
    if (NAME.test(name)) save(name, false);
    else showText(NO_NAME);
  });
  byId("map-new").addEventListener("click", () =>
    confirm("Leave the map it has now and begin an empty one?", "Begin", () =>
      begin("/map/new", "It has begun an empty map."),
    ),
  );
  byId("maps-yes").addEventListener("click", () => {
    close();
    onConfirm();
  });
  byId("maps-no").addEventListener("click", close);
  return { refresh };
}

/** @param {string} name */
function pathOf(name) {
  return `/maps/${encodeURIComponent(name)}`;
}

/**
 * @param {string} text
 * @param {string} name Of the map.
 * @param {() => void} onClick
 */
function button(text, name, onClick) {
  const element = createElement("button", text);
  element.id = `${text}-${name}`;
  element.setAttribute("aria-label", `${text} ${name}`);
  element.addEventListener("click", onClick);
  return element;
}
