"""One episode, run as `vizbot dry-run` runs it and scored from the world's truth."""

from __future__ import annotations

import logging
import time
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, cast

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.ablations.ablation import ABLATIONS
from benchmarks.episodes.calibration_error import CalibrationError
from benchmarks.episodes.episode import (
    FAR,
    EncoderScale,
    Episode,
    EpisodeResult,
    GoalResult,
    Variant,
)
from benchmarks.episodes.homes import open_episode
from benchmarks.episodes.latency import Latencies, slow_devices
from benchmarks.episodes.oracles import AtOnce, OracleParts, PerfectStop, oracle_parts
from benchmarks.episodes.other_encoders import OtherEncoder
from mapping.clip.fitted.encoder import calibrated
from mapping.trajectory_error import absolute_trajectory_error
from nav.frontier import FrontierSearch
from sim_stubs.homes.geometry.occupancy_slice import reachable
from sim_stubs.roomba.serial_line import BytesLostError
from sim_stubs.scoring.shortest_path import nearest_path_length
from sim_stubs.scoring.success import judge
from sim_stubs.world.world import World
from vizbot.config import Config
from vizbot.core.errors import DeviceError, VizbotError
from vizbot.core.geometry import yaw_of
from vizbot.core.interfaces import Devices
from vizbot.core.observer import GoalReport, Outcome, Step
from vizbot.core.types import SE3, OccupancyGrid
from vizbot.mission import drive_to_all
from vizbot.objectnav.belief_search import BeliefSearch
from vizbot.pipeline import Pipeline
from vizbot.rehearsal.rig import Rig
from vizbot.rig import open_encoder

if TYPE_CHECKING:  # its module loads torch
    from mapping.clip.encoder import ClipEncoder

LAST = 100
"""Number of steps before the limit of steps in which a robot that gets on gets somewhere."""
RADIUS = 0.5
"""Radius of the circle that it then has left [m]."""
log = logging.getLogger(__name__)
_TRACK_SPACING = 0.15


def is_stuck(outcome: Outcome | None, *, at_limit: bool, xy: NDArray[np.float64]) -> bool:
    """Whether a search that failed was stuck.

    It was where the robot says so itself, and where the limit of steps ended it in a place.

    Args:
        outcome: How the robot ended it; None after an error, which is no standstill.
        at_limit: Whether the limit of steps ended it.
        xy: True positions (N, 2) at its steps, the last of them where it ended [m].
    """
    if outcome is Outcome.STUCK:
        return True
    if not at_limit or outcome is None or len(xy) <= LAST:
        return False
    return enclosing_radius(xy[-LAST - 1 :]) <= RADIUS


def enclosing_radius(xy: NDArray[np.float64]) -> float:
    """Radius of the smallest circle around points (N, 2), of which there is one at least [m]."""
    near = (xy - xy[0]).astype(np.float32)  # far from the origin, single precision is too little
    _, radius = cv2.minEnclosingCircle(near)
    return float(radius)


class SeenFloor:
    """The floor that the robot's body can cover, by the true plan, and what its camera looked at.

    Floor counts as seen by the robot's own measure, but from where it truly stood, and among true
    obstacles.
    """

    def __init__(self, world: World, config: Config) -> None:
        """Nothing is seen yet."""
        free, plan = world.free
        start = plan.cell_of(*world.T_world_base[:2, 3].tolist())
        self._radius = config.navigator.costmap.robot_radius
        cells = 2 * round(self._radius / plan.resolution) + 1
        body = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (cells, cells))
        centres = np.zeros_like(free) if start is None else reachable(free, start)
        self._floor = cv2.dilate(centres.astype(np.uint8), body) > 0
        occupied = cv2.dilate(free.astype(np.uint8), body) == 0
        self._grid = OccupancyGrid(occupied.astype(np.float32), plan.resolution, plan.origin)
        self._frontiers = FrontierSearch(config.frontier)

    def look(self, T_world_base: SE3) -> None:
        """The camera takes a picture from here."""
        self._frontiers.look(self._grid, T_world_base, self._radius)

    @property
    def share(self) -> float:
        """Share of the floor that was seen, 0 to 1."""
        seen = self._frontiers.explored.mask_on(self._grid) & self._floor
        return float(seen.sum() / self._floor.sum()) if self._floor.any() else 0.0


