"""What the search may do next."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, eq=False)
class Option:
    """Something that may end the search.

    Attributes:
        kind: "place" or "frontier".
        xy: (2,) in `map` [m].
        probability: That it does.
        way: What it takes, in metres of free floor.
        spot_xy: (2,) from where a place is looked at that was looked at before; else None.
        seen_from: (2,) where the camera stood when it saw a place best; None where the robot may
            come from any side.
        area: What is unseen behind a frontier, as far as it counts [m^2].
        likeness: To the goal, of what was seen beside a frontier [standard deviations].
    """

    kind: str
    xy: NDArray[np.float64]
    probability: float
    way: float
    spot_xy: NDArray[np.float64] | None = None
    seen_from: NDArray[np.float64] | None = None
    area: float = 0.0
    likeness: float = 0.0
