"""The robot's real pipeline in a cheap world: a plan of cells, along which depth is cast.

Everything that decides is the product's own: the pipeline with its behaviours, searches, navigator
and step motion, the obstacle map and the explored area. Only what costs time is left out: pictures,
poses from them, and an encoder. What is believed is said by the test.
"""

import zlib
from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np

from mapping.clip.places.belief import PlaceBelief
from mapping.clip.places.footprint import PLACE
from mapping.occupancy.depth_mapper import DepthMapper
from mapping.occupancy.planar_scan import BEARINGS, FLOOR, OBSTACLE, PASSED, PlanarScan
from vizbot.config import Config
from vizbot.core.diff_drive import rolled, wheel_speeds
from vizbot.core.distance import distance_to_zero
from vizbot.core.geometry import camera_mount, invert, planar, yaw_of
from vizbot.core.interfaces import Devices
from vizbot.core.program.kernels import kernel
from vizbot.core.simulated_clock import SimulatedClock
from vizbot.core.types import (
    STOP,
    BaseMode,
    BaseState,
    ImuSamples,
    Intrinsics,
    PoseEstimate,
    RGBDFrame,
    Tracking,
)
from vizbot.objectnav.tasks import Goal
from vizbot.perception.sightings import Sightings
from vizbot.pipeline import Pipeline

OPEN, MATT, BARE, GLASS, LOW = range(5)
"""What a cell of a plan holds: nothing; what depth shows; what it shows nothing of, as a white wall
without pictures; what it shows what is behind of; what is too low for it."""
CELL = 0.1
"""Width of a plan's cells [m]."""
PERIOD = 0.3
"""Of the camera's frames [s]."""
LEAST_RANGE, FLOOR_FROM, REACH = 0.28, 1.1, 2.0
"""Least measured depth, the nearest floor in the picture, and how far depth reaches [m]."""
RADIUS = 0.175
CAMERA = Intrinsics(8, 8, 6.0, 6.0, 3.5, 3.5)
MOUNT = camera_mount(0.6, 0.05, 0.15)
WHEEL_BASE = 0.235
_RANGE_STEP = 0.05
_BINS = 140
"""Bearings of the view, half a degree each."""


@dataclass(frozen=True)
class Trouble:
    """What goes wrong from one frame on, and for how many frames.

    `what` is "depth" (it shows nothing), "lost" (nothing is recognised), "pose" (it stands still,
    whatever the robot does), "wheels" (they turn on the spot: the robot stands still), "bump" (the
    bumper stays pressed), "wall" (the beam of a virtual wall is received), "edge" (no floor ahead),
    "overcurrent" (a wheel is stuck), "lift" (both wheels hang), "passive" (the base does not obey),
    "charger" (its cable is plugged in) or "dock" (the base stands on the contacts of one).
    """

    what: str
    begins: int
    frames: int


