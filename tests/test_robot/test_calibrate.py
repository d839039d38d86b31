"""The calibration drive, on a simulated robot whose dimensions the robot does not know."""

import io
import tomllib
from dataclasses import replace

import numpy as np
import pytest

from mapping.calibration.config import CalibrationConfig, ResidualsConfig
from sim_stubs.world.world import World
from tests.helpers.failing import raising
from vizbot.calibration.drive import Leg, Sample, record
from vizbot.calibration.solve import Calibration, solve
from vizbot.commands.calibrate import run, updated
from vizbot.commands.options import CalibrateOptions
from vizbot.config import Config, MountConfig, load_config
from vizbot.core.errors import ConfigError, DeviceError
from vizbot.core.types import PoseEstimate, Tracking, Twist
from vizbot.rehearsal.config import RehearsalConfig
from vizbot.rehearsal.rig import Rig

OFFSET = 0.01
"""How far off the camera's place on the base may be found, ahead and to the left [m]."""


def wrong_robot(seed: int) -> tuple[Config, Config]:
    """A world whose robot has dimensions of its own, and what that robot believes."""
    rng = np.random.default_rng(seed)
    mount = {
        "height": rng.uniform(0.45, 0.69),
        "forward": rng.uniform(-0.10, 0.12),
        "left": rng.uniform(-0.06, 0.06),
        "tilt": rng.uniform(0.05, 0.35),
        "yaw": rng.uniform(-0.12, 0.12),
        "roll": rng.uniform(-0.05, 0.05),
    }
    wheels = {"wheel_base": rng.uniform(0.215, 0.26), "wheel_scale": rng.uniform(0.95, 1.05)}
    belief = {"wheel_base": rng.uniform(0.225, 0.245), "wheel_scale": rng.uniform(0.97, 1.03)}
    world = wheels | {"wheel_scale_noise": 0.0}
    simulated = Config.model_validate({"mount": mount, "world": world, "roomba": belief})
    return simulated, Config.model_validate({"roomba": belief})


def on_free_floor(world: World, seed: int) -> None:
    """Put the robot where 2 m ahead of it are free, as README.md asks."""
    rng, (free, grid) = np.random.default_rng((seed, 1)), world.free
    along = np.linspace(0.0, 1.85, 60)
    rows_columns = np.argwhere(free)
    while True:
        x, y = grid.pixels_to_xy(rng.choice(rows_columns)[::-1].astype(float))
        yaw = rng.uniform(-np.pi, np.pi)
        cells = [grid.cell_of(x + s * np.cos(yaw), y + s * np.sin(yaw)) for s in along]
        if all(cell is not None and free[cell] for cell in cells):
            world.place(x, y, yaw)
            return


@pytest.mark.long
@pytest.mark.parametrize(
    ("seed", "home"),
    [(300, "30"), (301, "31"), (302, "32"), (303, "33"), (304, "34")],
)
def test_wheels_and_mount_are_found_from_what_the_robot_sees(seed, home):
    simulated, believed = wrong_robot(seed)
    legs = []
    with Rig(simulated, "sim", "sim", home) as rig:
        on_free_floor(rig.world, seed)
        samples = record(rig.devices, believed, legs.append)
        true_bias = rig.devices.camera._inertial._gyro_bias
    assert legs == list(Leg)
    found, mount = solve(samples, believed), simulated.mount
    body = RehearsalConfig.read(simulated).world
    assert found.wheel_base == pytest.approx(body.wheel_base, rel=0.01)
    assert found.wheel_scale == pytest.approx(body.wheel_scale, rel=0.01)
    assert found.mount.height == pytest.approx(mount.height, rel=0.01)
    for angle in ("tilt", "yaw", "roll"):
        wanted = getattr(mount, angle)
        assert getattr(found.mount, angle) == pytest.approx(wanted, abs=np.radians(0.5)), angle
    for offset in ("forward", "left"):
        wanted = getattr(mount, offset)
        assert getattr(found.mount, offset) == pytest.approx(wanted, abs=OFFSET), offset
    residuals = found.calibration.residuals
    assert all(0.0 <= residual < 0.02 for _, residual in residuals)
    error = np.subtract(found.calibration.gyro_bias, true_bias)
    assert np.linalg.norm(error) < 4 * residuals.gyro_bias
    with pytest.raises(DeviceError) as refusal:
        solve([counted_twice(sample) for sample in samples], believed)
    line = str(refusal.value)
    assert "\n" not in line and "wheel_base = 0.1" in line and "at least 0.15, in metres" in line
    assert "wheel_scale = 0." in line and "at least 0.8" in line and "calibrate on open" in line


def counted_twice(sample: Sample) -> Sample:
    """The sample of wheels that slip: they count twice the way."""
    T_odom_base = sample.T_odom_base.copy()
    T_odom_base[:2, 3] *= 2.0
    return replace(sample, T_odom_base=T_odom_base)


