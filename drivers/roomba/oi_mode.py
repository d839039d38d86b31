"""Whether the base obeys, and what it is told when it should and does not (manual, pages 7 to 8).

Nothing acknowledges a request, and the line may lose it: what the mode does not follow is repeated.
"""

from __future__ import annotations

import logging
import math
from collections import deque

from drivers.roomba.commands import Opcode, encode
from drivers.roomba.config import RoombaConfig
from drivers.roomba.drive_command import COMPLETION, STOP_WHEELS
from drivers.roomba.feedback import songs
from drivers.roomba.state import why_passive
from vizbot.core.types import BaseMode, BaseState

logger = logging.getLogger(__name__)

RETRY_PERIOD = 0.5
"""Time that the base gets to act on what it was asked for [s]; other drivers wait as long."""
_REQUESTS = 4
"""Who is to obey again is asked up to so many times."""
AT_ONCE = 0.03
"""Where its wheels may turn unasked it gets no longer [s]: the request may be what was lost."""
_TAKEN_BACK, _WITHIN = 3, 5.0
"""Obedience that is lost for no known reason is taken back so many times within so long [s]."""
_LATE = 0.05
"""What the base feels may be told so long after it has ceased to obey for it [s]."""
_EXPLAINS = 0.5
"""A contact so long ago may be why the base does not obey any more [s]."""


class OiModeKeeper:
    """Asks for Safe (or Full) mode while that is agreed on.

    Attributes:
        goal: The mode in which the base obeys.
        woken_at: When it was told to speak last [s]; that ends its obedience.
    """

    def __init__(self, name: str, config: RoombaConfig, now: float) -> None:
        """Ask for as long as a base may take to start.

        Args:
            name: Of the port, for messages.
            config: Limits.
            now: Time [s].
        """
        self.goal = BaseMode.FULL if config.full_mode else BaseMode.SAFE
        self.woken_at = -math.inf
        self._name = name
        self._config = config
        self._docks = self._obeys = False
        self._asked_unheard = self._resigns = False
        self._contact_at = -math.inf
        self._asked_at = -math.inf
        self._ask_until, self._at_once = now + config.start_timeout, False
        self._taken_back: deque[float] = deque(maxlen=_TAKEN_BACK)
        if config.full_mode:
            logger.warning("%s: Full mode: the base does not stop at cliffs by itself", name)

    def resume(self, now: float) -> None:
        """Ask for it from now on, even of a base that looks for its dock."""
        self._docks = False
        self._asked_at, self._at_once = -math.inf, False
        self._ask_until = now + _REQUESTS * RETRY_PERIOD

    def seek_dock(self, now: float) -> bytes:
        """Let it go until `resume`: what to send."""
        self._docks, self._asked_at, self._ask_until = True, now, -math.inf
        return STOP_WHEELS + COMPLETION + encode(Opcode.SEEK_DOCK)

    def expect(self, last: BaseState | None, now: float) -> None:
        """A base that obeyed until it fell silent may do so again: that was no safety event."""
        if last is not None and last.mode.obeys and not self._docks:
            self._ask_until, self._at_once = now + self._config.start_timeout, False

    def follow(self, before: BaseState | None, state: BaseState, now: float) -> None:
        """Note that the base has begun or ceased to obey, and ask again if that was agreed on."""
        self._obeys = state.mode.obeys
        hindered = any(state.cliffs) or any(state.wheel_drops) or state.plugged_in
        if hindered or state.on_charger:
            self._contact_at = now
        in_time = not self._at_once or now - self._taken_back[-1] <= _LATE
        if hindered and in_time and math.isfinite(self._asked_at):
            # It stopped for a reason; asked again, it would drive off as soon as it is put down.
            self._ask_until = -math.inf
        self._resigns = self._asked_unheard and hindered and state.mode.obeys
        self._asked_unheard = self._resigns
        if state.mode is self.goal:
            if self._asked_at >= self.woken_at:  # else it is a frame from before it was woken
                self._ask_until = -math.inf
            return
        since_asked = now - self._asked_at
        if state.mode.obeys:
            if since_asked > RETRY_PERIOD:
                logger.warning("%s: the base is in %s mode unasked", self._name, state.mode.name)
                self.resume(now)
            return
        if self._docks:
            return
        if before is not None and before.mode.obeys:
            mode, reason = before.mode.name.title(), why_passive(state)
            logger.warning("%s: the base left %s mode (%s)", self._name, mode, reason)
            often = len(self._taken_back) == _TAKEN_BACK and now - self._taken_back[0] <= _WITHIN
            if now - self._contact_at > _EXPLAINS and self._asked_at >= self.woken_at and not often:
                # In Safe mode no button does that: a byte was spoilt, and its wheels may turn.
                logger.warning("%s: nothing it feels explains that: asking again", self._name)
                self.resume(now)
                self._ask_until, self._at_once = now + RETRY_PERIOD, True
                self._taken_back.append(now)
                return
        may_resume = (
            self._config.resume_safe and not any(state.wheel_drops) and not state.on_charger
        )
        if may_resume and since_asked > RETRY_PERIOD:
            logger.warning("%s: asking it to obey again, as resume_safe says", self._name)
            self.resume(now)

    def request(self, now: float) -> bytes:
        """What to send to a base that can be heard; with it the wheels stop."""
        if self._resigns:
            return STOP_WHEELS + COMPLETION + encode(Opcode.START)
        if self._docks and self._obeys and now - self._asked_at > RETRY_PERIOD:
            return self.seek_dock(now)
        every = AT_ONCE if self._at_once else RETRY_PERIOD
        if now >= self._ask_until or now - self._asked_at < every - 1e-9:
            return b""
        # The songs come before it: one that lost a byte swallows what is behind it.
        taught = b"" if self._at_once else songs()
        return STOP_WHEELS + taught + self._demand(now)

    def request_unheard(self, now: float) -> bytes:
        """Have a base that cannot be heard obey and rest; one with a reason not to is let go again.

        What it says next tells whether it has one.
        """
        self._asked_unheard = True
        return self._demand(now)

    def _demand(self, now: float) -> bytes:
        self._asked_at = now
        opcode = Opcode.FULL if self.goal is BaseMode.FULL else Opcode.SAFE
        return COMPLETION + encode(opcode) + STOP_WHEELS
