"""Keeps the base in the Open Interface mode in which it obeys (manual, pages 7 to 8).

The base acknowledges no request, and the line may lose one: it is repeated until the mode changes.
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


class OiModeKeeper:
    """Requests Safe (or Full) mode while the base should drive.

    Attributes:
        goal: The mode in which the base should drive.
        woken_at: Time of the last Start command [s], which puts the base in Passive mode.
    """

    def __init__(self, name: str, config: RoombaConfig, now: float) -> None:
        """Request the mode for as long as a base may take to start.

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
        self._requested_unheard = self._releases = False
        self._contact_at = -math.inf
        self._requested_at = -math.inf
        self._request_until, self._at_once = now + config.start_timeout, False
        self._reclaimed: deque[float] = deque(maxlen=_RECLAIMS)
        if config.full_mode:
            logger.warning("%s: Full mode: the base does not stop at cliffs by itself", name)

    def resume(self, now: float) -> None:
        """Request the mode from now on, even of a base that looks for its dock."""
        self._docks = False
        self._requested_at, self._at_once = -math.inf, False
        self._request_until = now + _REQUESTS * RETRY_PERIOD

    def seek_dock(self, now: float) -> bytes:
        """Release the base to look for its dock until `resume`; return the bytes to send."""
        self._docks, self._requested_at, self._request_until = True, now, -math.inf
        return STOP_WHEELS + COMPLETION + encode(Opcode.SEEK_DOCK)

    def expect_return(self, last: BaseState | None, now: float) -> None:
        """Request the mode again of a base that fell silent in it: that was no safety event."""
        if last is not None and last.mode.obeys and not self._docks:
            self._request_until, self._at_once = now + self._config.start_timeout, False

    def take_over(self, last: BaseState, now: float) -> None:
        """Request the mode if the base was in it when it was left in Passive mode after `last`."""
        self._request_until, self._requested_at = -math.inf, now - RETRY_PERIOD
        self.expect_return(last, now)

    def update(self, before: BaseState | None, state: BaseState, now: float) -> None:
        """Update with a state of the base, and request the mode again if it should drive."""
        self._obeys = state.mode.obeys
        hindered = any(state.cliffs) or any(state.wheel_drops) or state.plugged_in
        if hindered or state.on_charger:
            self._contact_at = now
        in_time = not self._at_once or now - self._reclaimed[-1] <= _LATE
        if hindered and in_time and math.isfinite(self._requested_at):
            # It stopped for a reason; with a request it would drive off as soon as it is put down.
            self._request_until = -math.inf
        self._releases = self._requested_unheard and hindered and state.mode.obeys
        self._requested_unheard = self._releases
        if state.mode is self.goal:
            if self._requested_at >= self.woken_at:  # else it is a frame from before it was woken
                self._request_until = -math.inf
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
                self.resume(now)
                self._request_until, self._at_once = now + RETRY_PERIOD, True
                self._reclaimed.append(now)
                return
        may_resume = (
            self._config.resume_safe and not any(state.wheel_drops) and not state.on_charger
        )
        if may_resume and since_request > RETRY_PERIOD:
            logger.warning("%s: asking it to obey again, as resume_safe says", self._name)
            self.resume(now)

    def request(self, now: float) -> bytes:
        """Bytes to send to a base that is heard; they stop the wheels, too."""
        if self._releases:
            return STOP_WHEELS + COMPLETION + encode(Opcode.START)
        if self._docks and self._obeys and now - self._requested_at > RETRY_PERIOD:
            return self.seek_dock(now)
        every = AT_ONCE if self._at_once else RETRY_PERIOD
        if now >= self._request_until or now - self._requested_at < every - 1e-9:
            return b""
        # Songs come before the request: a song that lost a byte swallows what follows.
        stored = b"" if self._at_once else songs()
        return STOP_WHEELS + stored + self._mode_request(now)

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
