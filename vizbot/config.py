"""The whole configuration: every part's own settings, composed; TOML in and out."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Literal, Self

import tomlkit
from pydantic import BaseModel, Field, ValidationError, model_validator

from drivers.realsense.config import RealSenseConfig
from drivers.roomba.config import RoombaConfig
from mapping.calibration.config import CalibrationConfig
from mapping.clip.config import ClipMapperConfig
from mapping.occupancy.config import DepthMapperConfig
from mapping.relocalisation.config import LocalMapConfig
from mapping.slam.config import SlamConfig
from nav.config import FrontierConfig, NavigatorConfig, Reach, RecoveryConfig
from sim_stubs.realsense.config import SimulatedRealSenseConfig
from sim_stubs.world.config import WorldConfig
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

    height: float = Field(default=0.60, gt=0.0)
    """Height of the optical centre above the floor [m]."""
    forward: float = 0.05
    """Distance of the optical centre ahead of the wheel axle [m]."""
    tilt: float = Field(default=0.15, gt=-1.4, lt=1.4)
    """Angle by which the camera looks down from the horizontal [rad]."""
    left: float = 0.0
    """Distance of the optical centre to the left of the middle of the axle [m]."""
    yaw: float = Field(default=0.0, gt=-1.6, lt=1.6)
    """Angle by which the camera looks to the left of the base's heading [rad]."""
    roll: float = Field(default=0.0, gt=-0.5, lt=0.5)
    """Angle of the camera about its optical axis, positive when its right side is lower [rad]."""

    @property
    def T_base_cam(self) -> SE3:
        """Where the camera is in `base`."""
        return camera_mount(self.height, self.forward, self.tilt, self.left, self.yaw, self.roll)


class AgreementConfig(BaseModel):
    """How views of an element from several keyframes are combined to one similarity."""

    model_config = SETTINGS

    views: int = Field(default=5, gt=0)
    """Number of best keyframes whose similarities are averaged; 1 is the paper's rule."""
    radius: float = Field(default=0.7, gt=0.0)
    """Elements within this distance of each other on the plan belong to one thing [m]."""
    falloff: float = Field(default=0.05, ge=0.0)
    """Similarity is reduced by this much for every metre from the place that is judged, so that the
    robot goes to the middle of a thing [1/m]."""
    lent: float = Field(default=0.2, ge=0.0)
    """The combined similarity of an element exceeds its own by at most this share. Without this
    limit the floor beside a carpet would count as carpet."""
    clear_range: float = Field(default=2.0, ge=0.0)
    """Views from within this range count fully [m]."""
    range_doubt: float = Field(default=0.11, ge=0.0)
    """Similarity is reduced by this share for every metre of range beyond `clear_range` [1/m]."""
    halving_doubt: float = Field(default=0.05, ge=0.0)
    """Similarity is reduced by this share for every halving of the patch's width from the largest
    one. Small patches show parts, and parts of different things look alike."""


class ConfirmationConfig(BaseModel):
    """Evidence from close by that is required before the robot reports that it has arrived."""

    model_config = SETTINGS

    near: float = Field(default=2.5, gt=0.0)
    """Views from within this distance of the place on the plan count as close [m]."""
    spacing: float = Field(default=0.2, gt=0.0)
    """Views count as different when their positions are farther apart than this [m]."""
    agreement: AgreementConfig = AgreementConfig(views=3)
    """How the close views are combined."""
    share: float = Field(default=0.95, gt=0.0)
    """The close views together must reach this share of the threshold."""
    in_sight: float = Field(default=1.5, gt=0.0)
    """Only what is within this distance of the place counts as seen from where the robot stands
    [m]."""
    in_sight_share: float = Field(default=0.8, gt=0.0)
    """What the robot sees from where it stands must reach the threshold, or after a whole turn this
    share of it."""
    doubt: float = Field(default=0.05, ge=0.0)
    """Similarity at a place is reduced by this much each time that the place was refuted."""
    patience: int = Field(default=10, gt=0)
    """Number of steps to wait for a frame to be embedded."""
    turn_patience: int = Field(default=60, gt=0)
    """Number of steps after which the robot stops turning, in case something holds it."""


