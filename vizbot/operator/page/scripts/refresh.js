// @ts-check
/**
 * Reads again what changes seldom, when the robot's log says that its maps have changed.
 *
 * @typedef {import("./state_view.js").State} State
 */

/** Pause after the robot has not answered [ms]. */
const RETRY_AFTER = 3000;

/** @param {(() => Promise<boolean>)[]} refreshers Each returns whether the robot has answered. */
export function createRefresh(refreshers) {
  let [due, busy, notBefore, newestLine] = [true, false, 0, "null"];

  async function refresh() {
    [due, busy] = [false, true];
    const answered = await Promise.all(refreshers.map((refresher) => refresher()));
    busy = false;
    if (answered.every(Boolean)) return;
    [due, notBefore] = [true, performance.now() + RETRY_AFTER];
  }

  return {
    /** Reads all again: it may be another robot by now. */
    invalidate: () => {
      due = true;
    },
    /** @param {State} state */
    update: ({ log, map_view: view }) => {
      const line = JSON.stringify(log.findLast(({ code }) => code === "map") ?? null);
      due = due || line !== newestLine;
      newestLine = line;
      // before its first step the robot answers nobody
      if (due && !busy && view !== null && performance.now() >= notBefore) refresh();
    },
  };
}
