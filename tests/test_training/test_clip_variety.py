"""Furniture of other looks, which the embedded CLIP trains on."""

from dataclasses import replace

import numpy as np
import pytest

from sim_stubs.homes.furniture import procedural
from sim_stubs.homes.geometry.solids import triangles
from training.variety import another


@pytest.fixture(scope="module")
def bed():
    return procedural.piece("bed", np.random.default_rng(2))


def corners(piece):
    return triangles(piece.parts).reshape(-1, 3)


def looks(piece):
    return [(*np.round(part.rgba, 3), part.texture) for part in piece.parts]


def test_another_piece_fits_where_the_first_stood(bed):
    low, high = corners(bed).min(axis=0), corners(bed).max(axis=0)
    for seed in range(40):
        other = corners(another(bed, np.random.default_rng(seed)))
        assert (other >= low - 1e-5).all() and (other <= high + 1e-5).all()
        np.testing.assert_allclose(other[:, 2].max(), high[2], atol=1e-5)


def test_proportions_change_and_left_stays_like_right(bed):
    shaped = another(bed, np.random.default_rng(0))
    assert np.abs(corners(shaped) - corners(bed)).max() > 0.02
    mirrored = corners(bed) * (-1, 1, 1)
    pairs = np.array([np.abs(mirrored - at).sum(axis=1).argmin() for at in corners(bed)])
    alike = np.abs(mirrored[pairs] - corners(bed)).sum(axis=1) < 1e-4
    assert alike.any()
    both = corners(shaped) * (-1, 1, 1)
    np.testing.assert_allclose(both[pairs][alike], corners(shaped)[alike], atol=1e-3)


def test_some_are_painted_and_screens_are_not(bed):
    others = [another(bed, np.random.default_rng(seed)) for seed in range(100)]
    painted = [looks(other) != looks(bed) for other in others]
    assert 0.2 < np.mean(painted) < 0.5
    assert all(other.name == "bed" for other, p in zip(others, painted, strict=True) if p)
    tv = procedural.piece("tv", np.random.default_rng(0))
    assert all(looks(another(tv, np.random.default_rng(i))) == looks(tv) for i in range(20))


def test_a_seed_gives_the_same_looks_twice(bed):
    once, again = (another(bed, np.random.default_rng(3)) for _ in range(2))
    np.testing.assert_array_equal(corners(once), corners(again))
    assert looks(once) == looks(again)


def test_what_is_called_by_its_colour_keeps_it():
    chair = replace(procedural.piece("chair", np.random.default_rng(0)), label="yellow chair")
    for seed in range(40):
        assert looks(another(chair, np.random.default_rng(seed))) == looks(chair)
