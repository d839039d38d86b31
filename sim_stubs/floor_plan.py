"""Floor plans of homes, drawn from a seed: rooms, doorways, windows, stairs."""

from __future__ import annotations

from dataclasses import dataclass

from sim_stubs.stairs import Stairs
from sim_stubs.walls import Opening, RectangularRoom


@dataclass(frozen=True, slots=True)
class FloorPlan:
    """A home without furniture.

    Attributes:
        rooms: At least one of each necessary kind; a hallway may consist of several.
        openings: Doorways between rooms, windows and the closed outer door in outer walls.
        stairs: In the hallway or the living room; None where there are none.
        height: Of the ceiling [m].
    """

    rooms: tuple[RectangularRoom, ...]
    openings: tuple[Opening, ...]
    stairs: Stairs | None
    height: float
