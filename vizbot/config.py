"""The settings of all parts in one model, read from TOML and written as TOML."""

from __future__ import annotations

import logging
import re
import tomllib
from pathlib import Path
from typing import Any, Self

import tomlkit
from pydantic import Field, ValidationError, field_validator, model_validator

from drivers.realsense.config import RealSenseConfig
from drivers.roomba.config import RoombaConfig
from mapping.calibration.config import CalibrationConfig
from mapping.clip.config import ClipMapperConfig
from mapping.occupancy.config import DepthMapperConfig
from mapping.relocalisation.config import LocalMapConfig
from mapping.slam.config import SlamConfig
from nav.config import FrontierConfig, NavigatorConfig, Reach, RecoveryConfig
from vizbot.core.errors import ConfigError
from vizbot.core.files import read_regular, write_whole
from vizbot.core.geometry import camera_mount
from vizbot.core.method import Method
from vizbot.core.renamed_settings import with_names_of_today
from vizbot.core.settings import BASIC, Settings, explained
from vizbot.core.types import SE3

_log = logging.getLogger(__name__)
_LARGEST = 1024 * 1024
"""Size of a settings file that is read [bytes]."""


class MountConfig(Settings):
    """Pose of the camera on the robot, real or simulated."""

    height: float = Field(default=0.60, ge=0.1, le=2.0, json_schema_extra=BASIC)
    """The optical centre is this high above the floor [m]."""
    forward: float = Field(default=0.05, ge=-0.5, le=0.5, json_schema_extra=BASIC)
    """The optical centre is this far ahead of the wheel axle [m]."""
    tilt: float = Field(default=0.15, gt=-1.4, lt=1.4, json_schema_extra=BASIC)
    """The camera looks down from the horizontal by this angle [rad]."""
    left: float = Field(default=0.0, ge=-0.5, le=0.5, json_schema_extra=BASIC)
    """The optical centre is this far to the left of the middle of the axle [m]."""
    yaw: float = Field(default=0.0, gt=-1.6, lt=1.6, json_schema_extra=BASIC)
    """The camera looks to the left of the base's heading by this angle [rad]."""
    roll: float = Field(default=0.0, gt=-0.5, lt=0.5, json_schema_extra=BASIC)
    """The camera is rolled about its optical axis by this, positive with its right side low
    [rad]."""

    @property
    def T_base_cam(self) -> SE3:
        """Where the camera is in `base`."""
        return camera_mount(self.height, self.forward, self.tilt, self.left, self.yaw, self.roll)


class GyroSettlingConfig(Settings):
    """Standstill at the start, to learn the gyroscope's bias."""

    seconds: float = Field(default=2.0, ge=0.0, le=600.0)
    """The robot stands still for at least this time before it first moves [s]."""
    frames: int = Field(default=5, ge=0, le=10_000)
    """The robot stands still for at least this number of frames before it first moves [1]."""


class BeliefSearchConfig(Settings):
    """Thresholds of belief, and the worth of what to do next."""

    arrival_probability_early: float = Field(default=0.8, gt=0.0, lt=1.0, json_schema_extra=BASIC)
    """Early in a search for a thing, and in a search for a room until nothing is left to see, the
    robot says that it has arrived from this probability on [1]."""
    arrival_probability_late: float = Field(default=0.6, gt=0.0, lt=1.0, json_schema_extra=BASIC)
    """Late in a search for a thing, the robot says it has arrived from this probability on [1]."""
    arrival_probability_last: float = Field(default=0.4, gt=0.0, lt=1.0, json_schema_extra=BASIC)
    """When nothing is left to see, and after twice `late_after_steps`, the robot says that it has
    arrived from this probability on [1]."""
    late_after_steps: int = Field(default=300, ge=1, le=1_000_000, json_schema_extra=BASIC)
    """A search is late after this number of steps [1]."""
    candidate_probability: float = Field(default=0.25, gt=0.0, lt=1.0)
    """A place with less than this probability is mostly left until nothing better is to be done,
    since a look at it is worth less by the square of its share of this [1]."""
    finding_density: float = Field(default=0.015, ge=1e-6, le=10.0)
    """A square metre not seen yet is expected to show what is asked for with this probability,
    where nothing is known about it [1/m^2]."""
    min_probability_per_metre: float = Field(default=0.005, ge=0.0, le=10.0)
    """A search ends as not found where nothing has more than this probability for each metre of
    way; the limit rises to this from 0 between `late_after_steps` and twice that [1/m]."""
    vertical_field_of_view: float = Field(default=0.73, ge=0.1, le=3.1)
    """The camera sees this angle vertically, somewhat less than in truth; by it and the mount the
    robot stops where a thing is in the picture [rad]."""


