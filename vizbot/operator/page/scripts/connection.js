// @ts-check
/**
 * The connection to the robot: its token, STOP, and the WebSocket that shows its state.
 *
 * @typedef {import("./state_view.js").State} State
 * @typedef {"live" | "lost" | "ended" | "locked" | "refused" | "crowded"} Link
 */

import { setAlarm } from "./dom.js";
import { post } from "./http.js";

/** In the order in which the robot numbers them. */
export const PICTURES = ["colour", "depth", "map", "likeness"];
const PICTURES_PER_SECOND = 10;
/** A link that has brought nothing for this long is lost [ms]. */
export const LOST_AFTER = 2500;
const RECONNECT_AFTER = 700;
/** The code with which the robot closes a WebSocket when too many watch already. */
const TRY_AGAIN_LATER = 1013;
/** The code with which it closes them when its program ends in order. */
const SERVICE_RESTART = 1012;
/** Between two tries to send a stop [ms]. */
const STOP_EVERY = 500;
/** Stored by the browser for this tab, so that a page that is reloaded still sends the stop. */
const UNCONFIRMED_STOP = "unheard-stop";
const UNCONFIRMED =
  "STOP has not reached the robot yet. It is sent again until it does." +
  " The robot's own Clean button stops it, too.";

/**
 * @param {string} path
 * @param {Record<string, string>} query
 */
export function socketAddress(path, query) {
  const scheme = location.protocol === "https:" ? "wss:" : "ws:";
  return `${scheme}//${location.host}${path}?${new URLSearchParams(query)}`;
}

/**
 * Stores the token as a cookie, which goes along with WebSockets, too, and stays out of addresses.
 *
 * @param {string} token
 */
export function storeToken(token) {
  const secure = location.protocol === "https:" ? "; Secure" : "";
  document.cookie = `token=${encodeURIComponent(token)}; Path=/; SameSite=Strict${secure}`;
}

function storedToken() {
  return /(?:^|; )token=([^;]+)/.exec(document.cookie)?.[1] ?? null;
}

/** Moves `?token=` out of the address, where people would see it and bookmark it. */
export function moveTokenOutOfAddress() {
  const address = new URL(location.href);
  const token = address.searchParams.get("token");
  if (token === null) return;
  storeToken(token);
  address.searchParams.delete("token");
  history.replaceState(null, "", address);
}

/** @param {boolean} unconfirmed Whether the robot has not confirmed the stop yet. */
function storeStop(unconfirmed) {
  try {
    if (unconfirmed) sessionStorage.setItem(UNCONFIRMED_STOP, "yes");
    else sessionStorage.removeItem(UNCONFIRMED_STOP);
  } catch {
    // this browser stores nothing; the page does without
  }
}

function isStopStored() {
  try {
    return sessionStorage.getItem(UNCONFIRMED_STOP) !== null;
  } catch {
    return false;
  }
}

/**
 * Sends stops until the robot confirms them. One left over from before a reload is sent at once.
 *
 * @param {() => string} who
 */
export function createStop(who) {
  let [newest, confirmed] = [0, 0];

  /** A stop that comes late does no harm; so it is sent until the robot has confirmed it. */
  async function stop() {
    newest += 1;
    const number = newest;
    storeStop(true);
    setTimeout(() => {
      if (confirmed < number) setAlarm("stop", UNCONFIRMED);
    }, STOP_EVERY);
    while (number === newest) {
      if ((await post("/stop", { who: who() })) === null) {
        confirmed = Math.max(confirmed, number);
        if (confirmed === newest) {
          setAlarm("stop", null);
          storeStop(false);
        }
        return;
      }
      await new Promise((resolve) => setTimeout(resolve, STOP_EVERY));
    }
  }

  /** Sends an unconfirmed stop at once, where the link lives again. */
  function resend() {
    if (confirmed < newest) stop();
  }

  if (isStopStored()) stop();
  return { stop, resend };
}

/**
 * @param {object} watcher
 * @param {(state: State) => void} watcher.onState
 * @param {(name: string, jpeg: Blob) => void} watcher.onPicture
 * @param {(link: Link) => void} watcher.onLink
 * @param {() => string[]} watcher.wanted Names of the pictures to be sent.
 * @returns {{open: () => void, retry: () => void}}
 */
export function createLiveLink({ onState, onPicture, onLink, wanted }) {
  /** @type {WebSocket | null} */
  let socket = null;
  let receivedAt = performance.now();
  let openedAt = 0;
  /** @type {Link | null} */
  let link = null;

  /** @param {Link} newLink */
  function setLink(newLink) {
    if (newLink !== link) onLink(newLink);
    link = newLink;
  }

  /** Whoever knows that the program has ended need not be told that nobody answers. */
  function setLost() {
    if (link !== "ended") setLink("lost");
  }

  /** Asks anew, also where the answer may be the same as before. */
  function retry() {
    link = null;
    receivedAt = performance.now();
    open();
  }

  function open() {
    const opened = performance.now();
    openedAt = opened;
    if (socket) disconnect(socket);
    const images = wanted().join(",");
    socket = new WebSocket(socketAddress("/live", { images, rate: `${PICTURES_PER_SECOND}` }));
    socket.binaryType = "arraybuffer";
    socket.onmessage = receive;
    socket.onclose = ({ code }) => {
      socket = null;
      if (code === TRY_AGAIN_LATER || code === SERVICE_RESTART) {
        setLink(code === TRY_AGAIN_LATER ? "crowded" : "ended");
        return;
      }
      const token = storedToken();
      isLocked().then((locked) => {
        const outdated = (opened !== openedAt && link === "live") || token !== storedToken();
        if (outdated) return;
        if (locked) setLink(token === null ? "locked" : "refused");
        else setLost();
      });
    };
  }

  /** @param {MessageEvent} event */
  function receive({ data: content }) {
    receivedAt = performance.now();
    setLink("live");
    if (typeof content === "string") {
      onState(JSON.parse(content));
      return;
    }
    const [index = 0] = new Uint8Array(content, 0, 1);
    const name = PICTURES[index];
    if (name) onPicture(name, new Blob([new Uint8Array(content, 1)], { type: "image/jpeg" }));
  }

  setInterval(() => {
    const now = performance.now();
    const silent = now - receivedAt > LOST_AFTER;
    if (silent && (link === "live" || link === null)) setLink("lost");
    const hopeless = silent && now - openedAt > LOST_AFTER;
    if (hopeless || (socket === null && now - openedAt > RECONNECT_AFTER)) open();
  }, 250);
  return { open, retry };
}

/**
 * Closes a WebSocket and ignores what it still brings: a broken link may take minutes to close.
 *
 * @param {WebSocket} socket
 */
export function disconnect(socket) {
  socket.onmessage = null;
  socket.onclose = null;
  socket.onopen = null;
  socket.close();
}

/** Asks whether the robot wants another token: a refused WebSocket gives no reason. */
async function isLocked() {
  try {
    return (await fetch("/state", { signal: AbortSignal.timeout(3000) })).status === 401;
  } catch {
    return false;
  }
}
