"""Keeps the base in the Open Interface mode in which it obeys (manual, pages 7 to 8).

The base acknowledges no request, and the line may lose one: it is repeated until the mode changes.

After a silence in which the base left that mode, somebody may have lifted it and put it down
elsewhere. It then rests until a person says to go on, unless nothing but the driver's own commands
can have ended the mode.
"""

from __future__ import annotations

import logging
import math
from collections import deque
from dataclasses import dataclass

from drivers.roomba.commands import Opcode, encode, songs
from drivers.roomba.config import RoombaConfig
from drivers.roomba.drive_command import COMPLETION, STOP_WHEELS, SURE_STOP
from drivers.roomba.state import why_passive
from vizbot.core.types import BaseMode, BaseState

logger = logging.getLogger(__name__)

RETRY_PERIOD = 0.5
"""Time between two requests for a mode [s]; other drivers wait as long."""
_REQUESTS = 4
"""Requests for Safe mode before giving up."""
AT_ONCE = 0.03
"""The same time while the wheels may turn uncommanded [s]: the request itself may be lost."""
_RECLAIMS, _WITHIN = 3, 5.0
"""Most times that a mode lost for no known reason is requested at once, and in what time [s]."""
_LATE = 0.05
"""Largest delay between a change of mode and the report of the contact that caused it [s]."""
_EXPLAINS = 0.5
"""Largest age of a contact that may explain a change of mode [s]."""
_TOO_SHORT = 1.0
"""A silence shorter than this leaves nobody the time to carry the base elsewhere [s]."""
_FIRST_FRAMES = 4
"""Frames after a silence that show what the base feels before it may drive; one may be corrupt."""
_OLD = 0.3
"""Largest age of a frame that was read late [s]: they wait while a process does not run."""
_COASTS = 0.3
"""Longest time that wheels turn on after the base has left the mode by itself [s]."""
REST_BY_FORCE = COMPLETION + encode(Opcode.SAFE) + SURE_STOP + encode(Opcode.START)
"""Stops wheels that the base turns by itself, as on its way to the dock: only Safe mode does. It
is in Passive mode then."""


@dataclass(slots=True)
class _Return:
    """A base that is heard again.

    Attributes:
        last_heard: Time of the last frame before the silence [s].
        brief: Whether the silence left nobody time to carry it.
        charged: Whether it was on a charger before.
        stopped_by_us: Whether it was left in Passive mode by a command of ours.
        frames: Number of frames since.
        hindered: Whether one of these frames shows a new cliff, wheel drop or charger.
    """

    last_heard: float
    brief: bool
    charged: bool
    stopped_by_us: bool
    frames: int = 0
    hindered: bool = False


