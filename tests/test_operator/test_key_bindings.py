"""What is held, and what it does: on plain terminals and on those that tell releases."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.roomba_rig import PERIOD, Rig
from vizbot.core.types import STOP
from vizbot.operator.teleop.key_bindings import FIRST_STEP, SILENCE, STEPS, KeyBindings
from vizbot.operator.teleop.key_parser import KeyParser
from vizbot.operator.teleop.teleop import PERIOD as TELLS_EVERY

UP, LEFT = b"\x1b[A", b"\x1b[D"
STOPS_WITHIN = 0.6
TELLING = b"\x1b[?27u"


class Hand:
    """A helm, and the terminal that brings it keys at given times."""

    def __init__(self, telling=False):
        self.bindings = KeyBindings()
        self.parser = KeyParser()
        if telling:
            self.type(TELLING, 0.0)

    def type(self, sent, now):
        self.bindings.keys.hear(now)
        self.bindings.take(self.parser.feed(sent, now), now)

    def twist(self, now):
        return self.bindings.twist(now)


def repeats(delay, period, release, late=()):
    """When a plain terminal sends a key that goes down at 0, the first repeats `late` [s]."""
    count = math.floor((release - delay) / period) + 1
    late = [*late, *([0.0] * max(count, 0))]
    return [0.0, *sorted(delay + period * i + late[i] for i in range(count))]


def replay(hand, times, sent, until, step=0.005):
    """Moments and twists from the first time on, the terminal sending at `times`."""
    told, left = [], list(times)
    for now in (step * i for i in range(math.ceil(until / step) + 1)):
        while left and left[0] <= now + 1e-9:
            hand.type(sent, left.pop(0))
        told.append((now, hand.twist(now)))
    return told


@given(st.floats(0.0, 0.5), st.floats(0.03, 0.05), st.floats(0.0, 2.0), st.data())
def test_a_key_that_repeats_drives_without_a_break_until_it_is_let_go(delay, period, release, data):
    late = data.draw(st.lists(st.floats(0.0, 0.02), max_size=5))
    told = replay(Hand(), repeats(delay, period, release, late), UP, release + 1.0)
    moving = [now for now, twist in told if twist != STOP]
    assert moving[0] == 0.0
    assert moving[-1] >= min(release, 0.5)
    assert moving == [now for now, _ in told[: len(moving)]]
    assert moving[-1] < release + STOPS_WITHIN
    speeds = [twist.linear for now, twist in told if now <= release]
    assert speeds == sorted(speeds), "it does not falter while the key is held"


@pytest.mark.parametrize("release", [0.0, 0.3, 0.499, 0.51, 1.2])
@pytest.mark.parametrize("key", [UP, LEFT])
def test_the_wheels_rest_in_time_after_a_key_at_full_speed_is_let_go(release, key):
    rig, hand = Rig(acceleration=2.0, deceleration=4.0), Hand()
    left = repeats(0.5, 0.03, release)
    hand.bindings.step = STEPS
    with rig.stub, rig.base:
        began, told_at, told = rig.clock.now(), -math.inf, STOP
        moved = False
        while (now := rig.clock.now() - began) < release + STOPS_WITHIN:
            while left and left[0] <= now:
                hand.type(key, left.pop(0))
            twist = hand.twist(now)
            if twist != told or now - told_at >= TELLS_EVERY:
                rig.base.drive(twist)
                told_at, told = now, twist
            rig.clock.sleep(PERIOD)
            moved = moved or rig.floor.speeds != (0.0, 0.0)
        assert moved
        assert rig.floor.speeds == (0.0, 0.0)


def test_late_repeats_over_a_network_do_not_stop_it():
    times = [0.0, *(0.5 + 0.3 * i for i in range(8))]
    assert all(twist.linear > 0 for _, twist in replay(Hand(), times, UP, times[-1]))


def test_a_key_that_is_only_touched_drives_gently():
    hand = Hand()
    hand.bindings.step = STEPS
    hand.type(UP, 0.0)
    touched = hand.twist(0.0).linear
    hand.type(UP, 0.5)
    hand.type(UP, 0.54)
    assert 0.0 < touched < 0.11 < hand.twist(0.54).linear == hand.bindings.speed


def test_on_a_plain_terminal_the_newer_key_takes_over():
    hand = Hand()
    hand.type(UP, 0.0)
    hand.type(b"a", 0.1)
    assert (hand.twist(0.1).linear, hand.twist(0.1).angular > 0) == (0.0, True)


def test_where_releases_are_told_a_key_drives_until_its_own():
    hand = Hand(telling=True)
    hand.type(UP, 0.0)
    for i in range(20):
        hand.type(TELLING, 0.1 * i)
        assert hand.twist(0.1 * i).linear == pytest.approx(hand.bindings.speed)
    hand.type(b"\x1b[1;1:3A", 2.0)
    assert hand.twist(2.0) == STOP


def test_two_keys_drive_a_curve_and_opposite_ones_cancel():
    hand = Hand(telling=True)
    hand.type(b"\x1b[119u\x1b[97u", 0.0)
    assert (hand.twist(0.0).linear > 0, hand.twist(0.0).angular > 0) == (True, True)
    hand.type(b"\x1b[115u", 0.0)
    assert (hand.twist(0.0).linear, hand.twist(0.0).angular > 0) == (0.0, True)
    hand.type(b"\x1b[97;1:3u", 0.0)
    assert hand.twist(0.0) == STOP


def test_a_terminal_that_answers_no_more_is_lost_and_old_repeats_do_not_drive():
    hand = Hand(telling=True)
    hand.type(UP, 0.0)
    assert hand.twist(SILENCE - 0.01) != STOP
    assert hand.bindings.keys.changes_at(0.0) == pytest.approx(SILENCE)
    assert hand.twist(SILENCE) == STOP
    hand.type(b"\x1b[1;1:2A" * 10, 2.0)
    assert hand.twist(2.0) == STOP


def test_a_key_that_is_still_held_when_the_terminal_is_back_drives_on():
    hand = Hand(telling=True)
    hand.type(UP, 0.0)
    assert hand.twist(1.0) == STOP
    for i in range(3):
        hand.type(b"\x1b[1;1:2A", 1.0 + 0.03 * i)
    assert hand.twist(1.06) != STOP
    hand.type(b"\x1b[1;1:3A", 1.1)
    assert hand.twist(1.1) == STOP


@pytest.mark.parametrize("telling", [False, True])
@pytest.mark.parametrize("interval", [0.0, 0.002])
def test_repeats_that_were_held_up_on_the_way_do_not_drive(telling, interval):
    hand = Hand(telling)
    for i in range(60):
        hand.type(b"\x1b[1;1:2A" if telling else UP, interval * i)
    assert hand.twist(interval * 59) == STOP


@pytest.mark.parametrize("sent", [b" ", b"\x1b[O", b"r", b"q", b"\x03"])
@pytest.mark.parametrize("telling", [False, True])
def test_space_another_window_and_leaving_stop_at_once(sent, telling):
    hand = Hand(telling)
    hand.type(UP, 0.0)
    hand.type(sent, 0.01)
    assert hand.twist(0.01) == STOP


def test_a_terminal_that_tells_only_of_some_keys_counts_as_plain():
    hand = Hand()
    hand.type(b"\x1b[?3u", 0.0)
    hand.type(b"w", 0.0)
    assert hand.twist(0.1) != STOP
    assert hand.twist(1.0) == STOP


def test_speed_goes_in_steps_up_to_the_last():
    hand = Hand()
    hand.type(b"+", 0.0)
    assert hand.bindings.step == FIRST_STEP + 1
    hand.type(b"---", 0.0)
    assert hand.bindings.step == FIRST_STEP - 2
    hand.type(b"9+", 0.0)
    assert hand.bindings.step == STEPS
    hand.type(b"1-", 0.0)
    assert hand.bindings.step == 1
    hand.type(b"\x1b[49;2;43u", 0.0)  # where + is typed with Shift and 1
    assert hand.bindings.step == 2


@pytest.mark.parametrize("sent", [b"q", b"Q", b"\x1b[113u", b"\x1b[27u", b"\x03", b"\x1b[99;5u"])
def test_q_escape_and_ctrl_c_leave(sent):
    hand = Hand()
    hand.type(sent, 0.0)
    assert hand.bindings.leaves
    assert hand.bindings.interrupts == (sent in (b"\x03", b"\x1b[99;5u"))
