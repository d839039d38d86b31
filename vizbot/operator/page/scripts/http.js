// @ts-check
/**
 * HTTP requests to the robot and their answers.
 *
 * @typedef {object} Reply
 * @property {number} status Of HTTP; 0 where the robot does not answer.
 * @property {any} answer The JSON that the robot sends; null where it does not answer.
 * @property {string | null} error Why the robot refuses; null where it does not.
 */

const NOT_FOUND = 404;
const ABORTED = "STOP was pressed";
/** Of requests that the robot answers at once [ms]. */
const TIMEOUT = 3000;
/** Of requests that wait for the end of a step, for which the robot allows 10 s [ms]. */
export const STEP_TIMEOUT = 15000;

/**
 * @param {string} method
 * @param {string} path
 * @param {object | Blob} [content] Anything but a Blob is sent as JSON.
 * @param {number} [timeout] [ms]
 * @param {AbortController} [controller]
 * @returns {Promise<Reply>}
 */
export async function request(method, path, content, timeout = TIMEOUT, controller = new AbortController()) {
  const isBlob = content instanceof Blob;
  const timer = setTimeout(() => controller.abort(), timeout);
  try {
    const response = await fetch(path, {
      method,
      headers: { "Content-Type": isBlob ? content.type : "application/json" },
      body: isBlob || content === undefined ? content : JSON.stringify(content),
      signal: controller.signal,
    });
    const answer = await response.json();
    return { status: response.status, answer, error: response.ok ? null : errorText(answer) };
  } catch {
    const error = controller.signal.reason === ABORTED ? ABORTED : "the robot does not answer";
    return { status: 0, answer: null, error };
  } finally {
    clearTimeout(timer);
  }
}

/**
 * @param {string} path
 * @returns {Promise<{picture: Blob | null, missing: string | null}>} Why there is no such picture;
 *   null where there is one, or the robot has not answered.
 */
export async function requestPicture(path) {
  try {
    const response = await fetch(path, { signal: AbortSignal.timeout(STEP_TIMEOUT) });
    if (response.ok) return { picture: await response.blob(), missing: null };
    const missing = response.status === NOT_FOUND ? errorText(await response.json()) : null;
    return { picture: null, missing };
  } catch {
    return { picture: null, missing: null };
  }
}

/** Requests that the robot has not answered yet; STOP aborts all of them. */
export function createPendingRequests() {
  /** @type {Set<AbortController>} */
  const pending = new Set();

  return {
    /**
     * @param {string} path
     * @param {object | Blob} [content]
     * @param {number} [timeout] [ms]
     */
    post: async (path, content, timeout) => {
      const controller = new AbortController();
      pending.add(controller);
      const reply = await request("POST", path, content, timeout, controller);
      pending.delete(controller);
      return reply;
    },
    /** Keeps what was asked before a STOP from starting the robot after it. */
    abortAll: () => pending.forEach((controller) => controller.abort(ABORTED)),
  };
}

/** @typedef {ReturnType<typeof createPendingRequests>} PendingRequests */

/** @param {string} error Of a request for a task. */
export function refusalText(error) {
  return error === ABORTED ? "What you asked was not sent on." : `Not asked: ${error}.`;
}

/** @param {{detail?: unknown}} answer */
function errorText({ detail }) {
  return Array.isArray(detail) ? String(detail[0]?.msg) : String(detail);
}

/**
 * @param {string} path
 * @param {object} [content]
 * @returns {Promise<string | null>} Why the robot refuses; null where it does not.
 */
export async function post(path, content) {
  return (await request("POST", path, content)).error;
}
