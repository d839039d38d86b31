"""The catalogue of faults, how they are asked for, and when they happen."""

import re
from types import SimpleNamespace

import pytest

from sim_stubs.faults.catalogue import CATALOGUE, FaultSchedule, PlannedFault, parse_faults
from vizbot.core.errors import ConfigError


def clock_by_hand():
    return SimpleNamespace(time=0.0)


def scheduled(text, hand, seed=0):
    return FaultSchedule(parse_faults(text), lambda: hand.time, seed)


def times_of(schedule, hand, name, end):
    """When a fault begins, looking every 0.1 s."""
    begun = []
    while hand.time < end:
        began = schedule.began(name)
        if began is not None and (not begun or begun[-1] != began):
            begun.append(began)
        hand.time += 0.1
    return begun


def test_a_fault_begins_at_its_time_and_lasts_as_long_as_it_is_told_to():
    hand = clock_by_hand()
    schedule = scheduled("bump@12, camera-frozen@40+3", hand)
    assert schedule.names == {"bump", "camera-frozen"}
    for time, bump, frozen in ((11.9, False, False), (12.0, True, False), (40.0, True, True),
                               (42.9, True, True), (43.1, True, False)):  # fmt: skip
        hand.time = time
        assert (schedule.active("bump"), schedule.active("camera-frozen")) == (bump, frozen)
    assert not schedule.active("cliff")


def test_a_name_alone_begins_with_the_run():
    assert scheduled("mode-off-by-one", clock_by_hand()).active("mode-off-by-one")


def test_a_rate_is_times_a_minute_and_a_seed_gives_the_same_times():
    hand = clock_by_hand()
    schedule = scheduled("encoder-jump~6", hand, seed=1)
    begun = times_of(schedule, hand, "encoder-jump", 600.0)
    assert 40 < len(begun) < 80
    again = clock_by_hand()
    assert begun == times_of(scheduled("encoder-jump~6", again, 1), again, "encoder-jump", 600.0)
    other = clock_by_hand()
    assert begun != times_of(scheduled("encoder-jump~6", other, 2), other, "encoder-jump", 600.0)


def test_a_fault_may_wait_until_the_robot_rolls_and_the_next_one_waits_for_it():
    hand, rolling = clock_by_hand(), []
    planned = [
        PlannedFault(CATALOGUE["mode-off-by-one"], 1.0, 9.0),
        PlannedFault(CATALOGUE["bump"], 1.0, 9.0, rolling=True),
        PlannedFault(CATALOGUE["cliff"], 3.0, 9.0, rolling=True),
    ]
    schedule = FaultSchedule(planned, lambda: hand.time, 0)
    schedule.wait_for_rolling(lambda: bool(rolling))
    hand.time = 2.0
    assert schedule.active("mode-off-by-one")
    assert not schedule.active("bump")
    rolling.append(True)
    hand.time = 2.5
    assert schedule.began("bump") == 2.5
    rolling.clear()
    hand.time = 3.0
    assert schedule.began("cliff") == 3.0


def test_what_happens_at_a_rate_is_over_before_long():
    [bump] = parse_faults("bump~2")
    assert bump.seconds == 20.0


@pytest.mark.parametrize(
    "text",
    [
        "bumb@3",
        "bump+3",
        "bump+2@3",
        "bump~1000000",
        "bump@",
        "bump@x",
        "bump@-1",
        "bump@3+",
        "bump~0",
        "bump~nan",
        "bump 3",
        "",
    ],
)
def test_what_cannot_be_read_is_one_line_with_the_remedy(text):
    with pytest.raises(ConfigError) as error:
        parse_faults(text)
    line = str(error.value)
    assert "\n" not in line
    assert "--faults" in line
    assert "use " in line or "give " in line


def test_every_fault_says_what_happens_and_what_the_robot_must_do():
    for name, fault in CATALOGUE.items():
        assert name == fault.name
        assert fault.what and fault.must
        assert fault.device in ("base", "camera", "encoder", "program")
        assert re.compile(fault.report_pattern)
        assert fault.reaches_wheels or fault.stops_within is not None