class InspectionConfig(BaseModel):
    """When the robot takes a closer look at a place before it decides where the goal is."""

    model_config = SETTINGS

    suspicion: float = Field(default=0.9, gt=0.0)
    """A place is a suspect when one view of it reaches this share of theta."""
    near: float = Field(default=2.0, gt=0.0)
    """Only views from within this distance on the plan settle a suspect [m]."""
    views: int = Field(default=3, gt=0)
    """A suspect is settled by views from this many positions on the side it was seen from."""
    spacing: float = Field(default=0.3, gt=0.0)
    """Those positions are cells of a grid with this spacing [m]."""
    radius: float = Field(default=0.7, gt=0.0)
    """A view settles a suspect when it shows something within this distance of it [m]."""
    reach: Reach = Reach(distance=1.2, extent=0.6)
    """How near the robot goes to a suspect."""
    detour: float = Field(default=4.0, ge=0.0)
    """Suspects farther away than this wait until no large frontier is left [m]."""


class GyroSettlingConfig(BaseModel):
    """How long the robot stands still at first, so that the gyroscope's bias is learned."""

    model_config = SETTINGS

    seconds: float = Field(default=2.0, ge=0.0)
    """The robot stands still for at least this time [s]."""
    frames: int = Field(default=5, ge=0)
    """The robot stands still for at least this number of frames."""


class ObjectNavConfig(BaseModel):
    """The paper's Algorithm 1, and when to give up."""

    model_config = SETTINGS

    method: Method = "default"
    """`paper` searches by the paper's Algorithm 1 and by nothing else (`objectnav.paper_search`). A
    goal then takes `threshold`, `settling` and `max_steps` of these settings alone. `belief` holds
    all that can be done next against each other, by the probabilities of places
    (`objectnav.belief_search`); on trial, to replace the default."""
    threshold: float | None = Field(default=None, gt=0.0, lt=1.0)
    """Similarity above which an element is the goal (theta). Without it the encoder's own is
    used."""
    found: float = Field(default=0.5, gt=0.0, lt=1.0)
    """Probability above which a place on the map answers a question, by the method `belief`."""
    threshold_step: float = Field(default=0.001, gt=0.0)
    """Theta is lowered by this much at a time when the space is closed (Algorithm 1)."""
    threshold_floor: float = Field(default=0.8, gt=0.0, le=1.0)
    """Theta is never lowered below this fraction of its start; what is below is not found."""
    choosy: float = Field(default=1.3, ge=1.0)
    """A search begins with this multiple of theta, because something better may be found later."""
    settled_for: float = Field(default=0.95, gt=0.0, le=1.0)
    """The multiple of theta sinks from `choosy` to this value."""
    choosy_share: float = Field(default=0.75, ge=0.0, le=1.0)
    """The multiple of theta sinks during this fraction of `max_steps`. After that the robot lowers
    theta before it explores more."""
    settling: GyroSettlingConfig = GyroSettlingConfig()
    agreement: AgreementConfig = AgreementConfig()
    inspection: InspectionConfig = InspectionConfig()
    confirmation: ConfirmationConfig = ConfirmationConfig()
    reaches: tuple[Reach, ...] = Field(
        default=(
            Reach(distance=1.0, extent=0.6, least_height=0.35, most_height=0.75),
            Reach(distance=1.7, extent=1.0),
        ),
        min_length=1,
    )
    """How near the robot goes to an element, the best first. The middle of a bed is reached from
    its side; carpets and windows would be out of sight from closer by."""
    closing_reaches: tuple[Reach, ...] = Field(
        default=(
            Reach(distance=1.0, extent=0.6, least_height=0.35, most_height=1.1),
            Reach(distance=1.9, extent=1.0, most_height=0.18),
            Reach(distance=1.5, extent=1.0),
        ),
        min_length=1,
    )
    """How near the robot then goes to what it has confirmed, the best first, because that may be
    the edge of the thing. Only what is within the heights of the first reach is in the picture from
    there; a carpet is soon below it."""
    waypoint_reaches: tuple[Reach, ...] = Field(
        default=(Reach(distance=0.25, extent=0.05), Reach(distance=0.8, extent=0.05)), min_length=1
    )
    """How near the robot goes to a place on the map that it is sent to, the best first. A place
    with an obstacle on it is approached as an element is."""
    similarity_worth: float = Field(default=20.0, ge=0.0)
    """Length of way that one more unit of similarity makes up for [m]."""
    max_steps: int = Field(default=1000, gt=0, le=1_000_000)
    """Number of steps for one goal after which the robot gives up (paper, section IV-C)."""
    max_exploration_steps: int = Field(default=3000, gt=0, le=1_000_000)
    """Number of steps after which the robot gives up an exploration without a goal."""
    exploration: Literal["nearest_frontier", "distant_point"] = "nearest_frontier"
    """Where the robot explores. `nearest_frontier` is the cheapest frontier by the way there and
    the area to be seen behind it (`nav.frontier`). `distant_point` is the paper's, followed by the
    frontiers that are left once the space is closed."""
    look_around: bool = True
    """Whether the robot turns once on the spot before the first goal."""
    look_around_rate: float = Field(default=1.3, gt=0.0)
    """Angular velocity of the turn before the first goal [rad/s]."""
    recognising_rate: float = Field(default=0.5, gt=0.0)
    """Angular velocity of the turn of a robot that is lost; slow, for sharp images [rad/s]."""

    @property
    def ranking(self) -> AgreementConfig | None:
        """How views are combined where a map is asked; None ranks each by itself, as the paper."""
        return None if self.method == "paper" else self.agreement


