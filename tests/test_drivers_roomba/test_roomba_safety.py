"""What stops the Roomba: silence, bumps, cliffs, dropped wheels."""

import pytest

from drivers.roomba.packets import Buttons, ChargingSources, LightBumper, Overcurrents, Packet
from sim_stubs.world.body import Contacts
from tests.helpers.roomba_rig import PERIOD
from vizbot.core.errors import DeviceTimeoutError
from vizbot.core.types import BaseMode, Button, Twist


def test_the_wheels_stop_when_commands_stop_and_start_again(rig, caplog):
    rig.drive(Twist(0.2, 0.0), 0.5)
    last_command = rig.clock.now() - PERIOD
    while rig.floor.speeds != (0.0, 0.0):
        rig.clock.sleep(PERIOD)
        assert rig.clock.now() - last_command < 1.0
    # The stop is written at the first frame that is 0.3 s late, and holds from there on.
    assert rig.clock.now() - last_command == pytest.approx(0.3 + PERIOD, abs=1e-6)
    assert "no command for 0.3 s" in caplog.text
    rig.clock.sleep(1.0)
    assert rig.floor.speeds == (0.0, 0.0)
    rig.drive(Twist(0.2, 0.0), 2 * PERIOD)
    assert rig.floor.speeds == (0.2, 0.2)


def test_a_program_that_is_late_again_and_again_is_logged_once_until_it_was_not(rig, caplog):
    for pause, told in ((0.4, 1), (0.4, 1), (0.4, 1), (6.0, 1), (0.4, 2)):
        rig.drive(Twist(0.2, 0.0), 2 * PERIOD)
        rig.clock.sleep(pause)
        assert rig.floor.speeds == (0.0, 0.0)
        assert caplog.text.count("no command for 0.3 s") == told


def test_commands_just_in_time_keep_the_wheels_turning(rig):
    for _ in range(5):
        rig.base.drive(Twist(0.2, 0.0))
        rig.clock.sleep(19 * PERIOD)
        assert rig.floor.speeds == (0.2, 0.2)


def test_a_base_that_falls_silent_is_reported_and_still_commanded_to_stop(rig):
    rig.drive(Twist(0.2, 0.0), 0.3)
    rig.stub.publish = lambda: None
    rig.drive(Twist(0.2, 0.0), 0.165)
    assert rig.base.read().mode is BaseMode.SAFE
    rig.drive(Twist(0.2, 0.0), 0.03)
    with pytest.raises(DeviceTimeoutError, match=r"no answer from the base for 0.18 s; check"):
        rig.base.read()
    assert rig.floor.speeds == (0.0, 0.0)


def test_a_base_that_speaks_again_is_read_again_and_obeys_again(rig):
    rig.drive(Twist(0.2, 0.0), 0.3)
    with rig.silence():
        rig.clock.sleep(0.7)
    rig.clock.sleep(7 * PERIOD)
    state = rig.base.read()
    assert state.stamp == pytest.approx(rig.clock.now() - PERIOD)
    assert state.mode is BaseMode.SAFE
    assert rig.floor.speeds == (0.0, 0.0)
    rig.drive(Twist(0.2, 0.0), 2 * PERIOD)
    assert rig.floor.speeds == (0.2, 0.2)
    rig.settle()
    assert rig.error()[0] < 0.001


def test_a_base_that_was_switched_off_and_on_is_woken_again(rig):
    rig.drive(Twist(0.2, 0.0), 0.3)
    rig.ports[0].write(bytes([7]))  # as its batteries do when they are taken out and put back
    rig.clock.sleep(1.0)
    assert rig.base.read().mode is BaseMode.SAFE
    assert rig.floor.speeds == (0.0, 0.0)


@pytest.mark.parametrize(
    ("contacts", "left", "right"),
    [(Contacts(bump_left=True), True, False), (Contacts(bump_right=True), False, True)],
)
def test_a_bump_stops_forward_motion_and_lets_the_base_back_off(rig, contacts, left, right):
    rig.drive(Twist(0.2, 0.0), 0.15)
    rig.floor.contacts = contacts
    rig.clock.sleep(PERIOD)
    assert rig.floor.speeds == (0.0, 0.0)
    state = rig.base.read()
    assert (state.bump_left, state.bump_right, state.bumped) == (left, right, True)
    assert state.mode is BaseMode.SAFE
    rig.drive(Twist(0.2, 0.5), 2 * PERIOD)
    assert rig.floor.speeds == (0.0, 0.0)
    rig.drive(Twist(0.0, 0.5), 2 * PERIOD)
    assert rig.floor.speeds == pytest.approx((-0.05875, 0.05875), abs=1e-3)
    rig.drive(Twist(-0.1, 0.0), 2 * PERIOD)
    assert rig.floor.speeds == (-0.1, -0.1)


