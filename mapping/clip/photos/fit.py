"""The numbers of the classes of photographs that were fitted on photographs of homes."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path

FIT_FILE = Path(__file__).with_name("fit.json")
"""The numbers, and what they were fitted on; `python -m training.photo_fit` makes it."""


@dataclass(frozen=True, slots=True)
class PhotoFit:
    """The fitted numbers.

    Attributes:
        temperature: What the classifier's logits are divided by.
        scale: Of the log odds that a picture shows what a text names, by their cosine.
        bias: Likewise.
    """

    temperature: float
    scale: float
    bias: float

    @property
    def threshold(self) -> float:
        """The cosine of even odds."""
        return -self.bias / self.scale


@cache
def photo_fit(file: Path = FIT_FILE) -> PhotoFit:
    """The numbers of a file."""
    kept = json.loads(file.read_text(encoding="utf-8"))
    return PhotoFit(*(float(kept[name]) for name in ("temperature", "scale", "bias")))