def run_episode(job: tuple[Variant, Episode]) -> EpisodeResult:
    """Command the goals one after another, until one fails.

    An error counts as a failure of the goal and does not end the benchmark: episodes repeat
    exactly, so that a rerun would fail in the same place. Only where the machine loses bytes of
    the simulated serial line is an episode driven again, once: that is no failure of the robot.

    Raises:
        ConfigError: there is no such encoder.
        DeviceError: this machine cannot simulate a robot.
        VizbotError: bytes were lost twice.
    """
    try:
        return _driven(job)
    except BytesLostError:
        log.exception("%s, home %s, %s", job[0].name, job[1].home, job[1].goals)
    try:
        return _driven(job)
    except BytesLostError as error:
        raise VizbotError(
            f"this machine loses bytes of the simulated serial line ({error}); end other programs"
            " and run it again, what is finished is kept"
        ) from error


def _driven(job: tuple[Variant, Episode]) -> EpisodeResult:
    variant, episode = job
    began = time.monotonic()
    results: list[GoalResult] = []
    recorder: TruthRecorder | None = None
    text = episode.goals[0]
    if variant.oracle != "encoder":
        encoder_of(variant.config)  # no episode can run without an encoder
    try:
        with ExitStack() as opened:
            error = CalibrationError.drawn(episode)
            world = opened.enter_context(open_episode(episode, variant.config, error))
            parts = oracle_parts(variant.oracle, world, variant.config)
            devices = opened.enter_context(Rig(parts.config, "sim", "sim", world)).devices
            devices = slow_devices(devices, Latencies.kept(), parts.config, world.seed)
            if variant.oracle == "encoder":
                devices = replace(devices, clock=AtOnce(devices.clock))
            recorder = TruthRecorder(world, SeenFloor(world, variant.config))
            pipeline = _pipeline(parts, variant.encoder_scale, devices, recorder)
            if variant.ablated is not None:
                pipeline.map.search = BeliefSearch(
                    parts.config, pipeline.map.exploration.frontiers, ABLATIONS[variant.ablated]
                )
            if variant.oracle == "stop":
                pipeline = cast(Pipeline, PerfectStop(pipeline, devices, world))
            for text in _commanded(episode, world):
                results.append(_search_goal(text, pipeline, devices, recorder, parts.config))
                if not results[-1].success:
                    break
    except BytesLostError:
        raise
    except Exception as failure:
        if recorder is None and isinstance(failure, DeviceError):
            raise
        log.exception("%s, home %s, %s", variant.name, episode.home, episode.goals)
        if len(results) < episode.count and all(goal.success for goal in results):
            results.append(_error_result(text, failure))
    wall_seconds = round(time.monotonic() - began, 1)
    if recorder is None:
        stop = (0.0, 0.0, 0.0)
        return EpisodeResult(episode, tuple(results), 0, None, wall_seconds, (), stop)
    return EpisodeResult(
        episode,
        tuple(results),
        recorder.world.collisions,
        recorder.trajectory_error(),
        wall_seconds,
        recorder.track(),
        recorder.stop(),
    )


def _commanded(episode: Episode, world: World) -> Iterator[str]:
    """The goals of an episode, each one taken when the robot stands where the last one ended."""
    if episode.choose is None:
        yield from episode.goals
        return
    first, *left = episode.goals
    yield first
    for _ in range(episode.choose - 1):
        # The robot does not know how far a goal is: the truth only chooses the question.
        far = next((text for text in left if (nearest_path_length(world, text) or 0) > FAR), None)
        if far is None:
            return
        left.remove(far)
        yield far


