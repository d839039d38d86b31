"""All who watch a run; one that fails to write is told no more, and the run goes on."""

from __future__ import annotations

import errno
import logging
from collections.abc import Callable, Sequence

from vizbot.core.errors import VizbotError
from vizbot.core.observer import GoalReport, Observer, Step

log = logging.getLogger(__name__)

_REMEDIES = {errno.ENOSPC: "; free some space", errno.EDQUOT: "; free some space"}


class Observers:
    """An observer that tells others: a full disk costs the video, not the search."""

    def __init__(self, observers: Sequence[Observer]) -> None:
        """They are told in this order."""
        self._observers = tuple(observers)

    def on_step(self, step: Step) -> None:
        """One more frame has been worked on."""
        self._tell(lambda observer: observer.on_step(step))

    def on_goal(self, report: GoalReport) -> None:
        """The search for one goal has ended."""
        self._tell(lambda observer: observer.on_goal(report))

    def _tell(self, news: Callable[[Observer], None]) -> None:
        for observer in self._observers:
            try:
                news(observer)
            except OSError as error:
                if isinstance(error, VizbotError):
                    raise  # a device that is silent is one, too
                name, remedy = type(observer).__name__, _REMEDIES.get(error.errno or 0, "")
                log.warning("%s ends here: %s%s", name, error.strerror or error, remedy)
                self._observers = tuple(other for other in self._observers if other is not observer)
