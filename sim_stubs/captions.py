"""Captions: texts whose truth on any patch can be computed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim_stubs.atoms import Atoms


@dataclass(frozen=True, slots=True)
class Caption:
    """A text and what it says.

    Attributes:
        text: As a person may put it.
        atoms: Keys of the atoms that must all be shown; empty where no picture shows what it says.
    """

    text: str
    atoms: tuple[str, ...]


def draw_captions(atoms: Atoms, patch: int, rng: np.random.Generator, n: int) -> list[Caption]:
    """`n` captions that are true for a patch; none where it shows nothing that can be told."""
    raise NotImplementedError


def draw_contrasts(atoms: Atoms, patch: int, rng: np.random.Generator, n: int) -> list[Caption]:
    """Like `draw_captions`, then one word is changed: most are wrong for the patch."""
    raise NotImplementedError


def draw_negatives(rng: np.random.Generator, n: int) -> list[Caption]:
    """`n` texts that no patch shows."""
    raise NotImplementedError


def target(captions: Sequence[Caption], atoms: Atoms) -> NDArray[np.float32]:
    """How true (P, M) each caption is for each patch, 0 to 1; NaN: open to dispute."""
    raise NotImplementedError