class ObjectNavConfig(Settings):
    """Search for a thing or a room, and its limits."""

    method: Method = Field(default="belief", json_schema_extra=BASIC)
    """The robot searches by this method: `belief` compares all that can be done next by the
    probabilities of places; `paper` is the paper's Algorithm 1, and of these settings takes
    `threshold`, `gyro_settling` and `max_steps` alone."""
    search: BeliefSearchConfig = BeliefSearchConfig()
    answer_probability: float = Field(default=0.5, gt=0.0, lt=1.0, json_schema_extra=BASIC)
    """A place on the map answers a question when its probability is above this [1]."""
    threshold: float | None = Field(default=None, gt=0.0, lt=1.0, json_schema_extra=BASIC)
    """An element is the goal (theta) when its similarity is above this, by the method `paper`; None
    takes the encoder's own threshold [1]."""
    gyro_settling: GyroSettlingConfig = GyroSettlingConfig()
    waypoint_reaches: tuple[Reach, ...] = Field(
        default=(Reach(distance=0.25, extent=0.05), Reach(distance=0.8, extent=0.05)), min_length=1
    )
    """A robot that is sent to a place drives as near to it as the first entry that it can reach."""
    max_steps: int = Field(default=1000, ge=1, le=1_000_000, json_schema_extra=BASIC)
    """The robot gives up a goal after this number of steps (paper, section IV-C) [1]."""
    max_exploration_steps: int = Field(default=3000, ge=1, le=1_000_000, json_schema_extra=BASIC)
    """The robot gives up an exploration without a goal after this number of steps [1]."""
    look_around: bool = Field(default=True, json_schema_extra=BASIC)
    """This says whether the robot turns once on the spot before the first goal."""
    look_around_rate: float = Field(default=1.3, ge=0.05, le=4.3, json_schema_extra=BASIC)
    """The robot turns at this rate on the spot before the first goal [rad/s]."""
    recognising_rate: float = Field(default=0.5, ge=0.05, le=4.3)
    """A robot that is lost turns at this rate, which is low for sharp images [rad/s]."""


class DockingConfig(Settings):
    """Driving onto the dock."""

    search_distance: float = Field(default=0.8, ge=0.2, le=3.0, json_schema_extra=BASIC)
    """The base begins to look for the contacts by itself at this distance from the dock [m]."""
    contact_timeout: float = Field(default=90.0, ge=5.0, le=3600.0, json_schema_extra=BASIC)
    """The base has this time to find the contacts [s]."""


class PerceptionConfig(Settings):
    """Maps made of frames."""

    slam: SlamConfig = SlamConfig()
    depth_mapper: DepthMapperConfig = DepthMapperConfig()
    local_map: LocalMapConfig = LocalMapConfig()
    clip_mapper: ClipMapperConfig = ClipMapperConfig()
    embedding_latency: float = Field(default=0.12, ge=0.0, le=60.0)
    """The embedding of one frame takes this simulated time [s]."""
    cloud_stride: int = Field(default=8, ge=1, le=480)
    """A keyframe adds each n-th pixel of each n-th row to the coloured cloud; this is n [px]."""
    cloud_range: float = Field(default=4.0, ge=0.1, le=65.0)
    """Pixels with more depth than this are not added to the coloured cloud [m]."""


