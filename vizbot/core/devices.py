"""The open devices of a run."""

from __future__ import annotations

from dataclasses import dataclass

from vizbot.core.interfaces import Base, Camera, Clock
from vizbot.core.types import SE3


@dataclass(frozen=True, slots=True)
class Devices:
    """What a run is made of, real or simulated.

    Attributes:
        clock: Of the whole run.
        camera: A camera or a recording of one.
        base: None when nothing is to be driven.
        T_base_cam: Where the camera sits on the base; None for a recording that does not say.
        recorded: Whether the camera is a recording, which ends by itself.
    """

    clock: Clock
    camera: Camera
    base: Base | None
    T_base_cam: SE3 | None
    recorded: bool
