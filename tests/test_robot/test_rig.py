import time

import numpy as np
import pytest

from drivers.roomba.config import RoombaConfig
from sim_stubs.roomba.base import SimulatedRoomba, on_wall_clock
from sim_stubs.world.body import FreeFloor
from sim_stubs.world.world import World
from vizbot.config import Config
from vizbot.core.errors import ConfigError
from vizbot.core.types import BaseMode, Twist
from vizbot.rehearsal.config import RehearsalConfig
from vizbot.rehearsal.rig import Rig
from vizbot.rig import open_encoder

pytestmark = pytest.mark.slow

DEADLINE = 20.0


@pytest.fixture
def roomba_port():
    """Port of a Roomba that runs on the wall clock, as a real one does."""
    with on_wall_clock(SimulatedRoomba(FreeFloor())) as stub:
        yield stub.path


def test_simulated_devices_share_one_world_and_one_clock():
    config, rate = Config(), RehearsalConfig().sim_camera.rate
    with Rig(config, "sim", "sim", "0") as rig:
        devices = rig.devices
        first = devices.camera.read()
        start = rig.world.T_world_base
        for _ in range(5):
            devices.base.drive(Twist(0.0, 1.0))
            frame = devices.camera.read()
        assert devices.base.read().mode is BaseMode.SAFE
        assert frame.stamp - first.stamp == pytest.approx(5 / rate, abs=0.016)
        turned = np.linalg.inv(start) @ rig.world.T_world_base
        believed = devices.base.read().T_odom_base
        np.testing.assert_allclose(believed[:2, :2], turned[:2, :2], atol=0.03)
        assert frame.depth.shape == frame.rgb.shape[:2] == (480, 640)


def test_a_world_follows_the_encoders_of_a_base_on_a_real_port(roomba_port):
    # Threads that this machine keeps from running for a moment are no silent base.
    patient = RoombaConfig(silence_timeout=0.5)
    config = Config(serial_port=roomba_port, roomba=patient)
    with Rig(config, "sim", "roomba", "0") as rig:
        start = rig.world.T_world_base
        end = time.monotonic() + DEADLINE
        moved = np.eye(4)
        while abs(moved[1, 0]) < 0.1 and time.monotonic() < end:
            rig.devices.base.drive(Twist(0.0, 1.0))
            state = rig.devices.base.read()
            moved = np.linalg.inv(start) @ rig.world.T_world_base
        np.testing.assert_allclose(moved, state.T_odom_base, atol=1e-9)
        assert moved[1, 0] >= 0.1
        # A gyroscope in the world does not feel the real base turn.
        assert len(rig.devices.camera.read().imu.gyro_stamps) == 0


def test_without_a_base_the_world_stands_still():
    with Rig(Config(), "sim", "none", "0") as rig:
        assert rig.devices.base is None
        start = rig.world.T_world_base
        rig.devices.camera.read()
        np.testing.assert_array_equal(rig.world.T_world_base, start)


def test_what_fails_half_way_leaves_nothing_open(monkeypatch):
    closed = []
    close = World.close

    def close_and_tell(world):
        close(world)
        closed.append(world)

    monkeypatch.setattr(World, "close", close_and_tell)
    with pytest.raises(ConfigError):
        Rig(Config(), "sim", "submarine", "0")
    assert closed == []
    with pytest.raises(Exception, match="/dev/ttyNOTHING"):
        Rig(Config(serial_port="/dev/ttyNOTHING"), "sim", "roomba", "0")
    assert len(closed) == 1


def test_the_default_encoder_says_that_it_is_for_rehearsal():
    encoder = open_encoder("embedded", "cpu")
    assert encoder.notice == "rehearsal model, trained on simulated homes"
    assert open_encoder(encoder.model_id, "cpu").model_id == encoder.model_id
    with pytest.raises(ConfigError, match="embedded-00000000"):
        open_encoder("embedded-00000000", "cpu")
