"""What happens to the base while nobody hears it, and when it turns its wheels unasked after that.

Whoever cannot hear it cannot know whether it was lifted and put down elsewhere.
"""

import math
from contextlib import closing

import pytest

from drivers.roomba.config import RoombaConfig
from drivers.roomba.drive_command import SURE_STOP
from drivers.roomba.packets import ChargingSources, Packet
from drivers.roomba.service import Drive, RoombaService
from sim_stubs.roomba.base import SimulatedRoomba
from sim_stubs.roomba.dock import SimulatedDock
from sim_stubs.world.body import Contacts
from tests.helpers.roomba_rig import PERIOD, Rig, WrappedPort
from vizbot.core.errors import DeviceError, DeviceTimeoutError
from vizbot.core.geometry import planar
from vizbot.core.types import STOP, BaseMode, Twist

LIFTED = Contacts(wheel_drops=(True, True))
AHEAD = Twist(0.2, 0.0)


class LooseRig(Rig):
    """A rig whose cable can be pulled out and put back; `asleep` keeps its clock from counting."""

    def __init__(self, **settings):
        self.out = False
        super().__init__(**settings)

    def open_port(self):
        if self.out:
            raise DeviceError("no such port")
        return LoosePort(self, super().open_port())


class LoosePort(WrappedPort):
    def __init__(self, rig, port):
        super().__init__(port)
        self.rig = rig

    def __getattr__(self, name):
        if self.rig.out and name in ("in_waiting", "read", "write"):
            raise OSError("device disconnected")
        return super().__getattr__(name)


class DockRig(LooseRig):
    """Before a dock, which stands ahead."""

    def stub_on(self, floor, encoder_counts):
        return SimulatedRoomba(floor, encoder_counts, SimulatedDock(planar(1.5, 0.3, math.pi)))


@pytest.fixture
def loose(opened):
    def build(kind=LooseRig, **settings):
        rig = opened.enter_context(closing(kind(**settings)))
        rig.drive(STOP, 0.3)
        return rig

    return build


@pytest.fixture
def rig(loose):
    return loose()


@pytest.fixture
def seeking(loose):
    """A rig whose base is on the way to its dock."""
    rig = loose(DockRig)
    rig.base.dock()
    rig.drive(STOP, 1.0)
    return rig


def cut(rig, seconds, meanwhile=None):
    """Take the cable out while it drives, and put it back; `meanwhile` says what it feels."""
    rig.out = True
    rig.drive(AHEAD, seconds / 3)
    rig.floor.contacts = meanwhile or Contacts()
    rig.drive(AHEAD, seconds / 3)
    rig.floor.contacts = Contacts()
    rig.drive(AHEAD, seconds / 3)
    rig.out = False


def rolled(rig, seconds):
    """How far the wheels turn while the program asks it to drive ahead [m]."""
    before = rig.floor.wheel_travel[0]
    rig.drive(AHEAD, seconds)
    return rig.floor.wheel_travel[0] - before


@pytest.mark.parametrize("seconds", [0.6, 6.0])
def test_lifted_and_put_down_with_the_cable_out_it_rests_until_somebody_says_go_on(
    rig, seconds, caplog
):
    rig.drive(AHEAD, 0.5)
    cut(rig, seconds, LIFTED)
    assert rolled(rig, 3.0) == 0.0
    state = rig.base.read()
    assert state.maybe_moved and state.mode is BaseMode.PASSIVE
    assert "somebody may have moved it" in caplog.text
    rig.base.resume()
    assert rolled(rig, 0.5) > 0.05
    assert not rig.base.read().maybe_moved


def test_with_resume_safe_it_drives_on_all_the_same(loose):
    rig = loose(resume_safe=True)
    rig.drive(AHEAD, 0.5)
    cut(rig, 6.0, LIFTED)
    assert rolled(rig, 3.0) > 0.1
    assert not rig.base.read().maybe_moved


@pytest.mark.parametrize("seconds", [0.3, 0.6, 6.0])
def test_a_base_that_obeys_as_before_when_its_cable_is_back_was_not_lifted_and_drives_on(
    rig, seconds
):
    rig.drive(AHEAD, 0.5)
    cut(rig, seconds)
    assert rolled(rig, 1.5) > 0.1
    assert not rig.base.read().maybe_moved


def test_in_full_mode_a_lift_leaves_no_trace_and_a_long_silence_is_asked_about(loose):
    brief, long = (loose(full_mode=True) for _ in range(2))
    for rig, seconds, drives in ((brief, 0.6, True), (long, 6.0, False)):
        rig.drive(AHEAD, 0.5)
        cut(rig, seconds)
        assert (rolled(rig, 1.5) > 0.1) == drives
        assert rig.base.read().maybe_moved != drives


