"""The whole configuration: every part's own settings, composed; TOML in and out."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any, Self

import tomlkit
from pydantic import BaseModel, Field, ValidationError, field_validator, model_validator

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
from vizbot.core.settings import SETTINGS, explained
from vizbot.core.types import SE3

_LARGEST = 1024 * 1024
"""Size of a settings file that is read [bytes]."""


class MountConfig(BaseModel):
    """Where the camera sits on the robot, real or simulated."""

    model_config = SETTINGS

    height: float = Field(default=0.60, ge=0.1, le=2.0)
    """Height of the optical centre above the floor [m]."""
    forward: float = Field(default=0.05, ge=-0.5, le=0.5)
    """Distance of the optical centre ahead of the wheel axle [m]."""
    tilt: float = Field(default=0.15, gt=-1.4, lt=1.4)
    """Angle by which the camera looks down from the horizontal [rad]."""
    left: float = Field(default=0.0, ge=-0.5, le=0.5)
    """Distance of the optical centre to the left of the middle of the axle [m]."""
    yaw: float = Field(default=0.0, gt=-1.6, lt=1.6)
    """Angle by which the camera looks to the left of the base's heading [rad]."""
    roll: float = Field(default=0.0, gt=-0.5, lt=0.5)
    """Angle of the camera about its optical axis, positive when its right side is lower [rad]."""

    @property
    def T_base_cam(self) -> SE3:
        """Where the camera is in `base`."""
        return camera_mount(self.height, self.forward, self.tilt, self.left, self.yaw, self.roll)


class GyroSettlingConfig(BaseModel):
    """How long the robot stands still at first, so that the gyroscope's bias is learned."""

    model_config = SETTINGS

    seconds: float = Field(default=2.0, ge=0.0, le=600.0)
    """The robot stands still for at least this time [s]."""
    frames: int = Field(default=5, ge=0, le=10_000)
    """The robot stands still for at least this number of frames [1]."""


class BeliefSearchConfig(BaseModel):
    """When a place is believed, and what is worth going to."""

    model_config = SETTINGS

    sure: float = Field(default=0.8, gt=0.0, lt=1.0)
    """Probability from which the robot says that it has arrived, early in a search [1]; in one for
    a room until nothing is left to see."""
    settled: float = Field(default=0.6, gt=0.0, lt=1.0)
    """The same, late in a search for a thing [1]."""
    last: float = Field(default=0.4, gt=0.0, lt=1.0)
    """The same when nothing is left to see, and from twice as late on [1]."""
    patience: int = Field(default=300, ge=1, le=1_000_000)
    """Number of steps after which a search is late [1]."""
    candidate: float = Field(default=0.25, gt=0.0, lt=1.0)
    """Probability below which places are mostly left until nothing better is to be done [1]: a look
    at one is worth less by the square of its share of this."""
    commitment: float = Field(default=0.3, ge=0.0, le=10.0)
    """Share by which another aim must be better than the present one [1]."""
    findings: float = Field(default=0.015, ge=1e-6, le=10.0)
    """Chance that a square metre not seen yet shows what is asked for, in a place like any other
    [1/m^2]."""
    worth: float = Field(default=0.005, ge=0.0, le=10.0)
    """Probability for each metre of way below which nothing is tried any more, after twice the
    patience: the search ends, as not found [1/m]. It rises to that from 0 when a search is late."""
    doubt: float = Field(default=0.2, gt=0.0, lt=1.0)
    """Factor of the probability of a place that was looked at from near and not believed [1]."""


class ObjectNavConfig(BaseModel):
    """How the robot searches for a thing or a room, and when it gives up."""

    model_config = SETTINGS

    method: Method = "belief"
    """`belief` holds all that can be done next against each other, by the probabilities of places
    (`objectnav.belief_search`). `paper` searches by the paper's Algorithm 1 and by nothing else
    (`objectnav.paper_search`); a goal then takes `threshold`, `settling` and `max_steps` of these
    settings alone."""
    search: BeliefSearchConfig = BeliefSearchConfig()
    found: float = Field(default=0.5, gt=0.0, lt=1.0)
    """Probability above which a place on the map answers a question [1]."""
    threshold: float | None = Field(default=None, gt=0.0, lt=1.0)
    """Similarity above which an element is the goal (theta), by the method `paper` [1]. Without it
    the encoder's own is used."""
    settling: GyroSettlingConfig = GyroSettlingConfig()
    waypoint_reaches: tuple[Reach, ...] = Field(
        default=(Reach(distance=0.25, extent=0.05), Reach(distance=0.8, extent=0.05)), min_length=1
    )
    """How near the robot goes to a place on the map that it is sent to, the best first."""
    max_steps: int = Field(default=1000, ge=1, le=1_000_000)
    """Number of steps for one goal after which the robot gives up (paper, section IV-C) [1]."""
    max_exploration_steps: int = Field(default=3000, ge=1, le=1_000_000)
    """Number of steps after which the robot gives up an exploration without a goal [1]."""
    look_around: bool = True
    """Whether the robot turns once on the spot before the first goal."""
    look_around_rate: float = Field(default=1.3, ge=0.05, le=4.3)
    """Angular velocity of the turn before the first goal [rad/s]."""
    recognising_rate: float = Field(default=0.5, ge=0.05, le=4.3)
    """Angular velocity of the turn of a robot that is lost; slow, for sharp images [rad/s]."""


class DockingConfig(BaseModel):
    """How the robot gets onto its dock."""

    model_config = SETTINGS

    before: float = Field(default=0.8, ge=0.2, le=3.0)
    """Distance from the dock at which the base begins to look for the contacts by itself [m]."""
    patience: float = Field(default=90.0, ge=5.0, le=3600.0)
    """Time that the base has to find the contacts [s]."""


class PerceptionConfig(BaseModel):
    """How frames are turned into maps."""

    model_config = SETTINGS

    slam: SlamConfig = SlamConfig()
    depth_mapper: DepthMapperConfig = DepthMapperConfig()
    surroundings: LocalMapConfig = LocalMapConfig()
    clip_mapper: ClipMapperConfig = ClipMapperConfig()
    embedding_latency: float = Field(default=0.12, ge=0.0, le=60.0)
    """Duration of one frame's embedding in simulated time [s]."""
    cloud_stride: int = Field(default=8, ge=1, le=480)
    """A keyframe adds every n-th pixel of every n-th row to the coloured cloud [px]."""
    cloud_range: float = Field(default=4.0, ge=0.1, le=65.0)
    """Pixels with more depth than this are not added to the coloured cloud [m]."""


class Config(BaseModel):
    """All settings; the defaults describe the robot of the README."""

    model_config = SETTINGS

    clip: str = "embedded"
    """The encoder: `embedded`, `ViT-B/32`, `ViT-L/14`, a hub name, a folder, or MODULE:CLASS."""
    device: str = "cpu"
    """The device on which the encoder runs: `cpu`, `cuda` (`cuda:1` for a second one) or `auto`."""
    half: bool = False
    """Whether the encoder computes in 16-bit floating point, which needs CUDA."""
    serial_port: str = "/dev/ttyUSB0"
    """The serial port of the Roomba."""
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

    Args:
        path: The file.
        clip: Encoder instead of the file's own.
        method: Method of search instead of the file's own.

    Raises:
        ConfigError: the file is missing, is not TOML, or has a wrong key or value.
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
            raise ConfigError(f"configuration {path} is not TOML: {error}; mend it") from error
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
