"""What the robot does while its devices are silent or lie about the time."""

from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from vizbot.core.errors import DeviceTimeoutError
from vizbot.core.geometry import camera_mount
from vizbot.core.interfaces import Devices
from vizbot.core.simulated_clock import SimulatedClock
from vizbot.core.types import STOP, BaseMode, BaseState, Button, ImuSamples, RGBDFrame
from vizbot.perception.sensor_reader import SensorReader

PERIOD = 0.3


@dataclass
class ScriptedCamera:
    """Gives a frame every PERIOD; `silent` reads time out."""

    clock: SimulatedClock
    silent: int = 0

    def read(self, timeout=1.0):
        if self.silent:
            self.silent -= 1
            self.clock.sleep(timeout)
            raise DeviceTimeoutError("camera 1: no frame within 1 s; check its cable")
        self.clock.sleep(PERIOD)
        stamp = self.clock.now()
        stamps = np.array([stamp - 0.1, stamp])
        imu = ImuSamples(stamps, np.zeros((2, 3)), stamps, np.zeros((2, 3)))
        depth = np.full((24, 32), 2.0, np.float32)
        return RGBDFrame(stamp, np.zeros((24, 32, 3), np.uint8), depth, None, imu)


@dataclass
class ScriptedBase:
    driven: list = field(default_factory=list)
    states: list = field(default_factory=list)

    def drive(self, twist):
        self.driven.append(twist)

    def read(self):
        state = self.states.pop(0) if self.states else {}
        if state is None:
            raise DeviceTimeoutError("no answer from the base")
        rest = BaseState(0.0, np.eye(4), False, False, (False,) * 4, (False,) * 2, 1.0,
                         BaseMode.SAFE)  # fmt: skip
        return replace(rest, **state)


@pytest.fixture
def parts():
    clock = SimulatedClock()
    camera, base = ScriptedCamera(clock), ScriptedBase()
    devices = Devices(clock, camera, base, camera_mount(0.6, 0.05, 0.15), False)
    return SensorReader(devices, camera_patience=10.0, base_patience=10.0), camera, base


def test_a_camera_that_is_silent_is_waited_for_with_the_wheels_told_to_rest(parts, caplog):
    reader, camera, base = parts
    reader.next()
    camera.silent = 3
    assert reader.next().frame is not None
    assert base.driven == [STOP] * 3
    assert "no frame within 1 s" in caplog.text
    assert "sees again after 2.3 s" in caplog.text


def test_it_is_not_waited_for_for_ever(parts):
    reader, camera, _ = parts
    camera.silent = 100
    with pytest.raises(DeviceTimeoutError, match="check its cable"):
        reader.next()
    assert camera.clock.now() == pytest.approx(11.0, abs=1.1)


def test_a_recording_that_is_silent_is_an_error_at_once():
    clock = SimulatedClock()
    camera = ScriptedCamera(clock, silent=1)
    reader = SensorReader(
        Devices(clock, camera, None, None, True), camera_patience=10.0, base_patience=10.0
    )
    with pytest.raises(DeviceTimeoutError):
        reader.next()


@pytest.mark.parametrize(
    "wheel_drops", [(False, False), (True, True)], ids=["on the floor", "lifted"]
)
def test_who_presses_clean_to_wake_the_base_does_not_end_the_search(parts, wheel_drops):
    reader, _, base = parts
    pressed = {"buttons": frozenset({Button.CLEAN})}
    asleep = {"mode": BaseMode.PASSIVE, "wheel_drops": wheel_drops, **pressed}
    base.states = [{}, None, None, asleep, pressed, {}]
    assert reader.next().state.buttons == frozenset()
    woken = reader.next().state
    assert (woken.buttons, woken.wheel_drops) == (frozenset(), wheel_drops)
    assert reader.next().state.buttons == frozenset()
    base.states = [pressed]
    assert reader.next().state.buttons == pressed["buttons"]


@pytest.mark.parametrize(
    "contact",
    [
        {"wheel_drops": (True, False)},
        {"cliffs": (False, True, False, False)},
        {"bump_left": True},
    ],
)
def test_what_a_base_that_was_silent_feels_is_told_at_once(parts, contact):
    reader, _, base = parts
    base.states = [{}, None, {"mode": BaseMode.PASSIVE, **contact}]
    reader.next()
    state = reader.next().state
    assert {name: getattr(state, name) for name in contact} == contact
    assert state.mode is BaseMode.PASSIVE
