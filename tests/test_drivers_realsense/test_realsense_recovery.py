"""What is done about a camera without frames, and when; no camera takes part."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.realsense.recovery import RecoveryStep, StreamRecovery


def recovery(limit=60.0):
    """Of a camera whose frames are waited for since 0 s, noticed at 1 s."""
    return StreamRecovery(since=0.0, limit=limit, patience=5.0, now=1.0)


def steps(camera, ticks, streaming=True, listed=True):
    """What is done at which second."""
    asked = ((now, camera.next(now, streaming, listed)) for now in ticks)
    return [(now, step) for now, step in asked if step is not RecoveryStep.WAIT]


def test_a_silent_camera_is_opened_anew_then_reset_and_so_on():
    assert steps(recovery(limit=30.0), range(1, 32)) == [
        (2, RecoveryStep.OPEN),
        (7, RecoveryStep.RESET),
        (10, RecoveryStep.OPEN),
        (15, RecoveryStep.RESET),
        (18, RecoveryStep.OPEN),
        (23, RecoveryStep.RESET),
        (26, RecoveryStep.OPEN),
        (30, RecoveryStep.GIVE_UP),
        (31, RecoveryStep.GIVE_UP),
    ]


def test_a_camera_that_has_gone_is_let_go_and_opened_when_it_is_back():
    camera = recovery()
    assert camera.next(2.0, streaming=True, listed=False) is RecoveryStep.LET_GO
    assert steps(camera, range(3, 40), streaming=False, listed=False) == []
    assert camera.next(42.0, streaming=False, listed=True) is RecoveryStep.OPEN


@pytest.mark.parametrize(("looks", "pause"), [(1, 0.25), (2, 0.5), (3, 1.0), (4, 2.0), (9, 2.0)])
def test_a_camera_that_is_gone_is_looked_for_ever_more_seldom(looks, pause):
    camera, now = recovery(), 2.0
    for _ in range(looks):
        now += 2.0
        camera.next(now, streaming=False, listed=False)
    assert camera.next(now + pause - 0.01, streaming=False, listed=True) is RecoveryStep.WAIT
    assert camera.next(now + pause + 0.01, streaming=False, listed=True) is RecoveryStep.OPEN


def test_streams_that_break_are_opened_anew_at_once():
    camera = recovery()
    camera.lose(1.0)
    assert camera.next(1.0, streaming=False, listed=True) is RecoveryStep.OPEN


def test_an_opening_that_fails_is_tried_once_more_before_the_reset():
    camera, now, done = recovery(), 2.0, []
    while now < 8.0:
        step = camera.next(now, streaming=False, listed=True)
        if step is not RecoveryStep.WAIT:
            done.append(step)
        if step is RecoveryStep.OPEN:
            camera.fail(now)
        now += 0.25
    assert done[:5] == [
        RecoveryStep.OPEN,
        RecoveryStep.OPEN,
        RecoveryStep.RESET,
        RecoveryStep.OPEN,
        RecoveryStep.OPEN,
    ]


def test_a_camera_that_comes_back_after_a_failure_is_not_reset_first():
    camera = recovery()
    for now in (2.0, 3.0):
        assert camera.next(now, streaming=False, listed=True) is RecoveryStep.OPEN
        camera.fail(now)
    camera.next(5.0, streaming=False, listed=False)
    assert camera.next(9.0, streaming=False, listed=True) is RecoveryStep.OPEN


def test_without_patience_it_is_given_up_at_once():
    assert recovery(limit=0.0).next(1.0, streaming=True, listed=True) is RecoveryStep.GIVE_UP


@given(
    st.lists(
        st.tuples(st.floats(0.0, 10.0), st.booleans(), st.booleans(), st.booleans()), max_size=40
    )
)
def test_nothing_is_asked_of_a_camera_that_is_not_there(course):
    camera, now = recovery(), 1.0
    for seconds, streaming, listed, fails in course:
        now += seconds
        step = camera.next(now, streaming, listed)
        assert listed or step not in (RecoveryStep.OPEN, RecoveryStep.RESET)
        assert streaming or step is not RecoveryStep.LET_GO
        assert (now >= 60.0) == (step is RecoveryStep.GIVE_UP)
        if step is RecoveryStep.OPEN and fails:
            camera.fail(now)
