"""The reflexes' latency on the wall clock."""

from benchmarks.faults.wall_clock import measure_reflexes


def test_bumps_stop_the_wheels_while_the_program_holds_its_lock():
    latency = measure_reflexes(2)
    assert latency.bumps == 2 and 1 <= latency.stopped <= 2
    assert 0.0 < latency.median_ms <= latency.p99_ms <= latency.max_ms < 1000.0
    assert latency.held_ms == 200.0
    assert f"{latency.stopped} of 2 bumps stopped the wheels" in latency.summary()
