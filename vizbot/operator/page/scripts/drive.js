// @ts-check
/**
 * Driving by hand over `/drive`.
 *
 * @typedef {import("./drive_input.js").Wish} Wish
 */

import { hangUp, LOST_AFTER, socketAddress } from "./connection.js";

/** Between two motion commands [ms]. */
const DRIVE_EVERY = 50;
/** The robot ignores a command that brings back an older time than this [ms]. */
const OLDEST = 300;
/** The wheel is given back after so long without driving [ms]. */
const IDLE = 60000;
export const STOPPED = "The robot was stopped.";
/** @type {Record<string, {linear: number, angular: number}>} [m/s, rad/s] */
export const SPEEDS = {
  slow: { linear: 0.1, angular: 0.5 },
  normal: { linear: 0.2, angular: 0.9 },
  fast: { linear: 0.35, angular: 1.4 },
};

/**
 * @param {object} driver
 * @param {() => Wish} driver.wish
 * @param {() => {linear: number, angular: number}} driver.speed
 * @param {() => void} driver.letGo
 * @param {(holding: boolean, why: string) => void} driver.onChange
 */
export function createWheel({ wish, speed, letGo, onChange }) {
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

  /** @param {{time?: number, refused?: string | null}} said Nobody drives after a stop. */
  function hear({ time, refused }) {
    if (time === undefined) {
      drop(refused === null ? STOPPED : `${refused} drives now.`);
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

  /** What the robot was doing goes on; where a link just ends it rests. @param {string} [why] */
  function giveBack(why = "") {
    if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify({ done: true }));
    drop(why);
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
      if (holding && now - usedAt > IDLE) giveBack("The wheel was given back after a minute of rest.");
    } else if (holding && now - heardAt < OLDEST && socket.bufferedAmount === 0) {
      [resting, usedAt] = [false, now];
      send(forward * speed().linear, left * speed().angular);
    }
  }

  setInterval(drive, DRIVE_EVERY);
  return {
    take,
    /** @param {string} [why] */
    giveBack,
    /** The robot rests then, until somebody has it go on: nobody may be looking. @param {string} [why] */
    leave: (why = "") => drop(why),
    holds: () => holding,
    letGo: () => {
      letGo();
      rest();
    },
  };
}
