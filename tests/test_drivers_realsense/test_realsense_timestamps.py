"""Which framesets make a frame, by the stamps of their images."""

import itertools
import logging

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.realsense.timestamps import FrameStamps

PERIOD = 1.0 / 30.0


@pytest.fixture
def stamps():
    return FrameStamps("camera")


def test_pairs_in_order_pass_as_they_are(stamps):
    for index in range(5):
        accepted = stamps.judge(100.0 + index, 100.0 + index + 0.4 * PERIOD, PERIOD, float(index))
        assert accepted.stamp == 100.0 + index
        assert not accepted.jumped and accepted.offset == 0.0
    assert stamps.last == 104.0 and stamps.fault == ""


def test_images_that_are_apart_are_left_out_and_logged_once(stamps, caplog):
    for index in range(20):
        color = index * PERIOD
        assert stamps.judge(color, color - 0.6 * PERIOD, PERIOD, color) is None
    [told] = caplog.messages
    assert told.startswith("camera: colour and depth are 20 ms apart; such frames are left out")
    assert "apart" in stamps.fault
    assert stamps.judge(21 * PERIOD, 21 * PERIOD, PERIOD, 21 * PERIOD) is not None
    assert stamps.fault == ""


def test_the_next_burst_is_logged_again_with_how_many_there_were(stamps, caplog):
    for index in range(3):
        stamps.judge(float(index), index - 1.0, PERIOD, 0.1 * index)
    stamps.judge(10.0, 9.0, PERIOD, 10.0)
    assert len(caplog.messages) == 2
    assert caplog.messages[1].endswith("(3 so far)")


def test_what_comes_late_is_left_out(stamps, caplog):
    assert stamps.judge(5.0, 5.0, PERIOD, 5.0)
    assert stamps.judge(4.9, 4.9, PERIOD, 5.03) is None
    assert "out of order" in caplog.text


def test_an_image_that_is_repeated_is_left_out_without_a_word(stamps, caplog):
    assert stamps.judge(5.0, 5.0, PERIOD, 5.0)
    assert stamps.judge(5.0, 5.0 + PERIOD, PERIOD, 5.0 + PERIOD) is None
    assert stamps.fault == "colour stands still"
    assert caplog.messages == []


@pytest.mark.parametrize("jump", [-3600.0, 3600.0])
def test_stamps_go_on_when_the_cameras_clock_jumps(stamps, caplog, jump):
    stamps.judge(1000.0, 1000.0, PERIOD, 50.0)
    if jump < 0.0:  # it takes two to tell a clock from a frameset that was stuck somewhere
        assert stamps.judge(1000.0 + jump, 1000.0 + jump, PERIOD, 50.05) is None
    first = stamps.judge(1000.1 + jump, 1000.1 + jump, PERIOD, 50.1)
    assert first.jumped
    assert first.stamp == pytest.approx(1000.1)
    assert 1000.1 + jump + first.offset == pytest.approx(first.stamp)
    assert "clock jumped by" in caplog.text
    later = stamps.judge(1000.2 + jump, 1000.2 + jump, PERIOD, 50.2)
    assert not later.jumped and later.stamp == pytest.approx(1000.2)


def test_one_frameset_from_long_before_is_no_jump(stamps, caplog):
    stamps.judge(1000.0, 1000.0, PERIOD, 50.0)
    assert stamps.judge(990.0, 990.0, PERIOD, 50.05) is None
    accepted = stamps.judge(1000.1, 1000.1, PERIOD, 50.1)
    assert not accepted.jumped and accepted.stamp == 1000.1
    assert "jumped" not in caplog.text


def test_a_reader_that_comes_late_sees_no_jump(stamps):
    stamps.judge(1000.0, 1000.0, PERIOD, 0.0)
    assert not stamps.judge(1000.0 + PERIOD, 1000.0 + PERIOD, PERIOD, 20.0).jumped
    assert not stamps.judge(1020.0, 1020.0, PERIOD, 20.1).jumped


def test_a_gap_in_a_recording_stays_a_gap(stamps, caplog):
    caplog.set_level(logging.WARNING)
    assert stamps.judge(0.0, 0.0, PERIOD).stamp == 0.0
    accepted = stamps.judge(5000.0, 5000.0, PERIOD)
    assert accepted.stamp == 5000.0 and not accepted.jumped
    assert caplog.messages == []


def test_a_recording_goes_on_when_the_cameras_clock_goes_back(stamps, caplog):
    stamps.judge(1000.0, 1000.0, PERIOD)
    assert stamps.judge(3.0, 3.0, PERIOD) is None  # it takes two, as of a live camera
    first = stamps.judge(3.0 + PERIOD, 3.0 + PERIOD, PERIOD)
    assert first.jumped and first.stamp == pytest.approx(1000.0 + PERIOD)
    assert stamps.judge(4.0, 4.0, PERIOD).stamp == pytest.approx(4.0 + first.offset)
    assert "clock jumped by" in caplog.text


@pytest.mark.parametrize("now", [None, 7.0])
def test_no_frame_is_lost_when_the_cameras_32_bit_clock_begins_again(stamps, caplog, now):
    wrap, taken = 2**32 / 1e6, []
    for index in range(45):
        color = (wrap - 0.5 + index * PERIOD) % wrap
        at = None if now is None else now + index * PERIOD
        taken.append(stamps.judge(color, color, PERIOD, at))
    assert [accepted.jumped for accepted in taken].count(True) == 1
    expected = [wrap - 0.5 + index * PERIOD for index in range(45)]
    assert [accepted.stamp for accepted in taken] == pytest.approx(expected)
    assert "began again" in caplog.text


@given(
    st.lists(
        st.tuples(st.floats(-1e4, 1e4), st.floats(-0.1, 0.1), st.floats(0.0, 30.0)), max_size=30
    )
)
def test_stamps_always_grow(course):
    stamps, now, given_stamps = FrameStamps("camera"), 0.0, []
    for color, apart, seconds in course:
        now += seconds
        if (accepted := stamps.judge(color, color + apart, PERIOD, now)) is not None:
            given_stamps.append(accepted.stamp)
    assert all(a < b for a, b in itertools.pairwise(given_stamps))
