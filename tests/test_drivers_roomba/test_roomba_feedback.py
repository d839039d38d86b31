"""Lights, songs and the dock: what the driver asks of the base besides driving."""

import math

import pytest

from drivers.roomba.commands import CommandParser, Leds, Opcode, show_feedback, songs
from drivers.roomba.packets import ChargingState, Packet
from sim_stubs.roomba.base import SimulatedRoomba
from sim_stubs.roomba.dock import SimulatedDock
from tests.helpers.roomba_rig import PERIOD, Rig
from vizbot.core.geometry import planar
from vizbot.core.observer import GoalReport, Outcome
from vizbot.core.types import STOP, BaseMode, Charging, Feedback, Twist
from vizbot.operator.session.notifications import OutcomeFeedback


@pytest.mark.parametrize("feedback", Feedback)
def test_every_feedback_has_its_own_light_and_song(rig, feedback):
    rig.base.show(feedback)
    rig.drive(Twist(0.1, 0.0), 3 * PERIOD)
    leds, _, brightness = rig.stub.settings[Opcode.LEDS]
    assert brightness == 255
    assert (leds == Leds.CHECK_ROBOT) == (feedback is Feedback.STUCK)
    assert rig.base.read().song_playing
    assert rig.floor.speeds == (0.1, 0.1)
    rig.clock.sleep(2.0)
    assert not rig.base.read().song_playing


def test_no_data_byte_of_lights_and_songs_is_an_opcode():
    for command in (songs(), *map(show_feedback, Feedback)):
        whole = list(CommandParser().feed(command))
        for lost in range(len(command)):
            parser = CommandParser()
            obeyed = list(parser.feed(command[:lost] + command[lost + 1 :] + bytes(300)))
            assert {each.opcode for each in obeyed} <= {each.opcode for each in whole}


class DockRig(Rig):
    """A base that stands 0.6 m before its dock."""

    def stub_on(self, floor, encoder_counts):
        return SimulatedRoomba(
            floor, encoder_counts, SimulatedDock(planar(0.6, 0.1, math.pi)), charge=0.5
        )


def test_it_docks_by_itself_and_leaves_when_it_is_asked_to(caplog):
    rig = DockRig()
    with rig.stub, rig.base:
        rig.base.dock()
        for _ in range(1000):
            rig.base.drive(Twist(0.2, 0.0))  # without effect
            rig.clock.sleep(PERIOD)
        state = rig.base.read()
        assert state.docked and state.mode is BaseMode.PASSIVE
        assert state.charging.value == "full charging"
        assert "left Safe mode" not in caplog.text
        rig.base.resume()
        rig.clock.sleep(3 * PERIOD)
        assert rig.base.read().mode is BaseMode.SAFE
        rig.drive(Twist(-0.1, 0.0), 2.0)
        assert not rig.base.read().docked


@pytest.mark.parametrize("charging", [ChargingState.NOT_CHARGING, ChargingState.FAULT])
def test_closing_stops_a_base_on_its_way_to_the_dock(charging):
    rig = DockRig()
    with rig.stub:
        rig.stub.overrides[Packet.CHARGING_STATE] = charging
        rig.base.dock()
        rig.drive(STOP, 0.5)
        assert rig.floor.speeds != (0.0, 0.0)
        rig.base.close()
        rig.clock.sleep(2 * PERIOD)
        assert rig.floor.speeds == (0.0, 0.0)
        assert rig.stub.mode is BaseMode.PASSIVE


def test_silence_on_the_dock_does_not_end_the_charging():
    rig = DockRig()
    with rig.stub, rig.base:
        rig.base.dock()
        rig.drive(STOP, 15.0)
        assert rig.base.read().docked
        with rig.silence():
            rig.clock.sleep(2.0)
        rig.clock.sleep(5.0)
        assert rig.stub.mode is BaseMode.PASSIVE
        assert rig.base.read().charging is not Charging.NOT_CHARGING


@pytest.mark.parametrize(
    ("outcome", "leds"), [(Outcome.ARRIVED, Leds.DEBRIS), (Outcome.GAVE_UP, Leds.CHECK_ROBOT)]
)
def test_the_outcome_of_a_search_is_shown(rig, outcome, leds):
    OutcomeFeedback(rig.base).on_goal(GoalReport("sofa", outcome, "", ()))
    rig.clock.sleep(2 * PERIOD)
    assert rig.stub.settings[Opcode.LEDS][0] == leds
