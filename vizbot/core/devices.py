"""The open devices of a run."""

from __future__ import annotations

from dataclasses import dataclass

from vizbot.core.interfaces import Base, Camera, Clock
from vizbot.core.types import SE3


@dataclass(frozen=True, slots=True)
class Devices:
    """Camera, base and clock of a run, real or simulated.

    Attributes:
        clock: The clock of the whole run.
        camera: A camera or a recording of one.
        base: The base to drive; None without one.
        T_base_cam: Where the camera sits on the base; None where that is not known.
        recorded: Whether the camera is a recording, which ends by itself.
    """

    clock: Clock
    camera: Camera
    base: Base | None
    T_base_cam: SE3 | None
    recorded: bool