@pytest.mark.slow
def test_it_stops_where_something_is_in_its_way(monkeypatch):
    config, ahead = Config(), {Leg.AHEAD: (Twist(0.25, 0.0), 10.0)}
    monkeypatch.setattr("vizbot.calibration.drive._DRIVE", ahead)
    monkeypatch.setattr("vizbot.calibration.drive._REST", 0.3)
    with Rig(config, "sim", "sim", "3") as rig:
        with pytest.raises(DeviceError, match="something in its way; put the robot where 2 m"):
            record(rig.devices, config, lambda _: None)
        rig.devices.clock.sleep(0.5)
        at_rest = rig.devices.base.read().T_odom_base
        rig.devices.clock.sleep(0.5)
        assert np.array_equal(rig.devices.base.read().T_odom_base, at_rest)


@pytest.mark.slow
def test_it_drives_back_no_farther_than_it_went_ahead(monkeypatch):
    legs = {Leg.AHEAD: (Twist(0.15, 0.0), 2.0), Leg.BACK: (Twist(-0.15, 0.0), 10.0)}
    monkeypatch.setattr("vizbot.calibration.drive._DRIVE", legs)
    monkeypatch.setattr("vizbot.calibration.drive._REST", 0.3)
    config = Config()
    with Rig(config, "sim", "sim", "30") as rig:
        on_free_floor(rig.world, 1)
        samples = record(rig.devices, config, lambda _: None)
        start = next(s for s in samples if s.leg is Leg.AHEAD).T_odom_base
        rig.devices.clock.sleep(0.5)
        end = rig.devices.base.read().T_odom_base
    there = [(np.linalg.inv(start) @ s.T_odom_base)[0, 3] for s in samples]
    assert max(there) > 0.25
    assert -0.1 < (np.linalg.inv(start) @ end)[0, 3] < 0.02


FOUND = Calibration(
    MountConfig(height=0.6, forward=0.04, tilt=0.1),
    0.24,
    1.01,
    CalibrationConfig(
        date="2026-01-02", gyro_bias=(0.0, 0.1, 0.2), residuals=ResidualsConfig(axle=0.001)
    ),
)


def test_the_settings_keep_their_comments_and_all_else(tmp_path):
    path = tmp_path / "robot.toml"
    path.write_text(
        '# my robot\nserial_port = "/dev/ttyUSB7"  # the blue cable\n\n'
        "[mount]  # by ruler\nheight = 0.5\n\n[roomba]\nresume_safe = true\n"
    )
    text = updated(path, FOUND)
    for kept in ("# my robot", "# the blue cable", "# by ruler", "resume_safe = true"):
        assert kept in text
    path.write_text(text)
    config = load_config(path)
    assert config.serial_port == "/dev/ttyUSB7" and config.roomba.resume_safe
    assert config.mount == FOUND.mount and config.calibration == FOUND.calibration
    assert (config.roomba.wheel_base, config.roomba.wheel_scale) == (0.24, 1.01)


def test_nothing_of_an_older_calibration_stays_under_a_new_date(tmp_path):
    path = tmp_path / "robot.toml"
    path.write_text(
        '[calibration]  # mine\ndate = "2025-01-01"\ngyro_bias = [0.1, 0.2, 0.3]\n\n'
        "[calibration.residuals]\nheight = 0.5\n\n[roomba]  # the old one\nresume_safe = true\n"
    )
    now = replace(FOUND, calibration=CalibrationConfig(date="2026-01-02"))
    text = updated(path, now)
    path.write_text(text)
    assert load_config(path).calibration == now.calibration
    assert "gyro_bias" not in tomllib.loads(text)["calibration"]
    assert "# the old one" in text


@pytest.mark.parametrize(
    ("bias", "becomes"), [(0.05, "read 0.050 rad/s .* still"), (0.02, "images showed")]
)
def test_a_gyroscope_that_read_more_than_any_bias_at_rest_is_refused(bias, becomes):
    where = PoseEstimate(0.0, np.eye(4), 0, np.eye(4), False, Tracking.TRACKING)
    resting = Sample(Leg.REST, where, np.eye(4), np.tile([0.0, bias, 0.0], (9, 1)), None)
    with pytest.raises(DeviceError, match=becomes):
        solve([resting] * 20, Config())


def test_settings_are_made_where_there_are_none():
    assert tomllib.loads(updated(None, FOUND))["calibration"]["date"] == "2026-01-02"


@pytest.mark.parametrize(
    ("typed", "becomes"), [("", "nobody confirmed .* use --yes"), ("\n", "the devices are opened")]
)
def test_a_real_base_is_driven_only_once_somebody_has_confirmed_it(
    monkeypatch, capsys, typed, becomes
):
    monkeypatch.setattr(
        "vizbot.commands.calibrate.opened_devices", raising(ConfigError("the devices are opened"))
    )
    monkeypatch.setattr("vizbot.commands.calibrate.require_devices", lambda *plugged_in: None)
    monkeypatch.setattr("sys.stdin", io.StringIO(typed))
    with pytest.raises(ConfigError, match=becomes):
        run(CalibrateOptions())
    assert "2 m ahead must be free" in capsys.readouterr().out
