"""What the base is told, byte for byte, after what it said: no I/O, and no time but what is given.

Whoever owns the port calls `step` with whatever has come in, and writes what it returns. That is
Drive Direct after every sensor frame, when the wanted speeds change, and when no frame can be made
out: a command that lost a byte is repaired 15 ms later, and a base that is heard no more is still
told to stop. Against a byte that turns into another opcode on the way there is no remedy: one that
ends the base's obedience is noticed and taken back, one that changes its baud rate makes it deaf.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping
from dataclasses import replace

from drivers.roomba.caster_wheel import CasterWheel
from drivers.roomba.commands import Opcode, encode
from drivers.roomba.config import RoombaConfig
from drivers.roomba.drive_command import (
    COMPLETION,
    SURE_STOP,
    ToldSpeeds,
    drive_command,
    harmless,
)
from drivers.roomba.feedback import shown
from drivers.roomba.odometry import WheelOdometry, without_reversal
from drivers.roomba.oi_mode import AT_ONCE, RETRY_PERIOD, OiModeKeeper
from drivers.roomba.packets import Packet, in_range
from drivers.roomba.reflexes import allowed
from drivers.roomba.state import STREAMED, base_state
from drivers.roomba.stream import StreamParser
from vizbot.core.diff_drive import wheel_speeds, within_wheel_limit
from vizbot.core.types import STOP, BaseMode, BaseState, Button, Feedback, Twist

logger = logging.getLogger(__name__)

_TOLD_AGAIN = 5.0
"""A program that is late again and again is told of once in so long, unless it was not [s]."""
_REPEAT = 0.02
"""Sensor frames come every 15 ms; where none can be made out, speeds are told after so long [s]."""
WAKE_UP = encode(Opcode.START) + encode(Opcode.STREAM, *STREAMED)
"""Go to Passive mode and speak."""
_RESTARTED = 100
"""Encoders that count no more than this after a silence may have begun at 0 again."""
_FASTEST = 0.6
"""No wheel turns faster [m/s], pushed or slipping."""
_BURST = 0.1
"""Frames may come in bursts: so much later than they were made [s]."""
_AFTER_START = 0.1
"""By then a frame says in which mode Start has left the base [s]."""


class RoombaControl:
    """Wakes the base up, keeps it in Safe mode while that is asked for, and drives it.

    Attributes:
        state: What it said last; None before the first frame.
        mode_offset: By how much its firmware reports the mode too high; None until that is known.
    """

    def __init__(self, name: str, config: RoombaConfig, now: float) -> None:
        """Ask for Safe mode for as long as a base may take to start.

        Args:
            name: Of the port, for messages.
            config: Limits.
            now: Time [s].
        """
        self.state: BaseState | None = None
        self.mode_offset = config.mode_offset
        self._name = name
        self._config = config
        self._stream = StreamParser(STREAMED)
        self._odometry = WheelOdometry(config.wheel_base, config.wheel_scale)
        self._told = ToldSpeeds(config.echo_delay)
        self._wanted, self._wanted_at = STOP, now
        self._wheels = (0.0, 0.0)
        self._stepped_at = now
        self._halts = False
        self._left_alone_at = -math.inf
        self._distrusted_at: float | None = None
        self._pressed: frozenset[Button] = frozenset()
        self._asides = b""
        self._told_at, self._rolled_at = now, -math.inf
        self._obedience = OiModeKeeper(name, config, now)
        self._front_wheel = CasterWheel(name)

    def drive(self, twist: Twist, now: float) -> None:
        """Hold `twist`, same curvature if too fast, until the next call or the timeout."""
        config = self._config
        turning = min(1.0, config.max_turn_rate / max(abs(twist.angular), 1e-9))
        twist = Twist(twist.linear * turning, twist.angular * turning)
        self._wanted = within_wheel_limit(twist, config.wheel_base, config.max_wheel_speed)
        self._wanted_at = now

    def resume(self, now: float) -> None:
        """Ask to be obeyed, wheels stopped."""
        self._wanted = STOP
        self._obedience.resume(now)

    def seek_dock(self, now: float) -> None:
        """Let the base look for its dock; it obeys again after `resume`."""
        self._wanted = STOP
        self._asides += self._obedience.seek_dock(now)

    def show(self, feedback: Feedback) -> None:
        """Light its LEDs and play a song, if it obeys."""
        self._asides += COMPLETION + shown(feedback)

    def reconnect(self, now: float) -> None:
        """Begin again with a base whose port was gone; its encoders tell how far it ran on."""
        self._stream = StreamParser(STREAMED)
        self._told.forget()
        self._wanted, self._wheels, self._asides = STOP, (0.0, 0.0), b""
        self._obedience.woken_at = -math.inf
        self._obedience.expect(self.state, now)

    def step(self, received: bytes, now: float) -> bytes:
        """Bytes to send after `received` came in; often none."""
        frames = self._stream.feed(received)
        for values in frames:
            self._observe(values, now)
        requests, self._asides = self._asides + self._requests(now), b""
        wheels = self._next_wheels(now)
        repeats = frames or not received or now - self._told_at > _REPEAT
        if not requests and not repeats and wheels == self._told.latest:
            return b""
        self._told_at = now
        self._told.tell(wheels, now)
        if wheels != (0, 0):
            self._rolled_at = now
        return requests + drive_command(*wheels)

    def _hears(self, now: float) -> bool:
        """Whether the base has spoken lately."""
        state = self.state
        return state is not None and now - state.stamp <= self._config.silence_timeout + 1e-9

    def _observe(self, values: Mapping[Packet, int], now: float) -> None:
        """Take in one sensor frame; one that no sound base could send is dropped."""
        if self.mode_offset is None:
            self.mode_offset = self._learned_offset(values[Packet.OI_MODE], now)
        mode = values[Packet.OI_MODE] - (self.mode_offset or 0)
        if self.mode_offset is None:
            return
        sound = {**values, Packet.OI_MODE: mode}
        if not all(in_range(packet, value) for packet, value in sound.items()):
            logger.debug("%s: dropped an impossible sensor frame: %s", self._name, values)
            return
        before, counts = self.state, (values[Packet.LEFT_ENCODER], values[Packet.RIGHT_ENCODER])
        elapsed = 0.0 if before is None else now - before.stamp
        if elapsed > self._config.silence_timeout and max(map(abs, counts)) < _RESTARTED:
            self._odometry.skip()
        farthest = _FASTEST * (elapsed + _BURST)
        if not self._odometry.update(*counts, farthest):
            logger.warning("%s: rejected encoder counts that jumped to %s", self._name, counts)
        state = base_state(values, now, self._odometry.T_odom_base, BaseMode(mode))
        # A frame that is spoilt may pass its checksum: a button counts from its second frame on.
        pressed, self._pressed = self._pressed, state.buttons
        self.state = replace(state, buttons=state.buttons & pressed)
        touched = before is not None and (before.blocked or any(before.cliffs))
        if (state.blocked or any(state.cliffs)) and not touched:
            self._wanted, self._halts = STOP, True  # until the program has heard of it
        if before is not None and before.mode.obeys and not state.mode.obeys:
            self._told.forget()
        self._obedience.follow(before, self.state, now)
        right, left = self._told.latest or (0, 0)
        ahead = right == left > 0 and not any(self._odometry.at_rest)
        self._front_wheel.observe(state, ahead=ahead)
        self._compare(values, self.state)

    def _learned_offset(self, reported: int, now: float) -> int | None:
        """Start ends in Passive mode, 1; some firmware calls that 2."""
        if reported == BaseMode.PASSIVE:
            return 0
        woken_at = self._obedience.woken_at
        woken = math.isfinite(woken_at) and now - woken_at > _AFTER_START
        if woken and reported == BaseMode.PASSIVE + 1:
            logger.warning("%s: this firmware reports its mode one too high", self._name)
            return 1
        return None

    def _compare(self, values: Mapping[Packet, int], state: BaseState) -> None:
        """Stop a base that says it was told other speeds than it was, until it says it stops."""
        says = values[Packet.REQUESTED_RIGHT_VELOCITY], values[Packet.REQUESTED_LEFT_VELOCITY]
        if self._distrusted_at is not None:
            waited = state.stamp - self._distrusted_at >= self._config.echo_delay
            if waited and says == (0, 0):
                self._distrusted_at = None
        elif state.mode is self._obedience.goal and not self._told.explain(
            says, 1000 * self._config.echo_tolerance
        ):
            logger.warning(
                "%s: the base took %s mm/s for its speeds, not %s: stopped; if that goes on, check"
                " its cable, or raise echo_tolerance in [roomba]",
                self._name, says, self._told.latest,
            )  # fmt: skip
            self._distrusted_at = state.stamp

    def _requests(self, now: float) -> bytes:
        """What is asked for besides speeds: to speak, to obey."""
        if not self._hears(now):
            return self._wake_up(now)
        request = self._obedience.request(now)
        if request:
            self._wanted = STOP
        return request

    def _wake_up(self, now: float) -> bytes:
        """What is sent to a base that has fallen silent, or not spoken yet."""
        state, obedience = self.state, self._obedience
        silent_since = -math.inf if state is None else state.stamp
        rolled = self._rolled_at >= silent_since or not all(self._odometry.at_rest)
        obeyed = state is not None and state.mode.obeys
        if obeyed and rolled and now - silent_since <= RETRY_PERIOD:
            # A spoilt byte may have ended all (Stop, 173): then it rolls on until it obeys again.
            runs_away, since, patience = True, obedience.woken_at, AT_ONCE
        else:
            # What it was told before may still have to stop the wheels: Start ends its obedience.
            runs_away, since = False, max(obedience.woken_at, silent_since)
            patience = RETRY_PERIOD
        if now - since < patience - 1e-9:
            return b""
        obedience.expect(state, now)
        obedience.woken_at, self._wanted = now, STOP
        return SURE_STOP + WAKE_UP + (obedience.request_unheard(now) if runs_away else b"")

    def _next_wheels(self, now: float) -> tuple[int, int]:
        """Right and left wheel speed to command now [mm/s]."""
        state, config, period = self.state, self._config, now - self._stepped_at
        self._stepped_at = now
        at_once = self._halts or self._distrusted_at is not None or not self._hears(now)
        self._halts = False
        if self._wanted != STOP and now - self._wanted_at > config.command_timeout - 1e-9:
            level = logging.WARNING if now - self._left_alone_at > _TOLD_AGAIN else logging.DEBUG
            logger.log(
                level,
                "%s: no command for %s s: stopped; the program hangs, or this machine is too slow",
                self._name, config.command_timeout,
            )  # fmt: skip
            self._wanted, at_once, self._left_alone_at = STOP, True, now
        twist = STOP if state is None or at_once else allowed(self._wanted, state)
        left, right = wheel_speeds(twist, config.wheel_base)
        right_now, left_now = self._wheels
        rolling = Twist((right_now + left_now) / 2, (right_now - left_now) / config.wheel_base)
        for asked in (self._wanted, rolling):
            at_once = at_once or state is None or (asked != STOP and allowed(asked, state) == STOP)
        self._wheels = (right, left) if at_once else self._ramped((right, left), period)
        most = min(500, int(1000 * config.max_wheel_speed / config.wheel_scale + 1e-9))
        right_mm_s, left_mm_s = (
            harmless(max(-most, min(most, round(1000 * speed / config.wheel_scale))), most)
            for speed in self._wheels
        )
        told, rest = self._told.latest or (0, 0), self._odometry.at_rest
        return (
            without_reversal(right_mm_s, told[0], rest[1]),
            without_reversal(left_mm_s, told[1], rest[0]),
        )

    def _ramped(self, wanted: tuple[float, float], period: float) -> tuple[float, float]:
        """As far from the present speeds to the wanted ones as `period` [s] allows, both alike."""
        config, share = self._config, 1.0
        for now, then in zip(self._wheels, wanted, strict=True):
            rate = config.acceleration if abs(then) > abs(now) else config.deceleration
            share = min(share, rate * period / max(abs(then - now), 1e-9))
        right, left = (
            now + share * (then - now) for now, then in zip(self._wheels, wanted, strict=True)
        )
        return right, left