def silence(rig, seconds, meanwhile=None, at_the_end=None, twist=STOP):
    """The base sends nothing; what it feels meanwhile, and when it is heard again."""
    with rig.silence():
        rig.drive(twist, seconds / 2)
        rig.floor.contacts = meanwhile or Contacts()
        rig.drive(twist, seconds / 2)
        rig.floor.contacts = at_the_end or Contacts()


@pytest.mark.parametrize(
    ("seconds", "at_the_end", "drives"),
    [
        (0.7, None, True),
        (1.5, None, False),
        (0.7, LIFTED, False),
        (0.7, Contacts(cliffs=(False, True, True, False)), False),
    ],
)
@pytest.mark.parametrize("twist", [STOP, AHEAD])
def test_after_a_start_of_ours_it_drives_on_only_if_it_was_brief_and_nothing_shows(
    rig, seconds, at_the_end, drives, twist
):
    rig.drive(twist, 0.3)
    silence(rig, seconds, at_the_end=at_the_end, twist=twist)
    rig.drive(AHEAD, 0.1)
    rig.floor.contacts = Contacts()
    assert (rolled(rig, 2.0) > 0.1) == drives
    assert rig.base.read().maybe_moved != drives or rig.base.read().mode is BaseMode.PASSIVE


@pytest.mark.parametrize("source", ChargingSources)
def test_a_charger_that_was_plugged_in_unheard_shows_that_somebody_was_there(rig, source):
    silence(rig, 0.7)
    rig.stub.overrides[Packet.CHARGING_SOURCES] = source
    rig.drive(AHEAD, 0.3)
    del rig.stub.overrides[Packet.CHARGING_SOURCES]
    assert rolled(rig, 2.0) == 0.0
    assert rig.base.read().maybe_moved


def test_frames_that_waited_to_be_read_do_not_say_how_a_base_fares_that_was_woken_since(rig):
    publish, rig.stub.publish = rig.stub.publish, lambda: None
    said = []
    send, rig.stub._line.send = rig.stub._line.send, said.append
    for _ in range(40):
        rig.drive(STOP, PERIOD)
        publish()
    rig.stub._line.send = send
    assert rig.stub.mode is BaseMode.PASSIVE  # woken
    for frame in said[:20]:
        send(frame)
    rig.stub.publish = publish
    rig.drive(STOP, 0.5)
    assert rig.base.read().mode is BaseMode.SAFE


def test_a_silence_while_it_is_asked_to_obey_again_is_judged_anew(rig):
    silence(rig, 0.7)
    rig.drive(AHEAD, 2 * PERIOD)
    assert rig.base.read().mode is BaseMode.PASSIVE  # it will be asked in a moment
    silence(rig, 1.5, LIFTED)
    assert rolled(rig, 2.0) == 0.0
    assert rig.base.read().maybe_moved


def test_a_suspended_machine_does_not_know_how_long_it_slept(rig):
    service = rig.base._link._service
    rig.drive(AHEAD, 0.5)
    service.wake()
    rig.stub.mode = BaseMode.PASSIVE  # somebody lifted it meanwhile
    assert rolled(rig, 0.5) < 0.05  # until the port is open again
    assert rolled(rig, 2.0) == 0.0
    assert rig.base.read().maybe_moved


def test_what_cleans_because_its_button_was_pressed_unheard_is_stopped(rig):
    silence(rig, 1.5)
    rig.stub._wheels.turn(200.0, 200.0)  # Clean in Passive mode
    rig.clock.sleep(1.0)
    assert rig.base.read().maybe_moved
    assert rig.floor.speeds == (0.0, 0.0)
    rig.stub._wheels.turn(200.0, 200.0)  # and once more, heard
    rig.clock.sleep(0.5)
    assert rig.floor.speeds == (0.0, 0.0)
    assert rig.stub.mode is BaseMode.PASSIVE


def replaced(rig, last_heard, mode):
    """A service that goes on where another one ended, after the watchdog's stop."""
    before = rig.base._link._service.checkpoint()
    rig.base.close()
    rig.clock.sleep(last_heard)
    rig.stub.mode = mode
    service = RoombaService(rig.open_port, rig.clock.now, RoombaConfig(), before)
    rig.clock.repeat(service.step)
    return service