@pytest.mark.parametrize("sensor", range(4))
def test_a_cliff_ends_safe_mode_and_driving_has_no_effect_until_resumed(rig, caplog, sensor):
    rig.drive(Twist(0.2, 0.0), 0.15)
    rig.floor.contacts = Contacts(cliffs=tuple(n == sensor for n in range(4)))
    rig.drive(Twist(0.2, 0.0), 0.3)
    assert rig.floor.speeds == (0.0, 0.0)
    state = rig.base.read()
    assert state.mode is BaseMode.PASSIVE
    assert [n for n in range(4) if state.cliffs[n]] == [sensor]
    assert "left Safe mode (cliff)" in caplog.text
    rig.base.resume()
    rig.clock.sleep(3 * PERIOD)
    assert rig.base.read().mode is BaseMode.SAFE
    assert rig.floor.speeds == (0.0, 0.0)
    rig.drive(Twist(0.2, 0.0), 0.15)
    assert rig.floor.speeds == (0.0, 0.0)
    rig.drive(Twist(-0.1, 0.0), 0.15)
    assert rig.floor.speeds == (-0.1, -0.1)


def test_resuming_does_not_bring_the_last_twist_back(rig):
    rig.floor.contacts = Contacts(wheel_drops=(True, True))
    rig.clock.sleep(0.15)
    rig.floor.contacts = Contacts()
    rig.base.drive(Twist(0.2, 0.0))
    rig.base.resume()
    rig.clock.sleep(4 * PERIOD)
    assert rig.base.read().mode is BaseMode.SAFE
    assert rig.floor.speeds == (0.0, 0.0)


@pytest.mark.parametrize("drops", [(True, False), (False, True)])
def test_a_wheel_drop_stops_the_base(rig, drops):
    rig.drive(Twist(0.2, 0.0), 0.15)
    rig.floor.contacts = Contacts(wheel_drops=drops)
    rig.drive(Twist(-0.2, 0.0), 0.15)
    assert rig.floor.speeds == (0.0, 0.0)
    assert rig.base.read().wheel_drops == drops
    assert rig.base.read().mode is BaseMode.PASSIVE


@pytest.mark.parametrize(
    ("packet", "value", "turns"),
    [(Packet.VIRTUAL_WALL, 1, True), (Packet.OVERCURRENTS, Overcurrents.LEFT_WHEEL, False)],
)
def test_at_a_virtual_wall_it_may_turn_and_with_a_stuck_wheel_back_off(rig, packet, value, turns):
    rig.drive(Twist(0.2, 0.0), 0.15)
    rig.stub.overrides[packet] = value
    rig.clock.sleep(PERIOD)
    assert rig.floor.speeds == (0.0, 0.0)
    assert rig.base.read().blocked
    rig.drive(Twist(0.0, 0.5), 2 * PERIOD)
    assert (rig.floor.speeds != (0.0, 0.0)) == turns
    rig.drive(Twist(0.0, 0.0), 2 * PERIOD)
    rig.drive(Twist(-0.1, 0.0), 2 * PERIOD)
    assert rig.floor.speeds == (-0.1, -0.1)


@pytest.mark.parametrize("twist", [Twist(0.0, 1.0), Twist(0.2, 0.5)])
def test_a_bump_stops_turning_as_well_until_the_program_says_more(rig, twist):
    rig.drive(twist, 0.15)
    rig.floor.contacts = Contacts(bump_left=True)
    rig.clock.sleep(PERIOD)
    assert rig.floor.speeds == (0.0, 0.0)
    rig.clock.sleep(5 * PERIOD)
    assert rig.floor.speeds == (0.0, 0.0)
    rig.drive(Twist(0.0, 1.0), 2 * PERIOD)
    assert rig.floor.speeds[1] > 0.1


def test_what_is_seen_right_ahead_is_approached_slowly_along_a_ramp(open_rig):
    rig = open_rig(deceleration=4.0)
    rig.drive(Twist(0.4, 0.0), 0.3)
    rig.stub.overrides[Packet.LIGHT_BUMPER] = LightBumper.CENTER_LEFT
    speeds = []
    for _ in range(8):
        rig.drive(Twist(0.4, 0.0), PERIOD)
        speeds.append(rig.floor.speeds[0])
    assert speeds[0] > 0.3
    assert speeds[-1] == pytest.approx(0.12, abs=0.01)


