"""What patches of a picture of a home truly show, as atoms: the truth that captions are told by."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim_stubs.atoms import Atoms
from sim_stubs.house_facts import HouseFacts
from vizbot.core.types import SE3, Intrinsics

__all__ = ["Atoms", "seen"]


def seen(
    facts: HouseFacts,
    segmentation: NDArray[np.int32],
    depth: NDArray[np.float32],
    T_world_cam: SE3,
    intrinsics: Intrinsics,
    boxes: NDArray[np.int32],
) -> Atoms:
    """How clearly each patch shows each atom.

    Args:
        facts: Of the house, by `HouseFacts.of(house)`: once for all of its pictures.
        segmentation: (H, W), index in `House.instances`, -1 for structure.
        depth: (H, W) true depth [m], 0 where nothing is.
        T_world_cam: Where the picture was taken.
        intrinsics: Of the picture.
        boxes: (P, 4) u0, v0, u1, v1 of the patches [px], the end not included.
    """
    raise NotImplementedError
