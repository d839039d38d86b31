"""Segments of a saved map: what a running robot adds to it, one file beside the other.

A segment has the arrays of `map.safetensors`: of tables that only grow the rows that came since the
segment before, of all others the present content, which counts instead of that before. `map.json`
names the segments; a file that it does not name is left of a save that was not finished.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from vizbot.core.settings import Settings

GROWING = ("views", "elements", "places", "frames", "cloud", "trajectory")
"""Groups of arrays whose rows are only added to while a robot runs."""
_ANEW = ("elements.pictures",)
"""Arrays of those groups that are the same in all of them, and stay as they were at first."""
MOST_SEGMENTS = 30
"""A map with as many segments is written anew as one."""
_NAME = re.compile(r"map-[1-9]\d{0,3}\.safetensors")


class Segment(Settings):
    """What `map.json` says of a segment.

    Attributes:
        size: Of its file [bytes].
        sha256: Of its content.
    """

    size: int = Field(ge=0)
    sha256: str


def segment_name(number: int) -> str:
    """The file of a segment, counted from 1."""
    return f"map-{number}.safetensors"


def is_segment_name(name: str) -> bool:
    """Whether a file in the folder of a map is a segment, or left of one."""
    return _NAME.fullmatch(name) is not None


def joined(parts: Sequence[dict[str, NDArray[Any]]]) -> dict[str, NDArray[Any]]:
    """The arrays of a map of those of its first file and of its segments, in their order.

    Raises:
        ValueError: rows of a table have different lengths in different files.
    """
    if len(parts) == 1:
        return parts[0]
    return {
        name: np.concatenate([part[name] for part in parts])
        if _grows(name)
        else (first if name in _ANEW else parts[-1][name])
        for name, first in parts[0].items()
    }


def _grows(name: str) -> bool:
    """Whether an array has one row more for each row that is added to its group."""
    return name.split(".")[0] in GROWING and name not in _ANEW
