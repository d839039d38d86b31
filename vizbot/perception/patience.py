"""A base that falls silent for a while is waited for; nothing is asked of it meanwhile."""

from __future__ import annotations

import logging
from dataclasses import replace

from vizbot.core.errors import DeviceTimeoutError
from vizbot.core.interfaces import Base
from vizbot.core.types import BaseState

log = logging.getLogger(__name__)

_WAKING = 1.0
"""A base that speaks again obeys again within so long [s]."""


class Patience:
    """Reads a base that may be silent, and gives up on one that stays so."""

    def __init__(self, limit: float) -> None:
        """Wait for up to `limit` [s] at a time."""
        self._limit = limit
        self._silent_since: float | None = None
        self._back_since: float | None = None

    def read(self, base: Base, now: float) -> BaseState | None:
        """What the base feels at `now` [s]; None while it is silent or, untouched, wakes up.

        Buttons that are pressed while it wakes up are left out: they may be what woke it.

        Raises:
            DeviceTimeoutError: it has been for too long.
            DeviceError: it is gone or closed.
        """
        try:
            state = base.read()
        except DeviceTimeoutError as error:
            if self._silent_since is None:
                log.warning("%s; waiting for it", error)
                self._silent_since = now
            self._back_since = None
            if now - self._silent_since >= self._limit:
                raise
            return None
        if self._silent_since is None:
            return state
        if self._back_since is None:
            self._back_since = now
        if (not state.mode.obeys or state.buttons) and now - self._back_since < _WAKING:
            touched = state.blocked or any(state.cliffs) or any(state.wheel_drops)
            return replace(state, buttons=frozenset()) if touched else None
        log.warning("the base answers again after %.1f s", now - self._silent_since)
        self._silent_since = self._back_since = None
        return state