def test_a_contact_that_lasts_for_one_frame_is_read_once(rig):
    rig.floor.contacts = Contacts(bump_left=True)
    rig.clock.sleep(PERIOD)
    rig.floor.contacts = Contacts()
    rig.clock.sleep(5 * PERIOD)
    assert rig.base.read().bump_left
    assert not rig.base.read().bump_left


def test_cliffs_and_drops_stop_the_wheels_even_if_the_base_would_not(open_rig):
    # A base in Full mode has its own cut-outs off.
    rig = open_rig(full_mode=True)
    for contacts in (Contacts(cliffs=(True,) * 4), Contacts(wheel_drops=(True, False))):
        rig.floor.contacts = Contacts()
        rig.drive(Twist(0.2, 0.0), 0.15)
        assert rig.floor.speeds == (0.2, 0.2)
        rig.floor.contacts = contacts
        rig.clock.sleep(PERIOD)
        assert rig.floor.speeds == (0.0, 0.0)
        assert rig.base.read().mode is BaseMode.FULL


def test_what_reflects_right_before_the_bumper_is_approached_slowly(rig):
    rig.drive(Twist(0.3, 0.6), 0.1)
    rig.stub.overrides[Packet.LIGHT_BUMPER] = LightBumper.CENTER_LEFT
    rig.drive(Twist(0.3, 0.6), 2 * PERIOD)
    left, right = rig.floor.speeds
    assert (left + right) / 2 == pytest.approx(0.12, abs=0.01)
    assert (right - left) / 0.235 == pytest.approx(0.24, abs=0.1)  # the same arc
    rig.drive(Twist(-0.3, 0.0), 4 * PERIOD)
    assert rig.floor.speeds == (-0.3, -0.3)
    rig.stub.overrides[Packet.LIGHT_BUMPER] = LightBumper.LEFT | LightBumper.RIGHT
    rig.drive(Twist(0.3, 0.0), 6 * PERIOD)
    assert rig.floor.speeds == (0.3, 0.3)


def test_a_button_in_a_single_frame_is_no_press(rig):
    rig.stub.overrides[Packet.BUTTONS] = Buttons.CLEAN
    rig.clock.sleep(PERIOD)
    del rig.stub.overrides[Packet.BUTTONS]
    rig.clock.sleep(PERIOD)
    assert rig.base.read().buttons == frozenset()
    rig.stub.press(Buttons.CLEAN)
    rig.clock.sleep(3 * PERIOD)
    assert rig.base.read().buttons == frozenset({Button.CLEAN})


@pytest.mark.parametrize(
    ("contacts", "sources"),
    [
        (Contacts(wheel_drops=(True, True)), 0),
        (Contacts(cliffs=(True, False, False, False)), 0),
        (Contacts(), ChargingSources.INTERNAL_CHARGER),
    ],
)
def test_lifted_while_its_line_was_silent_it_does_not_obey_again_unasked(rig, contacts, sources):
    rig.drive(Twist(0.2, 0.0), 1.0)
    with rig.silence():
        rig.drive(Twist(0.2, 0.0), 0.3)
        rig.floor.contacts = contacts
        rig.stub.overrides[Packet.CHARGING_SOURCES] = sources
        rig.drive(Twist(0.2, 0.0), 0.4)
    rig.drive(Twist(0.2, 0.0), 0.9)
    rig.floor.contacts, rig.stub.overrides = Contacts(), {}
    rig.drive(Twist(0.2, 0.0), 3.0)
    assert rig.stub.mode is BaseMode.PASSIVE
    assert rig.floor.speeds == (0.0, 0.0)
    rig.base.resume()
    rig.drive(Twist(0.2, 0.0), 0.15)
    assert rig.floor.speeds == (0.2, 0.2)


def test_with_resume_safe_it_obeys_again_once_it_is_put_down(open_rig):
    rig = open_rig(resume_safe=True)
    rig.drive(Twist(0.2, 0.0), 1.0)
    with rig.silence():
        rig.floor.contacts = Contacts(wheel_drops=(True, True))
        rig.drive(Twist(0.2, 0.0), 0.7)
    rig.drive(Twist(0.2, 0.0), 4.0)
    assert rig.stub.mode is BaseMode.PASSIVE
    rig.floor.contacts = Contacts()
    rig.drive(Twist(0.2, 0.0), 1.0)
    assert rig.stub.mode is BaseMode.SAFE