@dataclass
class PlanWorld:
    """A robot on a plan (rows, cols) of cells; it is camera and base in one.

    Attributes:
        plan: What the cells hold.
        troubles: What goes wrong.
        clock: Runs on with every frame.
        T_world_base: Where the robot is.
        contacts: How often it has touched something.
    """

    plan: np.ndarray
    troubles: tuple[Trouble, ...] = ()
    clock: SimulatedClock = field(default_factory=lambda: SimulatedClock(0.05))
    T_world_base: np.ndarray = field(default_factory=lambda: np.eye(4))
    frames: int = 0
    contacts: int = 0

    def __post_init__(self):
        self._twist, self._touched, self._odometry = STOP, 0, np.eye(4)
        self._room = distance_to_zero((self.plan == OPEN).astype(np.uint8)) * CELL
        self._start = np.eye(4)

    def start_at(self, x, y, yaw):
        self.T_world_base = self._start = planar(x, y, yaw)

    def is_free(self, x, y):
        row, col = int(y / CELL), int(x / CELL)
        inside = 0 <= row < self.plan.shape[0] and 0 <= col < self.plan.shape[1]
        return inside and self._room[row, col] >= RADIUS + CELL / 2

    def has(self, what):
        return any(
            each.what == what and each.begins <= self.frames < each.begins + each.frames
            for each in self.troubles
        )

    def read(self, timeout=1.0):
        """A frame, whose depth image only says how much of it is measured."""
        self.clock.sleep(PERIOD)
        self._move(PERIOD)
        self.frames += 1
        hits, kinds = self._view = self._cast()
        shown = 0.0
        if not self.has("depth"):
            walls = (kinds == MATT) & (hits >= LEAST_RANGE)
            shown = float((0.5 * walls + 0.5 * (hits > FLOOR_FROM)).mean())
        depth = np.zeros((32, 32), np.float32)
        depth.flat[: round(shown * depth.size)] = 1.0
        depth = np.ascontiguousarray(depth.T)  # the same share in every fourth row
        return RGBDFrame(self.clock.now(), _RGB, depth, CAMERA, ImuSamples.none())

    def scan(self):
        """The planar scan of what is ahead, as `flatten` makes it of a depth image."""
        evidence = np.zeros((_BINS, int(REACH / _RANGE_STEP)), np.uint8)
        if not self.has("depth"):
            hits, kinds = self._view
            _classify(evidence, hits, kinds == MATT, _RANGE_STEP, LEAST_RANGE, FLOOR_FROM)
        return PlanarScan(BEARINGS // 2 - _BINS // 2, evidence.shape, _packed(evidence))

    def drive(self, twist):
        self._twist = twist

    def base_state(self):
        bumped, edge, lifted = map(self.has, ("bump", "edge", "lift"))
        return BaseState(
            self.clock.now(),
            self._odometry,
            bumped or bool(self._touched & 1),
            bumped or bool(self._touched & 2),
            (False, edge, edge, False),
            (lifted, lifted),
            1.0,
            BaseMode.PASSIVE if self.has("passive") else BaseMode.SAFE,
            virtual_wall=self.has("wall"),
            overcurrents=(self.has("overcurrent"), False),
            plugged_in=self.has("charger"),
            docked=self.has("dock"),
        )

    @property
    def T_map_base(self):
        """Where the robot believes to be."""
        return self._odometry

    def _cast(self):
        T = self.T_world_base @ planar(0.05, 0.0, 0.0)
        x, y = T[:2, 3]
        hits, kinds = np.empty(_BINS), np.empty(_BINS, np.uint8)
        _cast_rays(self.plan, x, y, yaw_of(T), CELL, REACH + 1.0, hits, kinds)
        return hits, kinds

    def _move(self, seconds):
        self._touched = 0
        left, right = wheel_speeds(self._twist, WHEEL_BASE)
        steps = 3
        for _ in range(steps):
            motion = rolled(left * seconds / steps, right * seconds / steps, WHEEL_BASE)
            if self.has("wheels"):
                return
            after = self.T_world_base @ motion
            x, y = after[:2, 3]
            if not self.is_free(x, y) and not self._eases(after):
                self._touched = self._felt()
                self.contacts += 1
                return
            self.T_world_base = after
            if not self.has("pose"):
                self._odometry = self._odometry @ motion

    def _eases(self, after):
        """Whether a motion that ends too near to something gets away from it."""
        return self._room_at(after) > self._room_at(self.T_world_base) or np.allclose(
            after[:2, 3], self.T_world_base[:2, 3], atol=1e-4
        )

    def _room_at(self, T):
        x, y = T[:2, 3]
        row, col = int(y / CELL), int(x / CELL)
        inside = 0 <= row < self.plan.shape[0] and 0 <= col < self.plan.shape[1]
        return float(self._room[row, col]) if inside else -1.0

    def _felt(self):
        """Which halves of the bumper are pressed; none while it drives backwards."""
        if self._twist.linear <= 0.0:
            return 0
        felt = 0
        for degrees, switch in ((0, 3), (35, 1), (-35, 2), (70, 1), (-70, 2)):
            a = np.radians(degrees)
            ahead = planar(0.25 * np.cos(a), 0.25 * np.sin(a), 0.0)
            x, y = (self.T_world_base @ ahead)[:2, 3]
            row, col = int(y / CELL), int(x / CELL)
            inside = 0 <= row < self.plan.shape[0] and 0 <= col < self.plan.shape[1]
            if not inside or self.plan[row, col] != OPEN:
                felt |= switch
        return felt or 3


class PlanPerception:
    """Maps of a plan's robot: a real obstacle map, and a belief that the test names.

    Attributes:
        places: Places (x, y, probability) in `map` that show what is asked for, once in view.
    """

    frame = 0
    embedded = skipped = 0

    def __init__(self, world, config, places):
        self.world, self.places = world, places
        self.depth_mapper = DepthMapper(config.perception.depth_mapper)
        poses = {0: np.eye(4)}  # those of the wheels; no keyframe but the first
        self.slam = SimpleNamespace(closures=[], keyframe_poses=lambda: poses)
        self.clip_map = SimpleNamespace(elements=_NO_ELEMENTS, **vars(_NO_ELEMENTS))
        self._shape = (40, 40)
        self._low = np.array([-20, -20])
        self._seen_from = np.zeros((*self._shape, 2))
        self._seen = np.zeros(self._shape, np.bool_)

    def update(self, frame, T_odom_base, *, lifted=False):
        lost = self.world.has("lost")
        T_map_cam = T_odom_base @ MOUNT
        if not lost:
            self.depth_mapper.add_scan(0, T_map_cam, T_map_cam, self.world.scan())
            self._look(T_odom_base)
        tracking = Tracking.LOST if lost else Tracking.TRACKING
        return PoseEstimate(frame.stamp, T_map_cam, 0, T_map_cam, False, tracking)

    def _look(self, T_map_base):
        """See the places in view."""
        here, yaw = T_map_base[:2, 3], yaw_of(T_map_base)
        for x, y, _ in self.places:
            dx, dy = np.array([x, y]) - here
            aside = abs((np.arctan2(dy, dx) - yaw + np.pi) % (2 * np.pi) - np.pi)
            if np.hypot(dx, dy) < REACH and aside < 0.5:
                column, row = np.floor(np.array([x, y]) / PLACE).astype(int) - self._low
                if 0 <= row < self._shape[0] and 0 <= column < self._shape[1]:
                    self._seen[row, column] = True
                    self._seen_from[row, column] = here

    def base_of(self, estimate):
        return estimate.T_map_cam @ invert(MOUNT)

    def embed(self, frame, estimate, *, standing=False):
        pass

    def points(self):
        return np.zeros((0, 3))

    def grid(self):
        return self.depth_mapper.grid()

    def sightings(self, _):
        """What a search by the paper's method sees: the places in view, as alike as likely."""
        at = np.array([place for place in self.places if self._saw(*place[:2])]).reshape(-1, 3)
        cells = np.floor(at[:, :2] / PLACE).astype(int) - self._low
        points = np.column_stack([at[:, :2], np.full(len(at), 0.5)])
        return Sightings(
            points, at[:, 2].astype(np.float32), self._seen_from[cells[:, 1], cells[:, 0]]
        )

    def _saw(self, x, y):
        column, row = np.floor(np.array([x, y]) / PLACE).astype(int) - self._low
        inside = 0 <= row < self._shape[0] and 0 <= column < self._shape[1]
        return inside and bool(self._seen[row, column])

    def believe(self, belief):
        probabilities = np.zeros(self._shape)
        for x, y, probability in self.places:
            column, row = np.floor(np.array([x, y]) / PLACE).astype(int) - self._low
            if 0 <= row < self._shape[0] and 0 <= column < self._shape[1]:
                probabilities[row, column] = probability
        return PlaceBelief(
            self._low,
            np.where(self._seen, probabilities, 0.0),
            np.zeros(self._shape, np.float32),
            self._seen,
            self._seen_from,
            np.full(self._shape, 0.5, np.float32),
        )


_NO_ELEMENTS = SimpleNamespace(
    frames=np.zeros(0, np.int32),
    boxes=np.zeros((0, 4), np.int32),
    embeddings=np.zeros((0, 2), np.float32),
)


class PlanEncoder:
    """Embeds nothing."""

    log_odds = (100.0, -10.0)
    threshold = 0.3
    dimension = 2
    model_id = "none"
    notice = None


def robot_on(world, places=(), config=None):
    """The pipeline of a robot in a plan, which believes to see what is asked for at places."""
    config = plan_config() if config is None else config
    base = SimpleNamespace(
        drive=world.drive, read=world.base_state,
        dock=lambda: None, resume=lambda: None, show=lambda feedback: None,
    )  # fmt: skip
    devices = Devices(world.clock, world, base, MOUNT, False)
    pipeline = Pipeline(devices, PlanEncoder(), config, [])
    pipeline.map.begin(PlanPerception(world, config, tuple(places)))
    return pipeline


def plan_config(method="belief"):
    """Settings with coarse cells and a short view, which cost little time."""
    config = Config()
    scan = config.perception.depth_mapper.scan.model_copy(
        update={"max_range": REACH, "range_step": _RANGE_STEP}
    )
    mapper = config.perception.depth_mapper.model_copy(update={"resolution": CELL, "scan": scan})
    perception = config.perception.model_copy(update={"depth_mapper": mapper})
    search = config.objectnav.model_copy(update={"method": method})
    return config.model_copy(update={"perception": perception, "objectnav": search})


def plan_goal(text="yellow chair"):
    return Goal(text, np.array([1.0, 0.0], np.float32), 0.3)


_RGB = np.zeros((32, 32, 3), np.uint8)


def _packed(evidence):
    return zlib.compress(evidence.tobytes(), 0)


@kernel()
def _cast_rays(plan, x, y, yaw, cell, reach, hits, kinds):
    bins = len(hits)
    for b in range(bins):
        angle = yaw + ((b + 0.5) / bins - 0.5) * bins * 2 * np.pi / 720
        c, s = np.cos(angle), np.sin(angle)
        hits[b], kinds[b] = reach, 0
        r = 0.0
        while r < reach:
            r += 0.025
            row, col = int(np.floor((y + r * s) / cell)), int(np.floor((x + r * c) / cell))
            inside = 0 <= row < plan.shape[0] and 0 <= col < plan.shape[1]
            if not inside:
                hits[b], kinds[b] = r, 1
                break
            if plan[row, col] == 1 or plan[row, col] == 2:
                hits[b], kinds[b] = r, plan[row, col]
                break


@kernel()
def _classify(evidence, hits, shown, step, least_range, floor_from):
    for b in range(len(hits)):
        is_hit = shown[b] and hits[b] >= least_range
        last = 0
        for r in range(evidence.shape[1]):
            away = (r + 0.5) * step
            if away >= hits[b]:
                if is_hit:
                    evidence[b, r] = OBSTACLE
                    last = r
                break
            if away > floor_from:
                evidence[b, r] = FLOOR
                last = r
        for r in range(last):
            if evidence[b, r] == 0 and (r + 0.5) * step > floor_from - 0.3:
                evidence[b, r] = PASSED
