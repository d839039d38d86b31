"""The fitted numbers of the belief, as they are kept in `weights.json`.

`python -m benchmarks.fast_world.fit` makes the file: 60 numbers, and the homes they are from.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

FILE = Path(__file__).with_name("weights.json")


@dataclass(frozen=True, slots=True, eq=False)
class Weights:
    """The fitted numbers.

    Attributes:
        near: (20,) of the features of a view from near (`mapping.clip.evidence`).
        far: (20,) of those of a view from afar.
        join: (20,) of the features of all views of a place (`mapping.clip.place_views`).
    """

    near: NDArray[np.float64]
    far: NDArray[np.float64]
    join: NDArray[np.float64]


@cache
def fitted_weights(file: Path = FILE) -> Weights:
    """The numbers of a file."""
    kept = json.loads(file.read_text(encoding="utf-8"))
    return Weights(*(np.array(kept[name]) for name in ("near", "far", "join")))
