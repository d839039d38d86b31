"""What a tick of the robot is done for."""

from __future__ import annotations

from typing import TypeAlias

from vizbot.behaviours.short_move import ShortMove
from vizbot.objectnav.tasks import Goal, Task, Waypoint

Errand: TypeAlias = Goal | Waypoint | Task | ShortMove
"""A goal in words, a place, one of the tasks without words, or a short move."""
