"""The whole configuration: every part's own settings, composed; TOML in and out."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Literal, Self

import tomlkit
from pydantic import BaseModel, Field, ValidationError, model_validator

from drivers.realsense.config import RealSenseConfig
from drivers.roomba.config import RoombaConfig
from mapping.calibration.robot_calibration import CalibrationConfig
from mapping.clip.mapper import ClipMapperConfig
from mapping.occupancy.depth_mapper import DepthMapperConfig
from mapping.relocalisation.local_map import LocalMapConfig
from mapping.slam.config import SlamConfig
from nav.frontier import FrontierConfig
from nav.navigator import NavigatorConfig, Reach
from nav.recovery import RecoveryConfig
from sim_stubs.realsense.camera import SimulatedRealSenseConfig
from sim_stubs.world.world import WorldConfig
from vizbot.core.errors import ConfigError
from vizbot.core.files import write_whole
from vizbot.core.geometry import camera_mount
from vizbot.core.settings import SETTINGS, explained
from vizbot.core.types import SE3


class MountConfig(BaseModel):
    """Where the camera sits on the robot, real or simulated."""

    model_config = SETTINGS

    height: float = Field(default=0.60, gt=0.0)
    """Of the optical centre above the floor [m]."""
    forward: float = 0.05
    """Of the optical centre ahead of the wheel axle [m]."""
    tilt: float = Field(default=0.15, gt=-1.4, lt=1.4)
    """Downwards from the horizontal [rad]."""
    left: float = 0.0
    """Of the optical centre from the middle of the axle [m]."""
    yaw: float = Field(default=0.0, gt=-1.6, lt=1.6)
    """To the left of the base's heading [rad]."""
    roll: float = Field(default=0.0, gt=-0.5, lt=0.5)
    """About where it looks [rad]: positive when its right side is the lower one."""

    @property
    def T_base_cam(self) -> SE3:
        """The camera in the base."""
        return camera_mount(self.height, self.forward, self.tilt, self.left, self.yaw, self.roll)


class AgreementConfig(BaseModel):
    """How many views must agree before something is taken for the goal."""

    model_config = SETTINGS

    views: int = Field(default=5, gt=0)
    """The mean of the best so many keyframes counts; one is the paper's rule."""
    radius: float = Field(default=0.7, gt=0.0)
    """How far apart elements of one thing lie on the plan [m]."""
    falloff: float = Field(default=0.05, ge=0.0)
    """How much less similarity counts that is farther off [1/m], so that the middle is gone to."""
    lent: float = Field(default=0.2, ge=0.0)
    """An element counts at most this share more than it is similar itself: the floor beside a
    carpet is near what the views agree on, and is not the carpet."""
    clear_range: float = Field(default=2.0, ge=0.0)
    """What was seen from farther away [m] ..."""
    range_doubt: float = Field(default=0.11, ge=0.0)
    """... counts less by this share of its similarity [1/m]."""
    halving_doubt: float = Field(default=0.05, ge=0.0)
    """So does what a patch of half the width of the largest shows, by this share, and so on: small
    patches show parts, and parts of different things look alike."""


class ConfirmationConfig(BaseModel):
    """What must be seen from near by before the robot says that it has arrived."""

    model_config = SETTINGS

    near: float = Field(default=2.5, gt=0.0)
    """From within this distance of the place on the plan [m]."""
    spacing: float = Field(default=0.2, gt=0.0)
    """Views from positions this far apart count, not those of a turn on the spot [m]."""
    agreement: AgreementConfig = AgreementConfig(views=3)
    """How many of them must agree ..."""
    share: float = Field(default=0.95, gt=0.0)
    """... on this share of the threshold; ..."""
    in_sight: float = Field(default=1.5, gt=0.0)
    """... and seen from where the robot stands, something so near to the place [m] ..."""
    in_sight_share: float = Field(default=0.8, gt=0.0)
    """... must reach the threshold, or after a whole turn this share of it."""
    doubt: float = Field(default=0.05, ge=0.0)
    """By how much similarity falls with each time that a place was refuted."""
    patience: int = Field(default=10, gt=0)
    """Steps after which a frame that is not embedded yet never will be."""
    turn_patience: int = Field(default=60, gt=0)
    """Steps after which the robot does not go on turning, if something holds it."""


class InspectionConfig(BaseModel):
    """What is looked at more closely before the robot decides where the goal is."""

    model_config = SETTINGS

    suspicion: float = Field(default=0.9, gt=0.0)
    """What one view from afar finds more similar than this share of theta ..."""
    near: float = Field(default=2.0, gt=0.0)
    """... was seen well from within this distance on the plan [m] ..."""
    views: int = Field(default=3, gt=0)
    """... from as many positions on the same side ..."""
    spacing: float = Field(default=0.3, gt=0.0)
    """... this far apart [m] ..."""
    radius: float = Field(default=0.7, gt=0.0)
    """... that saw something so near to it [m]."""
    reach: Reach = Reach(distance=1.2, extent=0.6)
    """From where it has been looked at."""
    detour: float = Field(default=4.0, ge=0.0)
    """What is farther away waits until no large frontier is left [m]."""


class GyroSettlingConfig(BaseModel):
    """How long the robot stands still at first, so that the gyroscope's bias is learned."""

    model_config = SETTINGS

    seconds: float = Field(default=2.0, ge=0.0)
    """At least so long [s] ..."""
    frames: int = Field(default=5, ge=0)
    """... and for so many frames."""


