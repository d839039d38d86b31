"""One device is real, the other simulated."""

import numpy as np
import pytest

from drivers.realsense import camera as realsense
from drivers.realsense.camera import RealSense
from drivers.realsense.config import RealSenseConfig
from drivers.roomba import serial_port
from drivers.roomba.serial_port import SerialAddress
from sim_stubs.realsense.software_device import SoftwareD435i
from sim_stubs.world.body import Contacts
from tests.helpers.d435i_frames import streaming
from vizbot.config import Config
from vizbot.core.geometry import planar
from vizbot.core.types import BaseMode, BaseState, Twist
from vizbot.rehearsal.mixed_devices import FollowedBase
from vizbot.rehearsal.rig import Rig
from vizbot.rig import open_base


class Wall:
    """A world whose robot starts 1 m before a wall, at the left of which it bumps."""

    def __init__(self):
        self.T_world_base = planar(2.0, 0.0, np.pi / 2)

    def place(self, x, y, yaw):
        self.T_world_base = planar(x, y, yaw)

    @property
    def contacts(self):
        return Contacts(bump_left=self.T_world_base[1, 3] >= 1.0)


class Wheels:
    """A base that says how far it has gone, and touches nothing."""

    way = 0.0

    def read(self):
        nothing = (False, False, False, False), (False, False)
        odometry = planar(self.way, 0.0, 0.0)
        return BaseState(0.0, odometry, False, False, *nothing, 1.0, BaseMode.SAFE)


def test_a_real_base_bumps_into_what_is_simulated(caplog):
    wheels, wall = Wheels(), Wall()
    base = FollowedBase(wheels, wall)
    wheels.way = 0.9
    assert not base.read().bumped
    assert "simulated contact" not in caplog.text
    wheels.way = 1.1
    state = base.read()
    assert (state.bump_left, state.bump_right) == (True, False)
    np.testing.assert_allclose(wall.T_world_base, planar(2.0, 1.1, np.pi / 2), atol=1e-12)
    assert base.read().bump_left
    [told] = [each for each in caplog.records if "simulated contact" in each.message]
    assert told.levelname == "WARNING" and "keep 1 m around it free" in told.message


@pytest.fixture
def plugged_in(monkeypatch):
    """A D435i that streams."""
    device = SoftwareD435i()
    context = device.plug_in()
    monkeypatch.setattr(
        realsense, "RealSense", lambda config, clock: RealSense(config, clock, context)
    )
    with streaming(device):
        yield


def test_a_real_camera_goes_with_a_simulated_base(plugged_in):
    config = Config(realsense=RealSenseConfig(imu=False))
    with Rig(config, "realsense", "sim", "0") as devices:
        frame = devices.devices.camera.read(timeout=5.0)
        assert frame.depth.shape == (480, 640)
        assert len(frame.imu.gyro_stamps) == 0
        devices.devices.base.drive(Twist(0.0, 0.0))
        assert devices.devices.base.read().mode is BaseMode.SAFE


def test_a_base_that_is_plugged_in_elsewhere_is_looked_for_by_its_identity(monkeypatch):
    addresses = []

    def link(open_port, config):
        addresses.append(open_port.__self__)
        raise serial_port.DeviceError("no base here")

    monkeypatch.setattr("drivers.roomba.reflex_process.process_link.ProcessLink", link)
    with pytest.raises(serial_port.DeviceError):
        open_base(Config(serial_port="/dev/ttyUSB9"), None, None)
    assert [type(address) for address in addresses] == [SerialAddress]
