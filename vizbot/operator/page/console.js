// @ts-check
/**
 * The console: watches the robot over `/live`, drives it by hand over `/drive`, asks and stops it.
 *
 * @typedef {{number: number, text: string, outcome: string | null, reason: string}} Errand
 * @typedef {{mode: string, battery: number | null, charging: string, feels: string[]}} Base
 * @typedef {{time: number, code: string, text: string}} Line
 * @typedef {object} State
 * @property {boolean} stopped
 * @property {string | null} wheel Who drives by hand.
 * @property {Errand[]} goals Those that are over first, then the running one, then the waiting.
 * @property {number} steps_per_second
 * @property {Base | null} base
 * @property {Line[]} log
 * @property {number | null} step
 * @property {string} activity
 * @property {string} [goal]
 * @property {string} [tracking]
 * @property {number | null} [best_similarity]
 * @property {number} [threshold]
 * @property {number | null} [distance_to_go] [m]
 * @typedef {"live" | "lost" | "locked"} Link
 * @typedef {{forward: number, left: number}} Wish From -1 to 1 each.
 */

/** In the order in which the robot numbers them. */
const PICTURES = ["colour", "depth", "map", "similarity"];
const PICTURES_PER_SECOND = 10;
/** Nothing heard for so long: the link is lost [ms]. */
const LOST_AFTER = 2500;
const RECONNECT_AFTER = 700;
/** Between two motion commands [ms]. */
const DRIVE_EVERY = 50;
/** The robot ignores a command that brings back an older time than this [ms]. */
const OLDEST = 300;
/** The wheel is given back after so long without driving [ms]. */
const IDLE = 60000;
const STOP_TRIES = 10;
const STOP_EVERY = 500;
const DEAD_ZONE = 0.12;
const REST = Object.freeze({ forward: 0, left: 0 });
/** @type {Record<string, {linear: number, angular: number}>} [m/s, rad/s] */
const SPEEDS = {
  slow: { linear: 0.1, angular: 0.5 },
  normal: { linear: 0.2, angular: 0.9 },
  fast: { linear: 0.35, angular: 1.4 },
};
/** @type {Record<string, Wish>} By place on the keyboard, whatever is printed there. */
const KEYS = {
  KeyW: { forward: 1, left: 0 },
  ArrowUp: { forward: 1, left: 0 },
  KeyS: { forward: -1, left: 0 },
  ArrowDown: { forward: -1, left: 0 },
  KeyA: { forward: 0, left: 1 },
  ArrowLeft: { forward: 0, left: 1 },
  KeyD: { forward: 0, left: -1 },
  ArrowRight: { forward: 0, left: -1 },
};
/** @type {Record<string, string>} */
const OUTCOMES = {
  arrived: "Arrived",
  located: "Found on the map",
  not_found: "Not found",
  explored: "Has seen all there is",
  gave_up: "Not done",
};
const GOOD = ["arrived", "located", "explored"];
/** @type {Record<string, string>} */
const MODES = {
  off: "off",
  passive: "not listening",
  safe: "ready",
  full: "ready, without their own guards",
};
/** @type {Record<string, string>} */
const CHARGING = {
  "not charging": "",
  waiting: ", waits to charge",
  fault: ", cannot charge",
};
/** @type {Record<string, string>} */
const TRACKING = {
  tracking: "yes",
  "wheels only": "roughly, by its wheels",
  lost: "no, it is lost",
  relocalised: "yes, again",
};

/**
 * @param {string} id
 * @returns {HTMLElement}
 */
function byId(id) {
  const element = document.getElementById(id);
  if (!element) throw new Error(`the page has no ${id}`);
  return element;
}

/**
 * @param {string} id
 * @returns {HTMLInputElement}
 */
function field(id) {
  return /** @type {HTMLInputElement} */ (byId(id));
}

/**
 * Only what has changed is written, so that nothing is read out twice.
 *
 * @param {HTMLElement} element
 * @param {string} text
 */
