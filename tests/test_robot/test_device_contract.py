"""One set of tests for every `Camera` and every `Base`, real or simulated.

`pytest -m hardware` runs them with a RealSense that looks at a room and a Roomba (the port in
`VIZBOT_PORT`, else the first on USB) with half a metre of free floor around it: it drives.
"""

import os

import cv2
import numpy as np
import pytest
from serial.tools.list_ports import comports

from drivers.realsense.camera import RealSense
from drivers.realsense.config import RealSenseConfig
from drivers.realsense.playback import RealSenseRecording
from drivers.roomba.base import Roomba
from drivers.roomba.config import RoombaConfig
from drivers.roomba.reflex_process.process_link import ProcessLink
from drivers.roomba.serial_port import SerialAddress, open_serial
from drivers.tum_sequence import RecordedSequence
from sim_stubs.realsense.camera import SimulatedRealSense
from sim_stubs.realsense.config import SimulatedRealSenseConfig
from sim_stubs.realsense.software_device import SoftwareD435i
from sim_stubs.roomba.base import SimulatedRoomba, on_wall_clock
from sim_stubs.world.body import FreeFloor, WorldConfig
from sim_stubs.world.world_name import open_world
from tests.helpers.d435i_frames import streaming
from tests.helpers.roomba_rig import open_lockstep
from vizbot.config import Config
from vizbot.core.clock import WallClock
from vizbot.core.errors import DeviceError
from vizbot.core.geometry import yaw_of
from vizbot.core.simulated_clock import SimulatedClock
from vizbot.core.types import STOP, BaseMode, Intrinsics, Twist


def simulated_camera(opened, tmp_path):
    world = opened.enter_context(open_world("0", WorldConfig()))
    return SimulatedRealSense(world, SimulatedClock(), SimulatedRealSenseConfig())


def recorded_folder(opened, tmp_path):
    (tmp_path / "rgb").mkdir()
    (tmp_path / "depth").mkdir()
    lines = []
    for i in range(3):
        cv2.imwrite(str(tmp_path / "rgb" / f"{i}.png"), np.full((48, 64, 3), i, np.uint8))
        cv2.imwrite(str(tmp_path / "depth" / f"{i}.png"), np.full((48, 64), 1500, np.uint16))
        lines.append(f"{i}.0 rgb/{i}.png {i}.0 depth/{i}.png\n")
    (tmp_path / "associations.txt").write_text("".join(lines))
    return RecordedSequence(tmp_path, Intrinsics(64, 48, 60.0, 60.0, 31.5, 23.5), 1000.0)


def sdk_recording(opened, tmp_path):
    device = SoftwareD435i()
    with device.record(tmp_path / "walk.db3"):
        for i in range(4):
            colour = np.full((480, 640, 3), 10 * i, np.uint8)
            device.push_frame(colour, np.full((480, 640), 1500, np.uint16), 1.7e9 + i / 30)
    return RealSenseRecording(RealSenseConfig(imu=False), tmp_path / "walk.db3")


def software_camera(opened, tmp_path):
    device = SoftwareD435i()
    camera = RealSense(RealSenseConfig(imu=False), WallClock(), device.plug_in())
    opened.enter_context(streaming(device))
    return camera


def real_camera(opened, tmp_path):
    return RealSense(RealSenseConfig(), WallClock())


@pytest.mark.parametrize(
    "open_camera",
    [
        simulated_camera,
        recorded_folder,
        sdk_recording,
        software_camera,
        pytest.param(real_camera, marks=pytest.mark.hardware),
    ],
)
def test_a_camera_keeps_its_promises(open_camera, opened, tmp_path):
    camera = opened.enter_context(open_camera(opened, tmp_path))
    frames = [camera.read(timeout=5.0) for _ in range(3)]
    for frame in frames:
        camera_size = (camera.intrinsics.height, camera.intrinsics.width)
        assert frame.intrinsics == camera.intrinsics
        assert frame.rgb.dtype == np.uint8 and frame.rgb.shape == (*camera_size, 3)
        assert frame.depth.dtype == np.float32 and frame.depth.shape == camera_size
        assert (frame.depth >= 0.0).all() and 0.2 < np.median(frame.depth) < 10.0
        assert frame.imu.gyro.shape == (len(frame.imu.gyro_stamps), 3)
        assert frame.imu.accel.shape == (len(frame.imu.accel_stamps), 3)
    stamps = [frame.stamp for frame in frames]
    assert stamps == sorted(set(stamps))
    camera.close()
    camera.close()
    with pytest.raises(DeviceError, match="closed"):
        camera.read()


def lockstep_base(opened):
    clock = SimulatedClock()
    stub = opened.enter_context(SimulatedRoomba(FreeFloor()))
    clock.attach(stub)
    return open_lockstep(lambda: stub.lockstep_port(open_serial(stub.path)), clock), clock


def base_on_a_real_port(opened):
    stub = opened.enter_context(on_wall_clock(SimulatedRoomba(FreeFloor())))
    clock, config = WallClock(), RoombaConfig(silence_timeout=0.5)
    return Roomba(ProcessLink(SerialAddress(stub.path).open, config), clock, config), clock


def real_base(opened):
    ports = [os.environ.get("VIZBOT_PORT"), *(port.device for port in comports() if port.vid)]
    path = next((port for port in ports if port), Config().serial_port)
    clock, config = WallClock(), RoombaConfig()
    return Roomba(ProcessLink(SerialAddress(path).open, config), clock, config), clock


@pytest.mark.parametrize(
    "open_base",
    [lockstep_base, base_on_a_real_port, pytest.param(real_base, marks=pytest.mark.hardware)],
)
def test_a_base_keeps_its_promises(open_base, opened):
    base, clock = open_base(opened)
    opened.callback(base.close)
    state = base.read()
    assert state.mode is BaseMode.SAFE
    assert not state.bumped and not any(state.cliffs) and not any(state.wheel_drops)
    assert state.battery is not None and 0.0 < state.battery <= 1.0
    np.testing.assert_allclose(state.T_odom_base, np.eye(4), atol=1e-6)
    for _ in range(25):
        base.drive(Twist(0.1, 0.5))
        clock.sleep(0.02)
    moving = base.read()
    assert moving.stamp > state.stamp
    assert moving.T_odom_base[0, 3] > 0.02 and yaw_of(moving.T_odom_base) > 0.1
    base.drive(STOP)
    clock.sleep(0.3)
    rest = base.read().T_odom_base
    clock.sleep(0.2)
    np.testing.assert_array_equal(base.read().T_odom_base, rest)
    base.close()
    base.close()
    with pytest.raises(DeviceError):
        base.read()
    with pytest.raises(DeviceError):
        base.drive(STOP)
