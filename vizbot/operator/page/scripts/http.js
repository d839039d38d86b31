// @ts-check
/**
 * Requests to the robot, and what it says to them.
 *
 * @typedef {object} Reply
 * @property {number} status Of HTTP; 0 where the robot does not answer.
 * @property {any} said
 * @property {string | null} against What the robot says against it; null if it agrees.
 */

const CALLED_OFF = "STOP was pressed";
/** For what the robot answers at once [ms]. */
const SOON = 3000;
/** For what it does between two of its steps, for which it lets us wait 10 s [ms]. */
export const BETWEEN_STEPS = 15000;

/**
 * @param {string} method
 * @param {string} path
 * @param {object | Blob} [content] What is no Blob goes as JSON.
 * @param {number} [patience] [ms]
 * @param {AbortController} [ending]
 * @returns {Promise<Reply>}
 */
export async function request(method, path, content, patience = SOON, ending = new AbortController()) {
  const isBlob = content instanceof Blob;
  const timer = setTimeout(() => ending.abort(), patience);
  try {
    const answer = await fetch(path, {
      method,
      headers: { "Content-Type": isBlob ? content.type : "application/json" },
      body: isBlob || content === undefined ? content : JSON.stringify(content),
      signal: ending.signal,
    });
    const said = await answer.json();
    return { status: answer.status, said, against: answer.ok ? null : reasonOf(said) };
  } catch {
    const against = ending.signal.reason === CALLED_OFF ? CALLED_OFF : "the robot does not answer";
    return { status: 0, said: null, against };
  } finally {
    clearTimeout(timer);
  }
}

/** What is asked of the robot and not answered yet. */
export function createWishes() {
  /** @type {Set<AbortController>} */
  const underWay = new Set();

  return {
    /**
     * @param {string} path
     * @param {object | Blob} [content]
     * @param {number} [patience] [ms]
     */
    ask: async (path, content, patience) => {
      const ending = new AbortController();
      underWay.add(ending);
      const reply = await request("POST", path, content, patience, ending);
      underWay.delete(ending);
      return reply;
    },
    /** After STOP nothing that was asked before is to set the robot going. */
    callOff: () => underWay.forEach((ending) => ending.abort(CALLED_OFF)),
  };
}

/** @typedef {ReturnType<typeof createWishes>} Wishes */

/** @param {string} against A wish. */
export function refusal(against) {
  return against === CALLED_OFF ? "What you asked was not sent on." : `Not asked: ${against}.`;
}

/** @param {{detail?: unknown}} said */
function reasonOf({ detail }) {
  return Array.isArray(detail) ? String(detail[0]?.msg) : String(detail);
}

/**
 * @param {string} path
 * @param {object} [content]
 * @returns {Promise<string | null>} What the robot says against it; null if it agrees.
 */
export async function post(path, content) {
  return (await request("POST", path, content)).against;
}
