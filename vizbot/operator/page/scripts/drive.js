// @ts-check
/**
 * Driving by hand over `/drive`.
 *
 * @typedef {import("./drive_input.js").DriveVector} DriveVector
 * @typedef {{linear: number, angular: number}} Speed [m/s, rad/s]
 */

import { disconnect, LOST_AFTER, socketAddress } from "./connection.js";
import { capitalised } from "./dom.js";
import { personOf } from "./words.js";

/** Between two motion commands [ms]. */
const DRIVE_EVERY = 50;
/** The robot ignores a command that brings back an older time stamp than this [ms]. */
const COMMAND_TIMEOUT = 300;
/** The lease is given back after so long without driving [ms]. */
const IDLE_TIMEOUT = 60000;
export const STOPPED = "The robot was stopped.";
/** @type {Record<"slow" | "normal" | "fast", Speed>} */
export const SPEEDS = {
  slow: { linear: 0.1, angular: 0.5 },
  normal: { linear: 0.2, angular: 0.9 },
  fast: { linear: 0.35, angular: 1.4 },
};

/**
 * The lease to drive: taken, kept alive by motion commands, given back.
 *
 * @param {object} driver
 * @param {() => DriveVector} driver.input
 * @param {() => Speed} driver.speed At full input.
 * @param {() => void} driver.resetInput
 * @param {(holding: boolean, reason: string) => void} driver.onChange
 */
export function createDriveLease({ input, speed, resetInput, onChange }) {
  /** @type {WebSocket | null} */
  let socket = null;
  let [holding, atRest, sequence] = [false, true, 0];
  let [stamp, stampAt, drivenAt, openedAt] = [0, 0, 0, 0];

  /**
   * @param {string} who
   * @param {boolean} over Even if somebody else drives.
   */
  function take(who, over) {
    close("");
    [sequence, atRest, openedAt] = [0, true, performance.now()];
    socket = new WebSocket(socketAddress("/drive", { who, over: `${over}` }));
    socket.onmessage = ({ data: text }) => receive(JSON.parse(text));
    socket.onclose = () => close(holding ? "The link broke: the robot has stopped." : "");
  }

  /** @param {{time?: number, refused?: string | null}} message `refused` is null after a stop. */
  function receive({ time, refused }) {
    if (time === undefined) {
      close(refused == null ? STOPPED : capitalised(`${personOf(refused)} drives now.`));
      return;
    }
    [stamp, stampAt] = [time, performance.now()];
    if (holding) return;
    [holding, drivenAt] = [true, stampAt];
    onChange(true, "");
  }

  /** @param {string} reason */
  function close(reason) {
    resetInput();
    if (!socket) return;
    stopMotion();
    disconnect(socket);
    [socket, holding] = [null, false];
    onChange(false, reason);
  }

  /**
   * The robot goes on with its task; where a link just ends, it rests.
   *
   * @param {string} [reason]
   */
  function giveBack(reason = "") {
    if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify({ done: true }));
    close(reason);
  }

  function stopMotion() {
    if (!atRest) send(0, 0);
    atRest = true;
  }

  /**
   * @param {number} linear
   * @param {number} angular
   */
  function send(linear, angular) {
    if (socket?.readyState !== WebSocket.OPEN) return;
    socket.send(JSON.stringify({ sequence, heard: stamp, linear, angular }));
    sequence += 1;
  }

  /** Sends a command, or nothing while the link is stuck: no command waits in a queue. */
  function drive() {
    const { forward, left } = input();
    const now = performance.now();
    if (!socket) return;
    if (now - Math.max(stampAt, openedAt) > LOST_AFTER) {
      close("The link broke: the robot has stopped.");
    } else if (forward === 0 && left === 0) {
      stopMotion();
      if (holding && now - drivenAt > IDLE_TIMEOUT) giveBack("The wheel was given back after a minute of rest.");
    } else if (holding && now - stampAt < COMMAND_TIMEOUT && socket.bufferedAmount === 0) {
      [atRest, drivenAt] = [false, now];
      send(forward * speed().linear, left * speed().angular);
    }
  }

  setInterval(drive, DRIVE_EVERY);
  return {
    take,
    giveBack,
    /**
     * The robot rests until somebody has it go on: nobody may be looking.
     *
     * @param {string} [reason]
     */
    abandon: (reason = "") => close(reason),
    isHeld: () => holding,
    stopMotion: () => {
      resetInput();
      stopMotion();
    },
  };
}