class OiModeKeeper:
    """Requests Safe (or Full) mode while the base should drive.

    Attributes:
        goal: The mode in which the base should drive.
        woken_at: Time of the last Start command [s], which puts the base in Passive mode.
        maybe_moved: Whether the base left the mode unheard and rests until `resume`.
    """

    def __init__(self, name: str, config: RoombaConfig, now: float) -> None:
        """Request the mode for as long as a base may take to start, from `now` [s] on."""
        self.goal = BaseMode.FULL if config.full_mode else BaseMode.SAFE
        self.woken_at = -math.inf
        self.maybe_moved = False
        self._name = name
        self._config = config
        self._docks = self._obeys = self._charges = False
        self._should_obey, self._rests_by_force = True, False
        self._returned: _Return | None = None
        self._obeyed_at, self._forced_at = -math.inf, -math.inf
        self._taken_back_at = -math.inf
        self._requested_unheard = self._releases = False
        self._contact_at = -math.inf
        self._requested_at = -math.inf
        self._request_until, self._at_once = now + config.start_timeout, False
        self._reclaimed: deque[float] = deque(maxlen=_RECLAIMS)
        if config.full_mode:
            logger.warning("%s: Full mode: the base does not stop at cliffs by itself", name)

    def resume(self, now: float) -> None:
        """Request the mode from now on, even of a base that looks for its dock or may be moved."""
        self._docks = self.maybe_moved = self._rests_by_force = False
        self._returned = None
        self._ask(now)

    def _ask(self, now: float) -> None:
        self._should_obey = True
        self._requested_at, self._at_once = -math.inf, False
        self._request_until = now + _REQUESTS * RETRY_PERIOD

    def seek_dock(self, now: float) -> bytes:
        """Release the base to look for its dock until `resume`; return the bytes to send."""
        self._docks, self._should_obey, self.maybe_moved = True, False, False
        self._requested_at, self._request_until = now, -math.inf
        return STOP_WHEELS + COMPLETION + encode(Opcode.SEEK_DOCK)

    @property
    def holds(self) -> bool:
        """Whether the base must rest because of what may have happened to it unheard."""
        return self.maybe_moved or self._returned is not None

    @property
    def docks(self) -> bool:
        """Whether the base is released to look for its dock, or has found it."""
        return self._docks

    @property
    def turns_by_itself(self) -> bool:
        """Whether the base may turn its wheels by itself, where no wheel command stops them."""
        return self._docks and not self._charges

    def return_from_silence(
        self, before: BaseState, silence: float, *, stopped_by_us: bool = False
    ) -> None:
        """Note that the base is heard again, before `update` takes its first frame.

        `silence` is its length [s], infinite where it is not known; `stopped_by_us`: a command of
        ours must have left it in Passive mode, besides a Start of which this keeper knows.
        """
        if self._should_obey or self._docks:
            self._returned = _Return(
                before.stamp, silence < _TOO_SHORT, before.on_charger, stopped_by_us
            )
            self._request_until = -math.inf

    def take_over(self, last: BaseState, now: float, *, docks: bool) -> None:
        """Go on from the last state of another keeper, which heard the base until then.

        With `docks` that keeper had released the base to look for its dock.
        """
        self._docks = docks
        self._request_until, self._requested_at = -math.inf, now - RETRY_PERIOD
        self._should_obey, self.maybe_moved = last.mode.obeys, last.maybe_moved

    def update(self, before: BaseState | None, state: BaseState, now: float) -> None:
        """Update with a state of the base, and request the mode again if it should drive."""
        self._obeys, self._charges = state.mode.obeys, state.on_charger
        if self._obeys:
            self._obeyed_at = now
        hindered = any(state.cliffs) or any(state.wheel_drops) or state.plugged_in
        if hindered or state.on_charger:
            self._contact_at = now
        in_time = not self._at_once or now - self._reclaimed[-1] <= _LATE
        if hindered and in_time and math.isfinite(self._requested_at):
            # It stopped for a reason; with a request it would drive off as soon as it is put down.
            self._request_until, self._should_obey = -math.inf, False
        self._releases = self._requested_unheard and hindered and state.mode.obeys
        self._requested_unheard = self._releases
        if self._returned is not None:
            self._judge_return(self._returned, state, now)
        if self.holds:
            return
        if state.mode is self.goal:
            if self._requested_at >= self.woken_at:  # else the frame is older than the wake-up
                self._request_until, self._should_obey = -math.inf, True
            return
        since_request = now - self._requested_at
        if state.mode.obeys:
            if since_request > RETRY_PERIOD:
                logger.warning("%s: the base is in %s mode unasked", self._name, state.mode.name)
                self.resume(now)
            return
        if self._docks:
            return
        if before is not None and before.mode.obeys:
            mode, reason = before.mode.name.title(), why_passive(state)
            logger.warning("%s: the base left %s mode (%s)", self._name, mode, reason)
            often = len(self._reclaimed) == _RECLAIMS and now - self._reclaimed[0] <= _WITHIN
            if (
                now - self._contact_at > _EXPLAINS
                and self._requested_at >= self.woken_at
                and not often
            ):
                # In Safe mode no button does that: a byte was corrupted, and its wheels may turn.
                logger.warning("%s: nothing it feels explains that: asking again", self._name)
                self._ask(now)
                self._request_until, self._at_once = now + RETRY_PERIOD, True
                self._reclaimed.append(now)
                return
            self._should_obey = False
        may_resume = (
            self._config.resume_safe and not any(state.wheel_drops) and not state.on_charger
        )
        if may_resume and since_request > RETRY_PERIOD:
            logger.warning("%s: asking it to obey again, as resume_safe says", self._name)
            self._ask(now)

    def _judge_return(self, back: _Return, state: BaseState, now: float) -> None:
        """Decide by the first frames after a silence whether the base may be driven on unasked."""
        charger = state.on_charger and not back.charged
        back.hindered |= any(state.cliffs) or any(state.wheel_drops) or charger
        woken = self.woken_at > back.last_heard
        if self._docks and state.on_charger:
            self._returned = None
            return
        if state.mode.obeys and not self._docks and (back.brief or self.goal is not BaseMode.FULL):
            # Right after a Start of ours frames from before it may still come.
            late = woken and self.woken_at > self._requested_at and now - self.woken_at < _OLD
            self._returned = self._returned if late else None
            return
        back.frames += 1
        if back.frames < _FIRST_FRAMES:
            return
        self._returned = None
        by_us = (woken or back.stopped_by_us) and back.brief and not back.hindered
        if by_us and self._docks:
            self._requested_at, self._obeys = -math.inf, True  # it is sent on its way once more
        elif by_us:
            self._request_until, self._at_once = now + self._config.start_timeout, False
        elif not self._config.resume_safe:
            self._docks, self._should_obey, self.maybe_moved = False, False, True
            self._rests_by_force = not state.on_charger
            logger.warning(
                "%s: the base left %s mode while nobody heard it: somebody may have moved it;"
                " it rests until somebody says to go on",
                self._name, self.goal.name.title(),
            )  # fmt: skip

    def request(self, now: float, *, asked: bool, rolls: bool) -> bytes:
        """Bytes to send to a base that is heard; they stop the wheels, too.

        `asked`: the program has given an order lately; `rolls`: the wheels turn.
        """
        if self._releases:
            return STOP_WHEELS + COMPLETION + encode(Opcode.START)
        if self._returned is not None:
            return b""
        if self._docks and not self._charges and not asked:
            return b"" if self._obeys else self._stop_docking(now)
        if self._docks and self._obeys and now - self._requested_at > RETRY_PERIOD:
            return self.seek_dock(now)
        if self._turns_unasked(now, rolls):
            self._rests_by_force, self._forced_at, self.woken_at = False, now, now
            return REST_BY_FORCE
        if now >= self._request_until:
            return b""
        return self._repeated(AT_ONCE if self._at_once else RETRY_PERIOD, now)

    def _stop_docking(self, now: float) -> bytes:
        """Take the base, on its way to the dock, back from a program that has ceased to order."""
        if now - self._taken_back_at > _TOO_SHORT:
            timeout = self._config.command_timeout
            logger.warning("%s: no command for %s s on its way: stopped", self._name, timeout)
        self._taken_back_at = now
        return self._repeated(AT_ONCE, now)

    def _repeated(self, every: float, now: float) -> bytes:
        """The request for the mode, at most once in `every` [s]."""
        if now - self._requested_at < every - 1e-9:
            return b""
        # Songs come before the request: a song that lost a byte swallows what follows.
        stored = b"" if every < RETRY_PERIOD else songs()
        return STOP_WHEELS + stored + self._mode_request(now)

    def _turns_unasked(self, now: float, rolls: bool) -> bool:
        """Whether the base may turn its wheels although nobody has asked it to.

        In Passive mode its buttons start its own programs, as Clean does, while nobody listens.
        """
        if self._docks or self._charges or now < self._request_until:
            return False
        turns = self.maybe_moved if self._obeys else rolls and now - self._obeyed_at > _COASTS
        return self._rests_by_force or (turns and now - self._forced_at > RETRY_PERIOD)

    def request_unheard(self, now: float) -> bytes:
        """Bytes that put a base that is not heard into the mode, at rest.

        If its next report shows a reason against the mode, it is released again.
        """
        self._requested_unheard = True
        return self._mode_request(now)

    def _mode_request(self, now: float) -> bytes:
        self._requested_at = now
        opcode = Opcode.FULL if self.goal is BaseMode.FULL else Opcode.SAFE
        return COMPLETION + encode(opcode) + STOP_WHEELS
