"""Keyframes that look like an image are found by words of their descriptors."""

import numpy as np
import pytest

from mapping.keyframes.config import PlaceIndexConfig
from mapping.keyframes.place_index import PlaceIndex
from mapping.odometry.features import NO_FEATURES, Features


def place(rng, count=400):
    bits = rng.integers(0, 2, (count, 256), dtype=np.uint8)
    return seen(bits)


def seen(bits):
    packed = np.packbits(bits, axis=1).view(np.uint64)
    return Features(np.zeros((len(bits), 2)), packed, np.zeros((len(bits), 3)))


def again(features, rng, flipped=0.1, common=0.5):
    """The same place from elsewhere: some corners are new, bits of the others flip."""
    bits = np.unpackbits(features.descriptors.view(np.uint8), axis=1)
    bits = bits ^ (rng.random(bits.shape) < flipped)
    new = rng.random(len(bits)) > common
    bits[new] = rng.integers(0, 2, (int(new.sum()), 256), dtype=np.uint8)
    return seen(bits.astype(np.uint8))


@pytest.fixture
def places():
    rng = np.random.default_rng(3)
    return [place(rng) for _ in range(40)]


@pytest.fixture
def index(places):
    index = PlaceIndex(PlaceIndexConfig())
    for i, features in enumerate(places):
        index.add(10 * i, features)
    return index


def test_a_place_seen_again_comes_first_and_far_before_the_next(index, places):
    rng = np.random.default_rng(5)
    for i, features in enumerate(places):
        (first, best), (_, second) = index.most_similar(again(features, rng), 2)
        assert first == 10 * i
        assert best > 5 * second


def test_what_all_places_show_distinguishes_none(places):
    carpet = place(np.random.default_rng(6), 300)
    index = PlaceIndex(PlaceIndexConfig())
    for i, features in enumerate(places[:10]):
        both = np.concatenate((features.descriptors[:100], carpet.descriptors))
        index.add(i, Features(np.zeros((400, 2)), both, np.zeros((400, 3))))
    only_carpet = index.most_similar(carpet, 10)
    own = index.most_similar(
        seen(np.unpackbits(places[4].descriptors[:100].view(np.uint8), axis=1)), 1
    )
    assert own[0][0] == 4
    assert only_carpet[0][1] < 0.2 * own[0][1]


def test_nothing_seen_or_nothing_known_finds_nothing(index):
    assert PlaceIndex(PlaceIndexConfig()).most_similar(place(np.random.default_rng(0)), 3) == []
    assert all(score == 0 for _, score in index.most_similar(NO_FEATURES, 3))
    index.add(7, NO_FEATURES)
    assert len(index.most_similar(NO_FEATURES, 100)) == 41
