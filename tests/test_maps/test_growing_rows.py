import numpy as np

from mapping.clip.growing_rows import GrowingRows


def test_rows_are_those_that_were_added_in_their_order():
    rng = np.random.default_rng(1)
    parts = [rng.normal(size=(count, 2)).astype(np.float32) for count in (3, 0, 400, 1, 90)]
    grown = GrowingRows(parts[0])
    for part in parts[1:]:
        grown.add(part)
    assert len(grown) == 494
    np.testing.assert_array_equal(grown.rows, np.concatenate(parts))


def test_rows_that_were_given_out_and_those_it_began_with_do_not_change():
    first = np.zeros(3, np.float32)
    grown = GrowingRows(first)
    grown.add(np.ones(2, np.float32))
    early = grown.rows
    grown.add(np.full(9000, 2.0, np.float32))
    assert first.tolist() == [0, 0, 0] and early.tolist() == [0, 0, 0, 1, 1]


def test_a_row_more_copies_nothing_of_a_large_array():
    grown = GrowingRows(np.zeros((100_000, 2), np.float32))
    grown.add(np.zeros((1, 2), np.float32))
    before = grown.rows
    for _ in range(1000):
        grown.add(np.zeros((25, 2), np.float32))
    assert np.shares_memory(before, grown.rows)
