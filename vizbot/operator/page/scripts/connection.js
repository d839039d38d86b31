// @ts-check
/**
 * The links to the robot: its token, stop, and what is watched.
 *
 * @typedef {import("./state_view.js").State} State
 * @typedef {"live" | "lost" | "locked" | "crowded"} Link
 */

import { raise } from "./dom.js";
import { post } from "./http.js";

/** In the order in which the robot numbers them. */
export const PICTURES = ["colour", "depth", "map", "similarity"];
const PICTURES_PER_SECOND = 10;
/** Nothing heard for so long: the link is lost [ms]. */
export const LOST_AFTER = 2500;
const RECONNECT_AFTER = 700;
/** With this the robot closes a link when too many are watching already. */
const TRY_AGAIN_LATER = 1013;
/** A stop that is not heard is said again after so long [ms]. */
const STOP_EVERY = 500;
/** Kept by the browser for this tab, so that a page that is loaded anew still says it. */
const UNHEARD_STOP = "unheard-stop";
const UNHEARD =
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
 * As a cookie, which goes along with WebSockets, too, and stays out of addresses.
 *
 * @param {string} token
 */
export function keepToken(token) {
  const secure = location.protocol === "https:" ? "; Secure" : "";
  document.cookie = `token=${encodeURIComponent(token)}; Path=/; SameSite=Strict${secure}`;
}

/** Takes `?token=` out of the address, where it would be seen and kept. */
export function takeTokenFromAddress() {
  const address = new URL(location.href);
  const token = address.searchParams.get("token");
  if (token === null) return;
  keepToken(token);
  address.searchParams.delete("token");
  history.replaceState(null, "", address);
}

/** @param {boolean} unheard Whether a stop is still to be heard. */
function keepStop(unheard) {
  try {
    if (unheard) sessionStorage.setItem(UNHEARD_STOP, "yes");
    else sessionStorage.removeItem(UNHEARD_STOP);
  } catch {
    // this browser keeps nothing; the page does without
  }
}

function isStopKept() {
  try {
    return sessionStorage.getItem(UNHEARD_STOP) !== null;
  } catch {
    return false;
  }
}

/**
 * A stop that was not heard before the page was loaded anew is said at once.
 *
 * @param {() => string} who
 */
export function createStop(who) {
  let [pressed, heard] = [0, 0];

  /** A stop that comes late does no harm; so it is said until the robot has heard it. */
  async function stop() {
    pressed += 1;
    const mine = pressed;
    keepStop(true);
    setTimeout(() => {
      if (heard < mine) raise("stop", UNHEARD);
    }, STOP_EVERY);
    while (mine === pressed) {
      if ((await post("/stop", { who: who() })) === null) {
        heard = Math.max(heard, mine);
        if (heard === pressed) {
          raise("stop", null);
          keepStop(false);
        }
        return;
      }
      await new Promise((resolve) => setTimeout(resolve, STOP_EVERY));
    }
  }

  /** The link lives again: what it has not carried is said anew at once. */
  function repeat() {
    if (heard < pressed) stop();
  }

  if (isStopKept()) stop();
  return { stop, repeat };
}

/**
 * @param {object} watcher
 * @param {(state: State) => void} watcher.onState
 * @param {(name: string, jpeg: Blob) => void} watcher.onPicture
 * @param {(link: Link) => void} watcher.onLink
 * @param {() => string[]} watcher.wanted Names of the pictures to be sent.
 * @returns {{open: () => void}}
 */
export function createLive({ onState, onPicture, onLink, wanted }) {
  /** @type {WebSocket | null} */
  let socket = null;
  let heardAt = performance.now();
  let triedAt = 0;
  /** @type {Link | null} */
  let link = null;

  /** @param {Link} now */
  function tell(now) {
    if (now !== link) onLink(now);
    link = now;
  }

  function open() {
    const tried = performance.now();
    triedAt = tried;
    if (socket) hangUp(socket);
    const images = wanted().join(",");
    socket = new WebSocket(socketAddress("/live", { images, rate: `${PICTURES_PER_SECOND}` }));
    socket.binaryType = "arraybuffer";
    socket.onmessage = hear;
    socket.onclose = ({ code }) => {
      socket = null;
      if (code === TRY_AGAIN_LATER) {
        tell("crowded");
        return;
      }
      needsToken().then((needed) => {
        const outdated = tried !== triedAt && link === "live";
        if (!outdated) tell(needed ? "locked" : "lost");
      });
    };
  }

  /** @param {MessageEvent} event */
  function hear({ data: said }) {
    heardAt = performance.now();
    tell("live");
    if (typeof said === "string") {
      onState(JSON.parse(said));
      return;
    }
    const name = PICTURES[new Uint8Array(said, 0, 1)[0]];
    onPicture(name, new Blob([new Uint8Array(said, 1)], { type: "image/jpeg" }));
  }

  setInterval(() => {
    const now = performance.now();
    const silent = now - heardAt > LOST_AFTER;
    if (silent && link !== "locked" && link !== "crowded") tell("lost");
    const hopeless = silent && now - triedAt > LOST_AFTER;
    if (hopeless || (socket === null && now - triedAt > RECONNECT_AFTER)) open();
  }, 250);
  return { open };
}

/**
 * Nothing of it is heard any more: a broken link may take minutes to close.
 *
 * @param {WebSocket} socket
 */
export function hangUp(socket) {
  socket.onmessage = null;
  socket.onclose = null;
  socket.onopen = null;
  socket.close();
}

/** A refused WebSocket does not say why. */
async function needsToken() {
  try {
    return (await fetch("/state", { signal: AbortSignal.timeout(3000) })).status === 401;
  } catch {
    return false;
  }
}
