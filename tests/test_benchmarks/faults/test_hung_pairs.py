"""Watchdog and reflexes that both hang, on the wall clock."""

from benchmarks.faults.wall_clock import measure_hung_pairs


def test_the_program_stops_the_wheels_of_a_pair_that_hangs_and_leaves_nothing_behind(caplog):
    hung = measure_hung_pairs(1)
    assert (hung.hangs, hung.stopped) == (1, 1)
    assert 300.0 < hung.median_ms == hung.max_ms
    assert "stopped the wheels 1 of 1 times" in hung.summary()
    assert "could not be stopped yet" not in caplog.text