@pytest.mark.parametrize(
    ("seconds", "contacts", "obeys"), [(0.5, None, True), (1.5, None, False), (0.5, LIFTED, False)]
)
def test_a_service_that_replaces_another_one_decides_by_the_same_rule(
    rig, seconds, contacts, obeys
):
    rig.drive(AHEAD, 0.3)
    service = replaced(rig, seconds, BaseMode.PASSIVE)
    rig.floor.contacts = contacts or Contacts()
    rig.clock.sleep(0.4)
    rig.floor.contacts = Contacts()
    rig.clock.sleep(1.0)
    state = service.checkpoint().state
    assert (state.mode is BaseMode.SAFE) == obeys
    assert state.maybe_moved != obeys
    assert (rig.stub.mode is BaseMode.SAFE) == obeys


@pytest.mark.parametrize(("seconds", "goes_on"), [(0.5, True), (3.0, False)])
def test_the_same_rule_holds_for_a_base_that_sought_its_dock(loose, seconds, goes_on):
    rig = loose(DockRig)
    rig.base.dock()
    rig.drive(STOP, 0.5)
    service = replaced(rig, seconds, BaseMode.PASSIVE)
    assert rig.floor.speeds == (0.0, 0.0)
    for _ in range(100):
        service.execute(Drive(STOP, rig.clock.now()))
        rig.clock.sleep(PERIOD)
    assert service.checkpoint().state.maybe_moved != goes_on
    assert (rig.floor.speeds != (0.0, 0.0)) == goes_on


def test_a_base_that_rests_until_somebody_says_go_on_does_so_under_the_next_service(rig):
    silence(rig, 1.5)
    rig.drive(AHEAD, 0.3)
    assert rig.base.read().maybe_moved
    service = replaced(rig, 0.4, BaseMode.PASSIVE)
    rig.clock.sleep(1.0)
    assert service.checkpoint().state.maybe_moved
    assert rig.stub.mode is BaseMode.PASSIVE


def test_a_program_that_hangs_while_the_base_seeks_its_dock_has_it_stopped_in_safe_mode(seeking):
    assert seeking.floor.speeds != (0.0, 0.0) and seeking.stub.mode is BaseMode.PASSIVE
    began = seeking.clock.now()
    while seeking.floor.speeds != (0.0, 0.0):
        seeking.clock.sleep(PERIOD)
        assert seeking.clock.now() - began < 0.3 + 3 * PERIOD
    before = seeking.floor.wheel_travel
    seeking.clock.sleep(3.0)
    assert seeking.floor.wheel_travel == before
    assert seeking.stub.mode is BaseMode.SAFE
    seeking.drive(STOP, 1.0)  # it goes on, and so does what it asked for
    assert seeking.floor.speeds != (0.0, 0.0)


@pytest.mark.slow
def test_on_its_dock_a_base_charges_on_without_any_order(loose):
    rig = loose(DockRig)
    rig.base.dock()
    rig.drive(STOP, 40.0)
    assert rig.base.read().docked
    rig.clock.sleep(5.0)
    assert rig.stub.mode is BaseMode.PASSIVE


@pytest.mark.parametrize(("seconds", "seeks"), [(0.7, True), (2.0, False)])
def test_silence_while_the_base_seeks_its_dock_stops_it_and_the_same_rule_says_what_follows(
    seeking, seconds, seeks
):
    with seeking.silence():
        seeking.drive(STOP, 0.3)
        assert seeking.floor.speeds == (0.0, 0.0)
        before = seeking.floor.wheel_travel
        seeking.drive(STOP, seconds - 0.3)
        assert seeking.floor.wheel_travel == before
    seeking.drive(STOP, 1.0)
    assert (seeking.floor.speeds != (0.0, 0.0)) == seeks
    assert seeking.base.read().maybe_moved != seeks


def test_a_cable_that_was_out_while_the_base_sought_its_dock_has_it_stopped_first(seeking):
    seeking.out = True
    seeking.drive(STOP, 2.0)
    assert seeking.floor.speeds != (0.0, 0.0)  # no command reaches it
    seeking.out = False
    seeking.drive(STOP, 0.45)
    assert seeking.floor.speeds == (0.0, 0.0)
    seeking.drive(STOP, 0.5)
    assert seeking.base.read().maybe_moved


def test_the_first_command_once_the_cable_is_back_stops_the_wheels(rig):
    rig.drive(AHEAD, 0.5)
    rig.out = True
    with pytest.raises(DeviceTimeoutError):
        while True:
            rig.drive(AHEAD, PERIOD)
            rig.base.read()
    rig.out = False
    sent = []
    opened = rig.open_port

    def listened():
        port = opened()
        port.write = lambda data, write=port.write: (sent.append(data), write(data))[1]
        return port

    rig.base._link._service._open_port = listened
    while not sent:
        rig.drive(AHEAD, PERIOD)
    assert sent[0].startswith(SURE_STOP)