function show(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

/**
 * @param {string} tag
 * @param {string} text
 * @param {string} [className]
 */
function make(tag, text, className = "") {
  const element = document.createElement(tag);
  element.textContent = text;
  element.className = className;
  return element;
}

/** @param {string} text */
function capitalised(text) {
  return text.charAt(0).toUpperCase() + text.slice(1);
}

/** @param {number} value */
function within(value) {
  return Math.max(-1, Math.min(1, value));
}

/**
 * @param {string} path
 * @param {Record<string, string>} query
 */
function socketAddress(path, query) {
  const scheme = location.protocol === "https:" ? "wss:" : "ws:";
  return `${scheme}//${location.host}${path}?${new URLSearchParams(query)}`;
}

// The token: a cookie goes along with WebSockets, too, and stays out of addresses.

/** @param {string} token */
function keepToken(token) {
  const secure = location.protocol === "https:" ? "; Secure" : "";
  document.cookie = `token=${encodeURIComponent(token)}; Path=/; SameSite=Strict${secure}`;
}

/** Takes `?token=` out of the address, where it would be seen and kept. */
function takeTokenFromAddress() {
  const address = new URL(location.href);
  const token = address.searchParams.get("token");
  if (token === null) return;
  keepToken(token);
  address.searchParams.delete("token");
  history.replaceState(null, "", address);
}

// Asking.

/**
 * @param {string} path
 * @param {object} [content]
 * @returns {Promise<string | null>} What the robot says against it; null if it agrees.
 */
async function post(path, content) {
  try {
    const answer = await fetch(path, {
      method: "POST",
      headers: { "Content-Type": "application/json" },
      body: content === undefined ? undefined : JSON.stringify(content),
      signal: AbortSignal.timeout(3000),
    });
    return answer.ok ? null : reasonOf(await answer.json());
  } catch {
    return "the robot does not answer";
  }
}

/** @param {{detail?: unknown}} said */
function reasonOf(said) {
  const { detail } = said;
  return Array.isArray(detail) ? String(detail[0]?.msg) : String(detail);
}

/** @param {() => string} who */
function createStop(who) {
  let pressed = 0;

  /** A stop that comes late does no harm; so it is said until the robot has heard it. */
  return async function stop() {
    pressed += 1;
    const mine = pressed;
    for (let tries = 0; tries < STOP_TRIES && mine === pressed; tries += 1) {
      const against = await post("/stop", { who: who() });
      if (against === null) {
        raise("stop", null);
        return;
      }
      raise("stop", "STOP has not reached the robot yet. Trying again. Its Clean button stops it, too.");
      await new Promise((resolve) => setTimeout(resolve, STOP_EVERY));
    }
    if (mine === pressed) {
      raise("stop", "STOP has not reached the robot. Stop it with its Clean button, or lift it.");
    }
  };
}

/**
 * One line for all that is wrong.
 *
 * @param {string} about
 * @param {string | null} text
 */
function raise(about, text) {
  const alarm = byId("alarm");
  if (text === null && alarm.dataset.about !== about) return;
  alarm.dataset.about = about;
  alarm.hidden = text === null;
  show(alarm, text ?? "");
}

// Watching.

/**
 * @param {object} watcher
 * @param {(state: State) => void} watcher.onState
 * @param {(name: string, jpeg: Blob) => void} watcher.onPicture
 * @param {(link: Link) => void} watcher.onLink
 * @param {() => string[]} watcher.wanted Names of the pictures to be sent.
 * @returns {{open: () => void}}
 */
function createLive({ onState, onPicture, onLink, wanted }) {
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
    triedAt = performance.now();
    if (socket) hangUp(socket);
    const images = wanted().join(",");
    socket = new WebSocket(socketAddress("/live", { images, rate: `${PICTURES_PER_SECOND}` }));
    socket.binaryType = "arraybuffer";
    socket.onmessage = hear;
    socket.onclose = () => {
      socket = null;
      needsToken().then((needed) => tell(needed ? "locked" : "lost"));
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
    if (silent && link !== "locked") tell("lost");
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
function hangUp(socket) {
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

// What hands ask for: keys, the stick, a gamepad.

/** @param {(pressed: boolean) => void} onGamepadButton */
function createHands(onGamepadButton) {
  /** @type {Set<string>} */
  const held = new Set();
  /** @type {Wish} */
  let pulled = REST;
  /** A stick that was held when driving began, or when all was let go, counts after its rest. */
  let rested = false;

  /** @returns {Wish} */
  function gamepad() {
    const pads = navigator.getGamepads?.() ?? [];
    const pad = [...pads].find((one) => one?.connected);
    if (!pad) return REST;
    onGamepadButton(pad.buttons.some((button) => button.pressed));
    const [x, y] = [pad.axes[0] ?? 0, pad.axes[1] ?? 0];
    const still = Math.hypot(x, y) < DEAD_ZONE;
    rested = rested || still;
    return still || !rested ? REST : { forward: -y, left: -x };
  }

  /** @returns {Wish} */
  function wish() {
    const wishes = [...held].map((code) => KEYS[code]).concat(pulled, gamepad());
    if (document.visibilityState !== "visible" || !document.hasFocus()) return REST;
    const sum = (/** @type {keyof Wish} */ way) => within(wishes.reduce((all, one) => all + one[way], 0));
    return { forward: sum("forward"), left: sum("left") };
  }

  return {
    wish,
    /** @param {string} code */
    press: (code) => held.add(code),
    /** @param {string} code */
    lift: (code) => held.delete(code),
    /** @param {Wish} to */
    pull: (to) => {
      pulled = to;
    },
    letGo: () => {
      held.clear();
      pulled = REST;
      rested = false;
    },
  };
}

/**
 * @param {(to: Wish) => void} pull Called when the stick moves, and with rest when it is let go.
 * @returns {() => void} Lets go of it.
 */
function createStick(pull) {
  const [stick, knob] = [byId("stick"), byId("knob")];
  /** @type {number | null} */
  let finger = null;

  /** @param {PointerEvent} event */
  function move(event) {
    if (event.pointerId !== finger) return;
    const box = stick.getBoundingClientRect();
    const radius = box.width / 2;
    let x = (event.clientX - box.left - radius) / radius;
    let y = (event.clientY - box.top - radius) / radius;
    const reach = Math.max(1, Math.hypot(x, y));
    [x, y] = [x / reach, y / reach];
    knob.style.transform = `translate(${x * radius * 0.6}px, ${y * radius * 0.6}px)`;
    pull(Math.hypot(x, y) < DEAD_ZONE ? REST : { forward: -y, left: -x });
  }

  function letGo() {
    finger = null;
    knob.style.transform = "";
    pull(REST);
  }

  stick.addEventListener("pointerdown", (event) => {
    if (finger !== null) return;
    finger = event.pointerId;
    stick.setPointerCapture(finger);
    move(event);
  });
  stick.addEventListener("pointermove", move);
  for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
    stick.addEventListener(end, (event) => {
      if (/** @type {PointerEvent} */ (event).pointerId === finger) letGo();
    });
  }
  return letGo;
}

// Driving.

/**
 * @param {object} driver
 * @param {() => Wish} driver.wish
 * @param {() => {linear: number, angular: number}} driver.speed
 * @param {() => void} driver.letGo
 * @param {(holding: boolean, why: string) => void} driver.onChange
 */
function createWheel({ wish, speed, letGo, onChange }) {
  /** @type {WebSocket | null} */
  let socket = null;
  let [holding, resting, sequence] = [false, true, 0];
  let [heard, heardAt, usedAt, openedAt] = [0, 0, 0, 0];

  /**
   * @param {string} who
   * @param {boolean} over Even if somebody else drives.
   */
  function take(who, over) {
    drop("");
    [sequence, resting, openedAt] = [0, true, performance.now()];
    socket = new WebSocket(socketAddress("/drive", { who, over: `${over}` }));
    socket.onmessage = ({ data: said }) => hear(JSON.parse(said));
    socket.onclose = () => drop(holding ? "The link broke: the robot has stopped." : "");
  }

  /** @param {{time?: number, refused?: string | null}} said */
  function hear({ time, refused }) {
    if (time === undefined) {
      drop(`${refused ?? "Somebody else"} drives now.`);
      return;
    }
    [heard, heardAt] = [time, performance.now()];
    if (holding) return;
    [holding, usedAt] = [true, heardAt];
    onChange(true, "");
  }

  /** @param {string} why */
  function drop(why) {
    letGo();
    if (!socket) return;
    rest();
    hangUp(socket);
    [socket, holding] = [null, false];
    onChange(false, why);
  }

  function rest() {
    if (!resting) send(0, 0);
    resting = true;
  }

  /**
   * @param {number} linear
   * @param {number} angular
   */
  function send(linear, angular) {
    if (socket?.readyState !== WebSocket.OPEN) return;
    socket.send(JSON.stringify({ sequence, heard, linear, angular }));
    sequence += 1;
  }

  /** Commands wait in no queue: while the link is stuck nothing is sent. */
  function drive() {
    const { forward, left } = wish();
    const now = performance.now();
    if (!socket) return;
    if (now - Math.max(heardAt, openedAt) > LOST_AFTER) {
      drop("The link broke: the robot has stopped.");
    } else if (forward === 0 && left === 0) {
      rest();
      if (holding && now - usedAt > IDLE) drop("The wheel was given back after a minute of rest.");
    } else if (holding && now - heardAt < OLDEST && socket.bufferedAmount === 0) {
      [resting, usedAt] = [false, now];
      send(forward * speed().linear, left * speed().angular);
    }
  }

  setInterval(drive, DRIVE_EVERY);
  return {
    take,
    /** @param {string} [why] */
    giveBack: (why = "") => drop(why),
    holds: () => holding,
    letGo: () => {
      letGo();
      rest();
    },
  };
}

// What is shown.

/**
 * @param {State} state
 * @param {boolean} driving Whether it is us who drive.
 */
function showState(state, driving) {
  show(byId("activity"), headline(state, driving));
  show(byId("detail"), detail(state, driving));
  show(byId("likeness"), state.goal ? `to “${state.goal}”: red is most alike` : "nothing is asked for");
  showFacts(state);
  showGoals(state);
  showLog(state.log);
}

/**
 * @param {State} state
 * @param {boolean} driving
 */
function headline({ stopped, wheel, activity, goal }, driving) {
  if (stopped) return "Stopped";
  if (driving) return "You drive";
  if (wheel !== null) return `${wheel} drives by hand`;
  if (goal) return `Looking for “${goal}”`;
  return activity === "mapping" ? "Mapping what it sees" : capitalised(activity);
}

/**
 * @param {State} state
 * @param {boolean} driving
 */
function detail({ stopped, wheel, goals, goal, activity, distance_to_go: toGo }, driving) {
  if (stopped) return "It rests until somebody asks for something or drives.";
  const running = goals.some((one) => one.outcome === null);
  if (driving || wheel !== null) {
    return running ? "What it was asked for waits until the wheel is given back." : "";
  }
  if (!running) return "Nothing is asked for.";
  const way = toGo == null ? [] : [`${toGo.toFixed(1)} m to go`];
  return capitalised([...(goal ? [activity] : []), ...way].join(", "));
}

/** @param {State} state */
function showFacts({ base, tracking, best_similarity: best, threshold, steps_per_second: rate }) {
  const battery = base?.battery ?? null;
  const charge = battery === null ? "unknown" : `${Math.round(100 * battery)} %`;
  fact("battery", charge + (CHARGING[base?.charging ?? "not charging"] ?? ", charging"), battery !== null && battery < 0.15);
  const mode = base?.mode ?? "";
  fact("mode", base ? (MODES[mode] ?? mode) : "none", base !== null && ["off", "passive"].includes(mode));
  const feels = base?.feels ?? [];
  fact("feels", feels.join(", ") || "nothing", feels.some((one) => one !== "on charger"));
  fact("tracking", TRACKING[tracking ?? ""] ?? "not yet", tracking === "lost");
  const alike = best == null ? "nothing asked" : `${best.toFixed(2)} (enough: ${threshold?.toFixed(2)})`;
  fact("best", alike, false);
  fact("rate", rate.toFixed(1), false);
}

/**
 * @param {string} id
 * @param {string} text
 * @param {boolean} alarming
 */
function fact(id, text, alarming) {
  show(byId(id), text);
  byId(id).classList.toggle("alarming", alarming);
}

/**
 * A list is made anew only where it has changed.
 *
 * @param {HTMLElement} list
 * @param {string} version
 * @param {() => HTMLElement[]} items
 */
function relist(list, version, items) {
  if (list.dataset.version === version) return;
  list.dataset.version = version;
  list.replaceChildren(...items());
}

/** @param {State} state */
function showGoals({ goals, stopped, wheel }) {
  const over = goals.filter((goal) => goal.outcome !== null).reverse();
  const ahead = goals.filter((goal) => goal.outcome === null);
  const now = stopped || wheel !== null ? "Waits" : "Doing this now";
  relist(byId("goals"), JSON.stringify([goals, now]), () => [
    ...ahead.map((goal, place) => goalItem(goal.text, place ? "Waits for its turn" : now, place ? "" : "running")),
    ...over.map((goal) => goalItem(goal.text, outcomeOf(goal), GOOD.includes(goal.outcome ?? "") ? "good" : "poor")),
    ...(goals.length ? [] : [make("li", "Nothing yet.", "quiet")]),
  ]);
}

/** @param {Errand} errand */
function outcomeOf({ outcome, reason }) {
  const word = OUTCOMES[outcome ?? ""] ?? String(outcome);
  return reason ? `${word}: ${reason}` : word;
}

/**
 * @param {string} text
 * @param {string} told
 * @param {string} className
 */
function goalItem(text, told, className) {
  const item = make("li", "", className);
  item.append(make("b", capitalised(text)), make("span", told));
  return item;
}

/** @param {Line[]} log */
function showLog(log) {
  relist(byId("log"), JSON.stringify([log.length, log.at(-1)]), () => log.map(lineItem).reverse());
}

/** @param {Line} line */
function lineItem({ time, code, text }) {
  const at = new Date(1000 * time);
  const stamp = /** @type {HTMLTimeElement} */ (make("time", at.toLocaleTimeString()));
  stamp.dateTime = at.toISOString();
  const item = make("li", "");
  item.append(stamp, make("span", code === "goal" ? `asked for: ${text}` : text));
  return item;
}

/**
 * @param {string} name
 * @param {Blob} jpeg
 */
function showPicture(name, jpeg) {
  const image = /** @type {HTMLImageElement} */ (
    document.querySelector(`figure[data-picture="${name}"] img`)
  );
  const address = URL.createObjectURL(jpeg);
  image.onload = image.onerror = () => URL.revokeObjectURL(address);
  image.src = address;
}

/** @param {Link} link */
function showLink(link) {
  byId("link").className = `link ${link}`;
  show(byId("link"), { live: "live", lost: "no link", locked: "locked" }[link]);
  byId("token-form").hidden = link !== "locked";
  document.body.classList.toggle("stale", link !== "live");
  const lost =
    "The link to the robot is lost; trying again. If it was driven by hand, it has stopped." +
    " What it was asked for it goes on with.";
  raise("link", link === "lost" ? lost : null);
}

/**
 * @param {State | null} state
 * @param {boolean} driving
 * @param {string} why What ended the driving.
 */
function showWheel(state, driving, why) {
  const other = driving ? null : (state?.wheel ?? null);
  const felt = state?.base?.feels.length ? ` It feels: ${state.base.feels.join(", ")}.` : "";
  document.body.classList.toggle("driving", driving);
  byId("controls").hidden = !driving;
  const nobody = other === null ? "Nobody drives by hand." : `${other} drives by hand.`;
  show(byId("holder"), driving ? `You drive.${felt}` : why || nobody);
  const taking = other === null ? "Take the wheel" : `Take the wheel from ${other}`;
  show(byId("wheel"), driving ? "Give the wheel back" : taking);
}

// What people do.

/**
 * A row of buttons of which one is pressed.
 *
 * @param {NodeListOf<HTMLElement>} buttons
 * @param {string} key Of their `data-`.
 * @param {string} first
 * @param {(value: string) => void} onChoice
 */
function createChoice(buttons, key, first, onChoice) {
  /** @param {string} value */
  const choose = (value) => {
    for (const button of buttons) button.setAttribute("aria-pressed", `${button.dataset[key] === value}`);
    onChoice(value);
  };
  for (const button of buttons) button.addEventListener("click", () => choose(button.dataset[key] ?? first));
  choose(first);
}

/** @param {() => void} onChange */
function createPictureChoice(onChange) {
  const wide = matchMedia("(min-width: 60rem)");
  let chosen = "colour";
  createChoice(document.querySelectorAll("#choices button"), "picture", chosen, (name) => {
    chosen = name;
    for (const figure of document.querySelectorAll("figure")) {
      figure.classList.toggle("shown", figure.dataset.picture === name);
    }
    onChange();
  });
  wide.addEventListener("change", onChange);
  return () => (wide.matches ? PICTURES : [chosen]);
}

function listenToAsking() {
  /** @param {string} text */
  const answer = (text) => show(byId("answer"), text);

  byId("ask-form").addEventListener("submit", async (event) => {
    event.preventDefault();
    const button = /** @type {HTMLButtonElement | null} */ (/** @type {SubmitEvent} */ (event).submitter);
    const text = field("goal").value.trim();
    if (text === "") {
      answer("Say what to go to, for example: yellow chair.");
      field("goal").focus();
      return;
    }
    const against = await post("/goals", { texts: [text], at_once: button?.value === "now" });
    answer(against === null ? `Asked for “${text}”.` : `Not asked: ${against}.`);
    if (against === null) field("goal").value = "";
  });
  byId("explore").addEventListener("click", async () => {
    const against = await post("/explore");
    answer(against === null ? "Asked to explore." : `Not asked: ${against}.`);
  });
  byId("token-form").addEventListener("submit", (event) => {
    event.preventDefault();
    keepToken(field("token").value.trim());
    field("token").value = "";
  });
}

/** @returns {() => string} The name of whoever looks at this page. */
function createName() {
  const name = field("name");
  const unnamed = matchMedia("(pointer: coarse)").matches ? "a phone" : "a computer";
  name.value = localStorage.getItem("name") ?? "";
  name.placeholder = unnamed;
  name.addEventListener("change", () => localStorage.setItem("name", name.value.trim()));
  return () => name.value.trim() || unnamed;
}

/** @param {Event} event */
function isTyping({ target }) {
  return target instanceof HTMLInputElement;
}

/**
 * @param {ReturnType<typeof createHands>} hands
 * @param {ReturnType<typeof createWheel>} wheel
 * @param {() => void} stop
 */
function listenToKeys(hands, wheel, stop) {
  document.addEventListener("keydown", (event) => {
    const stops = event.code === "Escape" || (event.code === "Space" && !isTyping(event));
    if (stops) {
      event.preventDefault();
      if (!event.repeat) stop();
    } else if (event.ctrlKey || event.altKey || event.metaKey) {
      wheel.letGo(); // some systems tell of no key that is lifted meanwhile
    } else if (event.code in KEYS && !isTyping(event) && wheel.holds()) {
      event.preventDefault();
      if (!event.repeat) hands.press(event.code);
    }
  });
  document.addEventListener("keyup", (event) => {
    hands.lift(event.code);
    if (event.code === "Space" && !isTyping(event)) event.preventDefault();
  });
}

/** @param {ReturnType<typeof createWheel>} wheel */
function listenToLeaving(wheel) {
  window.addEventListener("blur", () => wheel.letGo());
  document.addEventListener("visibilitychange", () => wheel.letGo());
  document.addEventListener("focusin", (event) => {
    if (isTyping(event)) wheel.letGo();
  });
  window.addEventListener("pagehide", () => wheel.giveBack());
}

function start() {
  takeTokenFromAddress();
  const who = createName();
  const sendStop = createStop(who);
  /** @type {State | null} */
  let state = null;
  let [pace, ended, buttonDown] = ["normal", "", false];

  const hands = createHands((pressed) => {
    if (pressed && !buttonDown) stop();
    buttonDown = pressed;
  });
  const letGoOfStick = createStick(hands.pull);
  const wheel = createWheel({
    wish: hands.wish,
    speed: () => SPEEDS[pace],
    letGo: () => {
      letGoOfStick();
      hands.letGo();
    },
    onChange: (driving, why) => {
      ended = why;
      if (driving) scrollTo({ top: 0 });
      if (state) showState(state, driving);
      showWheel(state, driving, why);
    },
  });

  function stop() {
    sendStop();
    wheel.giveBack();
  }

  /** @param {State} newest */
  function onState(newest) {
    if (newest.stopped && state?.stopped === false && wheel.holds()) wheel.giveBack();
    if (newest.wheel !== state?.wheel && state?.wheel === null) ended = "";
    state = newest;
    showState(state, wheel.holds());
    showWheel(state, wheel.holds(), state.wheel === null ? ended : "");
  }

  /** @type {{open: () => void} | null} */
  let live = null;
  const wanted = createPictureChoice(() => live?.open());
  live = createLive({ onState, onPicture: showPicture, onLink: showLink, wanted });
  createChoice(document.querySelectorAll("#speeds button"), "speed", pace, (value) => {
    pace = value;
  });
  byId("stop").addEventListener("click", stop);
  byId("wheel").addEventListener("click", () => {
    if (wheel.holds()) wheel.giveBack();
    else wheel.take(who(), (state?.wheel ?? null) !== null);
  });
  listenToAsking();
  listenToKeys(hands, wheel, stop);
  listenToLeaving(wheel);
  live.open();
}

start();