@dataclass
class TruthRecorder:
    """An observer that records the true pose of the robot.

    Attributes:
        world: The simulated world.
        floor: What the robot has truly seen of it.
        said_seen: Share of the floor that the robot believes to have seen; None before it knows.
    """

    world: World
    floor: SeenFloor
    said_seen: float | None = None
    _stamps: list[float] = field(default_factory=list)
    _Ts_map_cam: list[SE3] = field(default_factory=list)
    _Ts_world_base: list[SE3] = field(default_factory=list)

    def on_step(self, step: Step) -> None:
        """Record the pose at the frame of the step; since then a decision may have taken time."""
        self._stamps.append(step.frame.stamp)
        self._Ts_map_cam.append(step.estimate.T_map_cam)
        self._Ts_world_base.append(self.world.T_world_pictured)
        self.floor.look(self.world.T_world_pictured)
        self.said_seen = step.seen_share

    def on_goal(self, report: GoalReport) -> None:
        """Do nothing: the benchmark calls the scorer."""

    def path_length(self) -> float:
        """True length of the path so far [m]."""
        return float(np.linalg.norm(np.diff(self.xy(), axis=0), axis=1).sum())

    def trajectory_error(self) -> float | None:
        """RMSE of the camera's online positions after alignment [m]; None for a run too short."""
        if len(self._stamps) < 3:
            return None
        stamps = np.array(self._stamps)
        truth = np.array(self._Ts_world_base) @ self.world.T_base_cam
        error = absolute_trajectory_error(stamps, np.array(self._Ts_map_cam), stamps, truth)
        return round(error, 4)

    def track(self) -> tuple[tuple[float, float], ...]:
        """True x, y of the path [m], one point every 0.15 m, rounded to 0.01 m."""
        kept: list[NDArray[np.float64]] = []
        for xy in self.xy():
            if not kept or np.linalg.norm(xy - kept[-1]) >= _TRACK_SPACING:
                kept.append(xy)
        return tuple((round(float(x), 2), round(float(y), 2)) for x, y in kept)

    def stop(self) -> tuple[float, float, float]:
        """True x, y [m] and yaw [rad] of the base now."""
        T = self.world.T_world_base
        return round(float(T[0, 3]), 3), round(float(T[1, 3]), 3), round(yaw_of(T), 3)

    def xy(self) -> NDArray[np.float64]:
        """True positions (N, 2) of the base at the steps so far, and now [m]."""
        Ts_world_base = [*self._Ts_world_base, self.world.T_world_base]
        return np.array(Ts_world_base)[:, :2, 3]


def _pipeline(
    parts: OracleParts,
    encoder_scale: EncoderScale | None,
    devices: Devices,
    recorder: TruthRecorder,
) -> Pipeline:
    encoder = parts.encoder
    if encoder is None:
        encoder = encoder_of(parts.config)
    if encoder_scale is not None:
        encoder = OtherEncoder(encoder, encoder_scale)
    return Pipeline(devices, encoder, parts.config, [recorder], parts.perception)


def encoder_of(config: Config) -> ClipEncoder:
    """The encoder of a configuration, loaded once in a process.

    It has the numbers of the belief that come along, or those of the file that is named: results
    depend on none that a user happens to have.
    """
    return _encoder(config.clip, config.device, config.half, config.clip_calibration)


@lru_cache(maxsize=1)
def _encoder(name: str, device: str, half: bool, calibration: str) -> ClipEncoder:
    encoder = open_encoder(name, device, half)
    return calibrated(encoder, Path(calibration)) if calibration else encoder


def _search_goal(
    text: str, pipeline: Pipeline, devices: Devices, recorder: TruthRecorder, config: Config
) -> GoalResult:
    shortest = nearest_path_length(recorder.world, text)
    steps, length, began = pipeline.steps, recorder.path_length(), devices.clock.now()
    stopped, outcome = False, None
    try:
        [report] = drive_to_all(
            pipeline, devices, [pipeline.goal(text)], config.objectnav.max_steps
        )
        outcome, answer = report.outcome, report.reason
        stopped = outcome is Outcome.ARRIVED
    except BytesLostError:
        raise
    except Exception as error:  # the scorer still judges where the robot stands
        log.exception("on the way to %s", text)
        answer = error_line(error)
    verdict = judge(recorder.world, text, stopped=stopped)
    taken, limit = pipeline.steps - steps, config.objectnav.max_steps
    at_limit = outcome is Outcome.GAVE_UP and taken >= limit
    xy = recorder.xy()[-taken - 1 :]
    return GoalResult(
        text,
        verdict.success,
        stopped,
        verdict.reason,
        answer,
        None if verdict.distance is None else round(verdict.distance, 3),
        taken,
        round(recorder.path_length() - length, 3),
        None if shortest is None else round(shortest, 3),
        round(devices.clock.now() - began, 2),
        outcome,
        None if recorder.said_seen is None else round(recorder.said_seen, 3),
        round(recorder.floor.share, 3),
        not verdict.success and is_stuck(outcome, at_limit=at_limit, xy=xy),
    )


def error_line(error: Exception) -> str:
    """An error in one line, for tables."""
    return f"error: {type(error).__name__}: {' '.join(str(error).split())}"


def _error_result(text: str, error: Exception) -> GoalResult:
    """The result of a goal for which the scorer could not run."""
    return GoalResult(
        text,
        success=False,
        claimed=False,
        reason="ended by an error",
        answer=error_line(error),
        distance=None,
        steps=0,
        path_length=0.0,
        shortest_path=None,
        simulated_seconds=0.0,
        stuck=False,
    )
