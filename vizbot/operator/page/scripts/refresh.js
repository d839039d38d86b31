// @ts-check
/**
 * Asks again for what changes seldom, when the robot's log says that its maps have changed.
 *
 * @typedef {import("./state_view.js").State} State
 */

/** After the robot has not answered [ms]. */
const AGAIN_AFTER = 3000;

/** @param {(() => Promise<boolean>)[]} renewals Each tells whether it was answered. */
export function createRenewal(renewals) {
  let [due, busy, notBefore, told] = [true, false, 0, "null"];

  async function renew() {
    [due, busy] = [false, true];
    const answered = await Promise.all(renewals.map((one) => one()));
    busy = false;
    if (answered.every(Boolean)) return;
    [due, notBefore] = [true, performance.now() + AGAIN_AFTER];
  }

  return {
    /** It may be another robot by now. */
    start: () => {
      due = true;
    },
    /** @param {State} state */
    follow: ({ log, map_view: view }) => {
      const newest = JSON.stringify(log.filter(({ code }) => code === "map").at(-1) ?? null);
      due = due || newest !== told;
      told = newest;
      // before its first step it answers nobody
      if (due && !busy && view !== null && performance.now() >= notBefore) renew();
    },
  };
}