class ObjectNavConfig(BaseModel):
    """The paper's Algorithm 1, and when to give up."""

    model_config = SETTINGS

    threshold: float | None = Field(default=None, gt=0.0, lt=1.0)
    """Similarity above which an element is the goal (theta); None takes the encoder's own."""
    threshold_step: float = Field(default=0.001, gt=0.0)
    """How far theta is lowered at a time when the space is closed (Algorithm 1)."""
    threshold_floor: float = Field(default=0.8, gt=0.0, le=1.0)
    """Theta is never lowered below this fraction of its start: below it nothing was found."""
    choosy: float = Field(default=1.3, ge=1.0)
    """A search begins with this multiple of theta, for something better may be found yet ..."""
    settled_for: float = Field(default=0.95, gt=0.0, le=1.0)
    """... which sinks to this one ..."""
    choosy_share: float = Field(default=0.75, ge=0.0, le=1.0)
    """... in this part of `max_steps`; after that the best so far is driven to before more is
    explored, theta being lowered."""
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
    """How near the robot goes, the best first; the middle of a bed is reached from its side, and
    carpets and windows would be out of sight from nearer by."""
    closing_reaches: tuple[Reach, ...] = Field(
        default=(
            Reach(distance=1.0, extent=0.6, least_height=0.35, most_height=1.1),
            Reach(distance=1.9, extent=1.0, most_height=0.18),
            Reach(distance=1.5, extent=1.0),
        ),
        min_length=1,
    )
    """How near it goes to what it sees from there, the best first; what it sees may be the edge of
    the thing, or stand before it. Only what is as high as the first of them asks for is in the
    picture from so near; a carpet is soon below it."""
    waypoint_reaches: tuple[Reach, ...] = Field(
        default=(Reach(distance=0.25, extent=0.05), Reach(distance=0.8, extent=0.05)), min_length=1
    )
    """How near it goes to a place on the map that it is sent to, the best first; where something
    stands on it, as near as to a goal."""
    similarity_worth: float = Field(default=20.0, ge=0.0)
    """How much more way something is worth that is more similar by 1 [m]."""
    max_steps: int = Field(default=1000, gt=0)
    """Steps for one goal after which the robot gives up (paper, section IV-C)."""
    max_exploration_steps: int = Field(default=3000, gt=0)
    """Likewise for an exploration without a goal."""
    exploration: Literal["nearest_frontier", "distant_point"] = "nearest_frontier"
    """Where to while nothing is found: the cheapest place not looked at yet, by the way there and
    what is to be seen behind it (`nav.frontier`), or the paper's distant point and, once the space
    is closed, what was left out on the way."""
    look_around: bool = True
    """Turn once on the spot before the first goal."""
    look_around_rate: float = Field(default=1.3, gt=0.0)
    """Angular velocity of that turn [rad/s]."""
    recognising_rate: float = Field(default=0.5, gt=0.0)
    """Likewise of a robot that is lost: slowly, for sharp images [rad/s]."""


class DockingConfig(BaseModel):
    """How the robot gets onto its dock."""

    model_config = SETTINGS

    before: float = Field(default=0.8, gt=0.0)
    """So far from where it stands on the contacts, the base is left to find them [m]."""
    patience: float = Field(default=90.0, gt=0.0)
    """It gets so long for that [s]."""


class PerceptionConfig(BaseModel):
    """What turns frames into maps."""

    model_config = SETTINGS

    slam: SlamConfig = SlamConfig()
    depth_mapper: DepthMapperConfig = DepthMapperConfig()
    surroundings: LocalMapConfig = LocalMapConfig()
    clip_mapper: ClipMapperConfig = ClipMapperConfig()
    embedding_latency: float = Field(default=0.12, ge=0.0)
    """How long one frame's embedding takes in simulated time [s]; real time takes what it takes."""
    cloud_stride: int = Field(default=8, gt=0)
    """Every how many pixels a keyframe leaves a point in the coloured cloud."""
    cloud_range: float = Field(default=4.0, gt=0.0)
    """Depth beyond which it leaves none [m]."""


class Config(BaseModel):
    """Everything that can be set; the defaults are the robot of the README."""

    model_config = SETTINGS

    clip: str = "embedded"
    """Encoder: `embedded`, `ViT-B/32`, `ViT-L/14`, a hub name or a folder."""
    device: str = "cpu"
    """Where the encoder runs: `cpu`, `cuda` or `auto`."""
    half: bool = False
    """Whether the encoder computes in 16-bit floating point, which is for CUDA."""
    serial_port: str = "/dev/ttyUSB0"
    """Port of the Roomba."""
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


def load_config(path: Path | None, clip: str | None = None) -> Config:
    """Read a TOML file; None gives the defaults.

    Args:
        path: The file.
        clip: Encoder instead of the file's own.

    Raises:
        ConfigError: the file is missing, is not TOML, or has a wrong key or value.
    """
    settings: dict[str, object] = {}
    if path is not None:
        try:
            settings = tomllib.loads(path.read_text(encoding="utf-8"))
        except OSError as error:
            text = f"configuration {path}: {error.strerror}; give a TOML file"
            raise ConfigError(text) from error
        except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
            raise ConfigError(f"configuration {path} is not TOML: {error}") from error
    if clip is not None:
        settings["clip"] = clip
    try:
        return Config.model_validate(settings)
    except ValidationError as error:
        raise ConfigError(f"configuration {path}: {explained(error, Config)}") from error


def write_config(config: Config, path: Path) -> None:
    """Write every effective setting as TOML that `load_config` reads back to the same."""
    write_whole(path, tomlkit.dumps(config.model_dump(mode="json", exclude_none=True)).encode())
