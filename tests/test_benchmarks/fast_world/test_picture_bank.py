"""The bank of pictures: what is shipped is what its program draws."""

import numpy as np

from benchmarks.fast_world.picture_bank import HOMES, pictures_of
from mapping.clip.background.pictures import PICTURES_ID, bank

JPEG = 3.0
"""Most that a picture differs by from what was rendered, on average [grey levels of 255]."""


def test_the_shipped_pictures_are_those_that_the_program_draws() -> None:
    first = pictures_of(HOMES[0])
    assert len(bank()) == len(HOMES) * len(first)
    for drawn, shipped in zip(first, bank(), strict=False):
        assert np.abs(drawn.astype(np.int16) - shipped).mean() < JPEG
    assert np.abs(first[0].astype(np.int16) - bank()[1]).mean() > 10 * JPEG


def test_the_bank_keeps_its_name() -> None:
    """Saved maps hold it, and the numbers of the belief were fitted with this bank."""
    assert PICTURES_ID == "75e4209b7917"
