"""Safe and Full mode, and what the base does not do with a charger plugged in."""

import pytest

from drivers.roomba.packets import ChargingSources, Packet
from sim_stubs.world.body import Contacts
from tests.helpers.roomba_rig import PERIOD
from vizbot.core.types import STOP, BaseMode, Twist


def test_with_a_charger_plugged_in_it_is_not_asked_to_obey(rig, caplog):
    rig.drive(Twist(0.2, 0.0), 0.3)
    rig.stub.overrides[Packet.CHARGING_SOURCES] = ChargingSources.INTERNAL_CHARGER
    rig.drive(Twist(0.2, 0.0), 0.3)
    assert rig.base.read().plugged_in and rig.base.read().on_charger
    assert "left Safe mode (its charger)" in caplog.text
    del rig.stub.overrides[Packet.CHARGING_SOURCES]
    rig.drive(Twist(0.2, 0.0), 1.0)
    assert rig.stub.mode is BaseMode.PASSIVE
    assert rig.floor.speeds == (0.0, 0.0)


def test_full_mode_is_a_choice_with_a_warning(open_rig, caplog):
    assert open_rig().base.read().mode is BaseMode.SAFE
    assert "Full mode" not in caplog.text
    assert open_rig(full_mode=True).base.read().mode is BaseMode.FULL
    assert "Full mode: the base does not stop at cliffs by itself" in caplog.text


def test_a_base_that_is_in_full_mode_unasked_is_commanded_to_leave_it(rig, caplog):
    rig.clock.sleep(1.0)
    rig.stub.mode = BaseMode.FULL
    rig.clock.sleep(3 * PERIOD)
    assert rig.stub.mode is BaseMode.SAFE
    assert "FULL mode unasked" in caplog.text


def test_safe_mode_comes_back_by_itself_only_if_the_configuration_says_so(open_rig, caplog):
    rig = open_rig(resume_safe=True)
    rig.clock.sleep(1.0)
    rig.floor.contacts = Contacts(wheel_drops=(True, True))
    rig.clock.sleep(2.0)
    assert rig.base.read().mode is BaseMode.PASSIVE
    rig.floor.contacts = Contacts()
    rig.clock.sleep(4 * PERIOD)
    assert rig.base.read().mode is BaseMode.SAFE
    assert "resume_safe" in caplog.text


def test_without_it_safe_mode_does_not_come_back(rig):
    rig.floor.contacts = Contacts(wheel_drops=(True, True))
    rig.clock.sleep(0.15)
    rig.floor.contacts = Contacts()
    rig.clock.sleep(5.0)
    assert rig.base.read().mode is BaseMode.PASSIVE


@pytest.mark.parametrize("docked_before", [True, False])
def test_on_its_dock_a_base_that_was_silent_briefly_obeys_again_if_it_stood_there_before(
    rig, docked_before
):
    rig.stub._keep_safe = lambda: None  # its dock does not end Safe mode
    if docked_before:
        rig.stub.overrides[Packet.CHARGING_SOURCES] = ChargingSources.HOME_BASE
    rig.drive(STOP, 1.0)
    with rig.silence():
        rig.stub.overrides[Packet.CHARGING_SOURCES] = ChargingSources.HOME_BASE
        rig.clock.sleep(0.8)
        assert rig.stub.mode is BaseMode.PASSIVE
    rig.clock.sleep(1.0)
    assert rig.base.read().mode.obeys == docked_before
    assert rig.base.read().maybe_moved != docked_before


def test_in_full_mode_too_a_cable_of_a_charger_is_not_driven_with(open_rig):
    rig = open_rig(full_mode=True)
    rig.drive(Twist(0.2, 0.0), 0.15)
    rig.stub.overrides[Packet.CHARGING_SOURCES] = ChargingSources.INTERNAL_CHARGER
    for twist in (Twist(0.2, 0.0), Twist(-0.1, 0.0), Twist(0.0, 0.5)):
        rig.drive(twist, 2 * PERIOD)
        assert rig.floor.speeds == (0.0, 0.0)
    rig.stub.overrides[Packet.CHARGING_SOURCES] = ChargingSources.HOME_BASE
    rig.drive(Twist(-0.1, 0.0), 2 * PERIOD)
    assert rig.floor.speeds == (-0.1, -0.1)  # off its dock