class Config(Settings):
    """All settings; the defaults describe the robot of the README."""

    clip: str = Field(default="embedded", json_schema_extra=BASIC)
    """The encoder is `embedded`, `photos`, `ViT-B/32`, `ViT-L/14`, a hub name, a folder, or
    MODULE:CLASS."""
    device: str = Field(default="cpu", json_schema_extra=BASIC)
    """The encoder runs on this device: `cpu`, `cuda` (`cuda:1` for a second one) or `auto`."""
    half: bool = Field(default=False, json_schema_extra=BASIC)
    """This says whether the encoder computes in 16-bit floating point, which needs CUDA."""
    clip_calibration: str = ""
    """The numbers that `vizbot calibrate encoder` fitted to the encoder are read from this file;
    empty takes them from this user's folder, if they are there."""
    serial_port: str = Field(default="/dev/ttyUSB0", json_schema_extra=BASIC)
    """The Roomba is on this serial port."""
    mount: MountConfig = MountConfig()
    calibration: CalibrationConfig = CalibrationConfig()
    roomba: RoombaConfig = RoombaConfig()
    realsense: RealSenseConfig = RealSenseConfig()
    perception: PerceptionConfig = PerceptionConfig()
    objectnav: ObjectNavConfig = ObjectNavConfig()
    navigator: NavigatorConfig = NavigatorConfig()
    frontier: FrontierConfig = FrontierConfig()
    recovery: RecoveryConfig = RecoveryConfig()
    docking: DockingConfig = DockingConfig()
    # A robot passes the tables of rehearsals over: `vizbot.rehearsal.config` reads them.
    world: dict[str, Any] | None = None
    """The body of the simulated robot, for rehearsals alone."""
    sim_camera: dict[str, Any] | None = None
    """The simulated camera, for rehearsals alone."""

    @field_validator("device")
    @classmethod
    def _device_is_one_of_pytorchs(cls, device: str) -> str:
        if re.fullmatch(r"auto|cpu|cuda(:\d+)?", device) is None:
            raise ValueError("it must be cpu, cuda, cuda:1 or auto")
        return device

    @model_validator(mode="after")
    def _robot_fits_under_what_it_passes(self) -> Self:
        top, band = self.mount.height + 0.05, self.perception.depth_mapper.scan.max_height
        if top > band:
            raise ValueError(
                f"the camera's top at {top:.2f} m is above the obstacle map's band; set"
                f" perception.depth_mapper.scan.max_height to {top:.2f} or more"
            )
        return self


def with_method(config: Config, method: Method) -> Config:
    """The same robot with this method of search."""
    objectnav = config.objectnav.model_copy(update={"method": method})
    return config.model_copy(update={"objectnav": objectnav})


def load_config(path: Path | None, clip: str | None = None, method: Method | None = None) -> Config:
    """Read a TOML file; None gives the defaults.

    `clip` and `method` replace the file's own.

    Raises:
        ConfigError: the file is missing, is not TOML, or has a wrong key or value, or one by its
            former name and by that of today.
    """
    settings: dict[str, object] = {}
    if path is not None:
        try:
            settings = tomllib.loads(read_regular(path, _LARGEST).decode("utf-8-sig"))
        except OSError as error:
            text = f"configuration {path}: {error.strerror}; give a TOML file"
            raise ConfigError(text) from error
        except RecursionError as error:
            text = f"configuration {path} is nested too deep; settings are two or three tables deep"
            raise ConfigError(text) from error
        except ValueError as error:  # of TOML, of UTF-8, or of a number with thousands of digits
            raise ConfigError(f"configuration {path} is not TOML: {error}; correct it") from error
    try:
        settings, renamed = with_names_of_today(settings)
    except ConfigError as error:
        raise ConfigError(f"configuration {path}: {error}") from error
    if renamed:
        _log.warning(
            "configuration %s: the next release reads new names alone: %s", path, ", ".join(renamed)
        )
    if clip is not None:
        settings["clip"] = clip
    try:
        config = Config.model_validate(settings)
    except ValidationError as error:
        raise ConfigError(f"configuration {path}: {explained(error, Config)}") from error
    return config if method is None else with_method(config, method)


def settings_toml(config: Config) -> str:
    """Every effective setting as TOML that `load_config` reads back to the same."""
    return tomlkit.dumps(config.model_dump(mode="json", exclude_none=True))


def write_config(config: Config, path: Path) -> None:
    """Write every effective setting as TOML that `load_config` reads back to the same."""
    write_whole(path, settings_toml(config).encode())