class DockingConfig(BaseModel):
    """How the robot gets onto its dock."""

    model_config = SETTINGS

    before: float = Field(default=0.8, gt=0.0)
    """Distance from the dock at which the base begins to look for the contacts by itself [m]."""
    patience: float = Field(default=90.0, gt=0.0)
    """Time that the base has to find the contacts [s]."""


class PerceptionConfig(BaseModel):
    """How frames are turned into maps."""

    model_config = SETTINGS

    slam: SlamConfig = SlamConfig()
    depth_mapper: DepthMapperConfig = DepthMapperConfig()
    surroundings: LocalMapConfig = LocalMapConfig()
    clip_mapper: ClipMapperConfig = ClipMapperConfig()
    embedding_latency: float = Field(default=0.12, ge=0.0)
    """Duration of one frame's embedding in simulated time [s]."""
    cloud_stride: int = Field(default=8, gt=0)
    """A keyframe adds every n-th pixel of every n-th row to the coloured cloud."""
    cloud_range: float = Field(default=4.0, gt=0.0)
    """Pixels with more depth than this are not added to the coloured cloud [m]."""


class Config(BaseModel):
    """All settings; the defaults describe the robot of the README."""

    model_config = SETTINGS

    clip: str = "embedded"
    """The encoder: `embedded`, `ViT-B/32`, `ViT-L/14`, a hub name or a folder."""
    device: str = "cpu"
    """The device on which the encoder runs: `cpu`, `cuda` or `auto`."""
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
    world: WorldConfig = WorldConfig()
    sim_camera: SimulatedRealSenseConfig = SimulatedRealSenseConfig()

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
            settings = tomllib.loads(read_regular(path, _LARGEST).decode())
        except OSError as error:
            text = f"configuration {path}: {error.strerror}; give a TOML file"
            raise ConfigError(text) from error
        except RecursionError as error:
            text = f"configuration {path} is nested too deep; settings are two or three tables deep"
            raise ConfigError(text) from error
        except ValueError as error:  # of TOML, of UTF-8, or of a number with thousands of digits
            raise ConfigError(f"configuration {path} is not TOML: {error}") from error
    if clip is not None:
        settings["clip"] = clip
    try:
        config = Config.model_validate(settings)
    except ValidationError as error:
        raise ConfigError(f"configuration {path}: {explained(error, Config)}") from error
    return config if method is None else with_method(config, method)


def write_config(config: Config, path: Path) -> None:
    """Write every effective setting as TOML that `load_config` reads back to the same."""
    write_whole(path, tomlkit.dumps(config.model_dump(mode="json", exclude_none=True)).encode())
