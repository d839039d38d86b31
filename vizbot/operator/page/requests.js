// @ts-check
/**
 * Requests to the robot, and what it says to them.
 *
 * @typedef {object} Reply
 * @property {number} status Of HTTP; 0 where the robot does not answer.
 * @property {any} said
 * @property {string | null} against What the robot says against it; null if it agrees.
 */

/** For what the robot answers at once [ms]. */
const SOON = 3000;
/** For what it does between two of its steps, for which it lets us wait 10 s [ms]. */
export const BETWEEN_STEPS = 15000;

/**
 * @param {string} method
 * @param {string} path
 * @param {object | Blob} [content] What is no Blob goes as JSON.
 * @param {number} [patience] [ms]
 * @returns {Promise<Reply>}
 */
export async function request(method, path, content, patience = SOON) {
  const isBlob = content instanceof Blob;
  try {
    const answer = await fetch(path, {
      method,
      headers: { "Content-Type": isBlob ? content.type : "application/json" },
      body: isBlob || content === undefined ? content : JSON.stringify(content),
      signal: AbortSignal.timeout(patience),
    });
    const said = await answer.json();
    return { status: answer.status, said, against: answer.ok ? null : reasonOf(said) };
  } catch {
    return { status: 0, said: null, against: "the robot does not answer" };
  }
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
