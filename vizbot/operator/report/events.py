"""What is worth a line in the log of a run."""

from __future__ import annotations

import re
from dataclasses import dataclass

from vizbot.core.observer import Step
from vizbot.core.types import Tracking


@dataclass(frozen=True, slots=True)
class Event:
    """One line.

    Attributes:
        text: In plain words.
        warns: Whether something is not as it should be.
    """

    text: str
    warns: bool = False


_NUMBERS = re.compile(r"\d+")


class Events:
    """Notices what changes from step to step: map, goal, activity and why, tracking.

    A reason whose numbers alone have changed is the same one.
    """

    def __init__(self) -> None:
        self._map_number: int | None = None
        self._goal, self._doing = "", ("", "")
        self._lost = False

    def changes(self, step: Step) -> list[Event]:
        """The events of a step; call once for each."""
        events = []
        if self._map_number not in (None, step.map_number):
            events.append(Event("another map begins"))
        if step.goal and step.goal != self._goal:
            events.append(Event(f"goal: {step.goal}"))
        lost = step.estimate.tracking is Tracking.LOST
        if lost and not self._lost:
            events.append(Event("it has lost its place", warns=True))
        elif self._lost and not lost:
            events.append(Event("it knows its place again"))
        doing = step.activity, _NUMBERS.sub("", step.short_why)
        if doing != self._doing:
            events.append(Event(f"{step.activity}: {step.why}" if step.why else step.activity))
        self._map_number = step.map_number
        self._goal, self._doing, self._lost = step.goal, doing, lost
        return events
