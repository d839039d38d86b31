import numpy as np
import pytest

from mapping.clip import growing_rows
from mapping.clip.growing_rows import GrowingRows
from mapping.clip.mapped_frames import MappedFrame
from mapping.clip.mapper import ClipMap, FrameElements
from tests.helpers.memory import peak_kib


@pytest.fixture(params=["addresses", "none"])
def system(request, monkeypatch):
    """One that gives addresses without memory, or one that does not."""
    monkeypatch.setattr(growing_rows, "_has_addresses", lambda: request.param == "addresses")


def test_rows_are_those_that_were_added_in_their_order(system):
    rng = np.random.default_rng(1)
    parts = [rng.normal(size=(count, 2)).astype(np.float32) for count in (3, 0, 400, 1, 90)]
    grown = GrowingRows(parts[0])
    for part in parts[1:]:
        grown.add(part)
    grown.add_same([7.0, 8.0], 2)
    assert len(grown) == 496
    np.testing.assert_array_equal(grown.rows[:-2], np.concatenate(parts))
    np.testing.assert_array_equal(grown.rows[-2:], [[7.0, 8.0], [7.0, 8.0]])


def test_rows_that_were_given_out_and_those_it_began_with_do_not_change(system):
    first = np.zeros(3, np.float32)
    grown = GrowingRows(first)
    grown.add(np.ones(2, np.float32))
    early = grown.rows
    grown.add(np.full(9000, 2.0, np.float32))
    changed = grown.with_changed(np.array([0, 4]), np.array([5.0, 6.0], np.float32))
    assert first.tolist() == [0, 0, 0] and early.tolist() == [0, 0, 0, 1, 1]
    assert changed.rows[:6].tolist() == [5, 0, 0, 1, 6, 2]


@pytest.mark.parametrize("kept", [0, 1, 100_000])
def test_a_row_more_moves_none_of_those_that_are_there(kept):
    grown = GrowingRows(np.zeros((kept, 2), np.float32))
    grown.add(np.zeros((1, 2), np.float32))
    before = grown.rows
    for _ in range(20):  # past several doublings
        grown.add(np.zeros((25 + len(grown) // 6, 2), np.float32))
        assert np.shares_memory(before, grown.rows)


def test_elements_more_move_none_of_those_that_are_there():
    clip_map = ClipMap(512)
    fresh = FrameElements(
        np.zeros((90, 3)), np.zeros((90, 512), np.float32), np.zeros((90, 4), np.int32)
    )
    clip_map.add(MappedFrame(0, 0, np.eye(4), 0.0), fresh)
    before = clip_map.elements
    for frame in range(1, 60):
        clip_map.add(MappedFrame(frame, 0, np.eye(4), 0.0), fresh)
        for name in ("embeddings", "points_keyframe", "keyframes", "frames", "boxes"):
            now = getattr(clip_map.elements, name)
            assert np.shares_memory(getattr(before, name), now)


def test_rows_beyond_the_addresses_are_all_there():
    grown = GrowingRows(np.zeros(1), room=10)
    grown.add(np.arange(1.0, 50.0))
    assert grown.rows.tolist() == list(range(50))


def test_addresses_take_no_memory_before_there_are_rows():
    before = peak_kib()
    arrays = [GrowingRows(np.ones((1, 512), np.float32)) for _ in range(100)]
    assert len(arrays) == 100 and peak_kib() - before < 10_000
