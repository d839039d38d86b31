"""The control of the base: commands out, byte for byte, for sensor bytes in; no I/O and no clock.

The owner of the port calls `step` with the bytes received, and writes the bytes returned. The bytes
hold Drive Direct after every sensor frame, when the wanted speeds change, and when no frame can be
decoded: a command that lost a byte is repaired 15 ms later, and a base that is no longer heard is
still commanded to stop. There is no protection against a byte that turns into another opcode on the
line: a change of mode is noticed and reverted, a change of the baud rate makes the base deaf.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping
from dataclasses import replace

from drivers.roomba.commands import Opcode, encode, show_feedback
from drivers.roomba.config import RoombaConfig
from drivers.roomba.drive_command import (
    COMPLETION,
    SURE_STOP,
    CommandedSpeeds,
    allowed,
    drive_command,
    within_limits,
)
from drivers.roomba.odometry import CasterWheel, WheelOdometry, without_reversal
from drivers.roomba.oi_mode import AT_ONCE, REST_BY_FORCE, RETRY_PERIOD, OiModeKeeper
from drivers.roomba.packets import Packet
from drivers.roomba.state import STREAMED, base_state
from drivers.roomba.stream import OddValues, StreamParser
from vizbot.core.diff_drive import wheel_speeds, within_wheel_limit
from vizbot.core.types import STOP, BaseMode, BaseState, Button, Feedback, Twist

logger = logging.getLogger(__name__)

_WARN_AGAIN = 5.0
"""Least time between two warnings of a program whose commands are late [s]."""
_REPEAT = 0.02
"""Time after which speeds are sent again where no sensor frame, due every 15 ms, is decoded [s]."""
_STREAM = encode(Opcode.STREAM, *STREAMED)
WAKE_UP = encode(Opcode.START) + _STREAM
"""Commands that put the base in Passive mode and start its stream."""
_RESTARTED = 100
"""Largest counts after a silence at which the encoders may have restarted at 0."""
_FASTEST = 0.6
"""Largest speed of a wheel, also pushed or slipping [m/s]."""
_BURST = 0.1
"""Largest delay of frames that arrive in a burst [s]."""
_AFTER_START = 0.1
"""Time after Start by which a frame reports the mode that it led to [s]."""


class RoombaControl:
    """Wakes the base up, keeps it in Safe mode while it should drive, and drives it.

    Attributes:
        state: Of the last sensor frame; None before the first.
        mode_offset: Offset of the mode that the firmware reports; None until it is known.
    """

    def __init__(self, name: str, config: RoombaConfig, now: float) -> None:
        """Request Safe mode for as long as a base may take to start, from `now` [s] on."""
        self.state: BaseState | None = None
        self.mode_offset = config.mode_offset
        self._name = name
        self._config = config
        self._stream = StreamParser(STREAMED)
        self._odd_values = OddValues(name)
        self._odometry = WheelOdometry(config.wheel_base, config.wheel_scale)
        self._commanded = CommandedSpeeds(config.echo_delay)
        self._wanted, self._wanted_at = STOP, now
        self._wheels = (0.0, 0.0)
        self._stepped_at = now
        self._must_stop = False
        self._warned_at = -math.inf
        self._distrusted_at: float | None = None
        self._pressed: frozenset[Button] = frozenset()
        self._extra_commands = b""
        self._sent_at, self._rolled_at, self._ordered_at = now, -math.inf, now
        self._opened_at, self._is_back, self._slept, self._stopped = -math.inf, False, False, False
        self._oi_mode = OiModeKeeper(name, config, now)
        self._caster_wheel = CasterWheel(name)

    def drive(self, twist: Twist, now: float) -> None:
        """Hold `twist`, same curvature if too fast, until the next call or the timeout."""
        config = self._config
        turning = min(1.0, config.max_turn_rate / max(abs(twist.angular), 1e-9))
        twist = Twist(twist.linear * turning, twist.angular * turning)
        self._wanted = within_wheel_limit(twist, config.wheel_base, config.max_wheel_speed)
        self._wanted_at = self._ordered_at = now

    def resume(self, now: float) -> None:
        """Stop the wheels and request Safe mode."""
        self._wanted, self._ordered_at = STOP, now
        self._oi_mode.resume(now)

    def seek_dock(self, now: float) -> None:
        """Let the base look for its dock, until `resume`."""
        self._wanted, self._ordered_at = STOP, now
        self._extra_commands += self._oi_mode.seek_dock(now)

    def show(self, feedback: Feedback) -> None:
        """Light its LEDs and play a song, if it is in Safe or Full mode."""
        self._extra_commands += COMPLETION + show_feedback(feedback)

    def reconnect(self, now: float, *, slept: bool = False) -> None:
        """Start again with a base whose port was lost; its encoders show how far it rolled on.

        It is listened to before it is woken, which would end its mode: a base that still obeys has
        not been lifted.

        `slept`: this machine was suspended meanwhile, for a time that `now` [s] lacks.
        """
        self._stream = StreamParser(STREAMED)
        self._commanded.clear()
        self._wanted, self._wheels = STOP, (0.0, 0.0)
        self._opened_at, self._is_back, self._slept = now, True, slept
        self._extra_commands = SURE_STOP
        if self._oi_mode.turns_by_itself:
            self._extra_commands, self._oi_mode.woken_at = REST_BY_FORCE, now

    def restore(
        self,
        state: BaseState | None,
        counts: tuple[int, int] | None,
        mode_offset: int | None,
        now: float,
        *,
        docks: bool,
    ) -> None:
        """Go on where another control ended, whose base was then left at rest in Passive mode.

        Its last `state`, the `counts` of the left and the right encoder at it and the `mode_offset`
        are None where they are not known; `docks`: the base looked for its dock, or had found it.
        """
        self.mode_offset = mode_offset
        if state is None:
            return
        self._odometry.restore(state.T_odom_base, counts)
        self._oi_mode.take_over(state, now, docks=docks)
        self._is_back = self._stopped = True
        self.state = replace(state, mode=BaseMode.PASSIVE)

    @property
    def docks(self) -> bool:
        """Whether the base is released to look for its dock, or has found it."""
        return self._oi_mode.docks

    @property
    def counts(self) -> tuple[int, int] | None:
        """Left and right encoder in the last sensor frame; None where they are not known."""
        return self._odometry.counts

    def step(self, received: bytes, now: float) -> bytes:
        """Bytes to send after `received` came in; often none."""
        frames = self._stream.feed(received)
        for values in frames:
            self._observe(values, now)
        requests, self._extra_commands = self._extra_commands + self._requests(now), b""
        wheels = self._next_wheels(now)
        repeats = frames or not received or now - self._sent_at > _REPEAT
        if not requests and not repeats and wheels == self._commanded.latest:
            return b""
        self._sent_at = now
        self._commanded.add(wheels, now)
        if wheels != (0, 0):
            self._rolled_at = now
        return requests + drive_command(*wheels)

    def _hears(self, now: float) -> bool:
        """Whether a sensor frame came lately."""
        state = self.state
        return state is not None and now - state.stamp <= self._config.silence_timeout + 1e-9

    def _observe(self, values: Mapping[Packet, int], now: float) -> None:
        """Update with a sensor frame; an impossible one is dropped."""
        if self.mode_offset is None:
            self.mode_offset = self._learned_offset(values[Packet.OI_MODE], now)
        mode = values[Packet.OI_MODE] - (self.mode_offset or 0)
        if self.mode_offset is None:
            return
        sound = self._odd_values.corrected({**values, Packet.OI_MODE: mode})
        if sound is None:
            return
        values = sound
        before, counts = self.state, (values[Packet.LEFT_ENCODER], values[Packet.RIGHT_ENCODER])
        elapsed = 0.0 if before is None else now - before.stamp
        if elapsed > self._config.silence_timeout and self._may_have_restarted(counts):
            self._odometry.skip()
        farthest = _FASTEST * (elapsed + _BURST)
        if not self._odometry.update(*counts, farthest):
            logger.warning("%s: rejected encoder counts that jumped to %s", self._name, counts)
        state = base_state(values, now, self._odometry.T_odom_base, BaseMode(mode))
        # A corrupt frame may pass its checksum: a button counts from its second frame on.
        pressed, self._pressed = self._pressed, state.buttons
        new = state.buttons - pressed
        self.state = replace(state, buttons=state.buttons - new) if new else state
        if before is not None and (self._is_back or elapsed > self._config.silence_timeout):
            silence = math.inf if self._slept else elapsed
            self._oi_mode.return_from_silence(before, silence, stopped_by_us=self._stopped)
            self._is_back = self._slept = self._stopped = False
        touched = before is not None and (before.blocked or any(before.cliffs))
        if (state.blocked or any(state.cliffs)) and not touched:
            self._wanted, self._must_stop = STOP, True  # until the program commands again
        if before is not None and before.mode.obeys and not state.mode.obeys:
            self._commanded.clear()
        self._oi_mode.update(before, self.state, now)
        if self._oi_mode.maybe_moved:
            self.state = replace(self.state, maybe_moved=True)
        right, left = self._commanded.latest or (0, 0)
        ahead = right == left > 0 and not any(self._odometry.at_rest)
        self._caster_wheel.observe(state, ahead=ahead)
        self._compare(values, self.state)

    def _may_have_restarted(self, counts: tuple[int, int]) -> bool:
        """Whether encoders that were not heard for a while may count from 0 again."""
        before = self._odometry.counts or (0, 0)
        fewer = any(abs(new) < abs(old) for new, old in zip(counts, before, strict=True))
        return fewer and max(map(abs, counts)) < _RESTARTED

    def _learned_offset(self, reported: int, now: float) -> int | None:
        """The offset, once known: Start leads to mode 1, Passive, which some firmware calls 2."""
        if reported == BaseMode.PASSIVE:
            return 0
        woken_at = self._oi_mode.woken_at
        woken = math.isfinite(woken_at) and now - woken_at > _AFTER_START
        if woken and reported == BaseMode.PASSIVE + 1:
            logger.warning("%s: this firmware reports its mode one too high", self._name)
            return 1
        return None

    def _compare(self, values: Mapping[Packet, int], state: BaseState) -> None:
        """Stop a base that reports speeds that were not commanded, until it reports a stop."""
        reported = values[Packet.REQUESTED_RIGHT_VELOCITY], values[Packet.REQUESTED_LEFT_VELOCITY]
        if self._distrusted_at is not None:
            waited = state.stamp - self._distrusted_at >= self._config.echo_delay
            if waited and reported == (0, 0):
                self._distrusted_at = None
        elif state.mode is self._oi_mode.goal and not self._commanded.explains(
            reported, 1000 * self._config.echo_tolerance
        ):
            logger.warning(
                "%s: the base took %s mm/s for its speeds, not %s: stopped; if that goes on, check"
                " its cable, or raise echo_tolerance in [roomba]",
                self._name, reported, self._commanded.latest,
            )  # fmt: skip
            self._distrusted_at = state.stamp

    def _requests(self, now: float) -> bytes:
        """Bytes to send besides speeds, to start the stream and to change the mode."""
        if not self._hears(now):
            return self._wake_up(now)
        asked = now - self._ordered_at < self._config.command_timeout - 1e-9
        rolls = not all(self._odometry.at_rest)
        request = self._oi_mode.request(now, asked=asked, rolls=rolls)
        if request:
            self._wanted = STOP
        return request

    def _wake_up(self, now: float) -> bytes:
        """Bytes to send to a base that is silent."""
        state, oi_mode = self.state, self._oi_mode
        heard_at = -math.inf if state is None else state.stamp
        silent_since = max(heard_at, self._opened_at)
        rolled = self._rolled_at >= silent_since or not all(self._odometry.at_rest)
        obeyed = state is not None and state.mode.obeys
        early = now - silent_since <= RETRY_PERIOD
        runs_away = obeyed and rolled and now - heard_at <= RETRY_PERIOD
        # A corrupt byte may have ended all (Stop, 173): it rolls on until it is in Safe mode. On
        # its way to the dock no other mode stops it. Else a former command may still have to stop
        # the wheels: Start would end Safe mode.
        at_once = runs_away or (oi_mode.turns_by_itself and early)
        since = oi_mode.woken_at if at_once else max(oi_mode.woken_at, silent_since)
        if now - since < (AT_ONCE if at_once else RETRY_PERIOD) - 1e-9:
            return b""
        oi_mode.woken_at, self._wanted = now, STOP
        if oi_mode.turns_by_itself:
            return REST_BY_FORCE + _STREAM
        return SURE_STOP + WAKE_UP + (oi_mode.request_unheard(now) if runs_away else b"")

    def _next_wheels(self, now: float) -> tuple[int, int]:
        """Right and left wheel speed to command now [mm/s]."""
        state, config, period = self.state, self._config, now - self._stepped_at
        self._stepped_at = now
        # A stop is never ramped, whoever asks for it: program, person or reflex.
        at_once = self._wanted == STOP or self._must_stop or self._distrusted_at is not None
        at_once = at_once or not self._hears(now) or self._oi_mode.holds
        self._must_stop = False
        if self._wanted != STOP and now - self._wanted_at > config.command_timeout - 1e-9:
            level = logging.WARNING if now - self._warned_at > _WARN_AGAIN else logging.DEBUG
            logger.log(
                level,
                "%s: no command for %s s: stopped; the program hangs, or this machine is too slow",
                self._name, config.command_timeout,
            )  # fmt: skip
            self._wanted, at_once, self._warned_at = STOP, True, now
        twist = STOP if state is None or at_once else allowed(self._wanted, state)
        left, right = wheel_speeds(twist, config.wheel_base)
        right_now, left_now = self._wheels
        rolling = Twist((right_now + left_now) / 2, (right_now - left_now) / config.wheel_base)
        for motion in (self._wanted, rolling):
            stopped = state is None or (motion != STOP and allowed(motion, state) == STOP)
            at_once = at_once or stopped
        self._wheels = (right, left) if at_once else self._ramped((right, left), period)
        right_mm_s, left_mm_s = within_limits(*self._wheels, config)
        last, rest = self._commanded.latest or (0, 0), self._odometry.at_rest
        return (
            without_reversal(right_mm_s, last[0], rest[1]),
            without_reversal(left_mm_s, last[1], rest[0]),
        )

    def _ramped(self, wanted: tuple[float, float], period: float) -> tuple[float, float]:
        """Speeds on the ramp from the present ones to the wanted ones after `period` [s]."""
        config, share = self._config, 1.0
        for now, then in zip(self._wheels, wanted, strict=True):
            rate = config.acceleration if abs(then) > abs(now) else config.deceleration
            share = min(share, rate * period / max(abs(then - now), 1e-9))
        right, left = (
            now + share * (then - now) for now, then in zip(self._wheels, wanted, strict=True)
        )
        return right, left
