"""A world before it is opened: what neither the simulator nor OpenGL is needed for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

from sim_stubs.homes.geometry.house import House
from sim_stubs.world.body import Outline
from sim_stubs.world.contact_map import ContactMap
from vizbot.core.types import Intrinsics

if TYPE_CHECKING:  # its module loads numba, for which the drawing of a home is not to wait
    from sim_stubs.world.visibility import Visibility

D435I_COLOUR = Intrinsics(640, 480, 617.0, 617.0, 319.5, 239.5)
"""A D435i's colour camera at 640x480, without distortion."""


@dataclass(frozen=True, slots=True, eq=False)
class WorldPlan:
    """A house that a robot is to be put into.

    Attributes:
        house: The house, with the start.
        seed: Seed of all noise.
        notice: Lines about the world for the user; may be empty.
        start_is_asked: Whether the start is where a user wants the robot.
    """

    house: House
    seed: int
    notice: str
    start_is_asked: bool


@dataclass(frozen=True, slots=True, eq=False)
class HouseShape:
    """What the shape of a house does to a robot in it.

    Attributes:
        touch: Where the robot touches something.
        visibility: What the walls hide from its camera.
    """

    touch: ContactMap
    visibility: Visibility

    @classmethod
    def for_robot(
        cls, house: House, outline: Outline, intrinsics: Intrinsics = D435I_COLOUR
    ) -> Self:
        """Work it out for a robot with this outline and camera."""
        from sim_stubs.world.visibility import Visibility

        return cls(ContactMap(house, outline), Visibility.in_house(house, intrinsics))
