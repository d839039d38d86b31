"""One episode, run as `vizbot dry-run` runs it and scored from the world's truth."""

from __future__ import annotations

import logging
import time
from contextlib import ExitStack
from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mapping.trajectory_error import absolute_trajectory_error
from sim_stubs.scoring.shortest_path import nearest_path_length
from sim_stubs.scoring.success import judge
from sim_stubs.world.world import World
from vizbot.bench.episodes.episode import Episode, EpisodeResult, GoalResult, Variant
from vizbot.bench.episodes.homes import open_episode
from vizbot.bench.episodes.oracles import Truths, truths
from vizbot.config import Config
from vizbot.core.devices import Devices
from vizbot.core.errors import DeviceError
from vizbot.core.geometry import yaw_of
from vizbot.core.observer import GoalReport, Outcome, Step
from vizbot.core.types import SE3
from vizbot.mission import drive_to_all
from vizbot.pipeline import Pipeline
from vizbot.rig import Rig, open_encoder

if TYPE_CHECKING:  # its module loads torch
    from mapping.clip.encoder import ClipEncoder

log = logging.getLogger(__name__)

_TRACK_SPACING = 0.15


def run_episode(job: tuple[Variant, Episode]) -> EpisodeResult:
    """Tell the goals one after another, until one fails.

    Whatever goes wrong costs the goal that was told, not the board: episodes repeat exactly, so a
    rerun would end at the same place.

    Raises:
        ConfigError: there is no such encoder.
        DeviceError: this machine cannot simulate a robot.
    """
    variant, episode = job
    began = time.monotonic()
    results: list[GoalResult] = []
    witness: TruthRecorder | None = None
    if variant.counterpart != "encoder":
        encoder_of(variant.config)  # without one no episode can be run
    try:
        with ExitStack() as opened:
            world = opened.enter_context(open_episode(episode, variant.config))
            true = truths(variant.counterpart, world, variant.config)
            rig = opened.enter_context(Rig(true.config, "sim", "sim", world))
            witness = TruthRecorder(world)
            pipeline = _pipeline(true, rig.devices, witness)
            for text in episode.goals:
                results.append(_go_to(text, pipeline, rig.devices, witness, true.config))
                if not results[-1].success:
                    break
    except Exception as error:
        if witness is None and isinstance(error, DeviceError):
            raise
        log.exception("%s, home %d, %s", variant.name, episode.home, episode.goals)
        if len(results) < len(episode.goals) and all(goal.success for goal in results):
            results.append(_broken(episode.goals[len(results)], error))
    wall_seconds = round(time.monotonic() - began, 1)
    if witness is None:
        stop = (0.0, 0.0, 0.0)
        return EpisodeResult(episode, tuple(results), 0, None, wall_seconds, (), stop)
    return EpisodeResult(
        episode,
        tuple(results),
        witness.world.collisions,
        witness.trajectory_error(),
        wall_seconds,
        witness.track(),
        witness.stop(),
    )


@dataclass
class TruthRecorder:
    """An observer that writes down where the robot truly is.

    Attributes:
        world: The truth.
    """

    world: World
    _stamps: list[float] = field(default_factory=list)
    _Ts_map_cam: list[SE3] = field(default_factory=list)
    _Ts_world_base: list[SE3] = field(default_factory=list)

    def on_step(self, step: Step) -> None:
        """Nothing moves between a frame and the end of its step."""
        self._stamps.append(step.frame.stamp)
        self._Ts_map_cam.append(step.estimate.T_map_cam)
        self._Ts_world_base.append(self.world.T_world_base)

    def on_goal(self, report: GoalReport) -> None:
        """The scorer is asked by the benchmark."""

    def path_length(self) -> float:
        """Truly driven so far [m]."""
        return float(np.linalg.norm(np.diff(self._xy(), axis=0), axis=1).sum())

    def trajectory_error(self) -> float | None:
        """RMSE of the camera's positions as known at the time, after alignment [m]."""
        if len(self._stamps) < 3:
            return None
        stamps = np.array(self._stamps)
        truth = np.array(self._Ts_world_base) @ self.world.T_base_cam
        error = absolute_trajectory_error(stamps, np.array(self._Ts_map_cam), stamps, truth)
        return round(error, 4)

    def track(self) -> tuple[tuple[float, float], ...]:
        """The true way, a point every 0.15 m, to the centimetre."""
        kept: list[NDArray[np.float64]] = []
        for xy in self._xy():
            if not kept or np.linalg.norm(xy - kept[-1]) >= _TRACK_SPACING:
                kept.append(xy)
        return tuple((round(float(x), 2), round(float(y), 2)) for x, y in kept)

    def stop(self) -> tuple[float, float, float]:
        """True x, y [m] and yaw [rad] of the base now."""
        T = self.world.T_world_base
        return round(float(T[0, 3]), 3), round(float(T[1, 3]), 3), round(yaw_of(T), 3)

    def _xy(self) -> NDArray[np.float64]:
        Ts_world_base = [*self._Ts_world_base, self.world.T_world_base]
        return np.array(Ts_world_base)[:, :2, 3]


def _pipeline(true: Truths, devices: Devices, witness: TruthRecorder) -> Pipeline:
    encoder = true.encoder
    if encoder is None:
        encoder = encoder_of(true.config)
    return Pipeline(devices, encoder, true.config, [witness], true.slam, true.depth_mapper)


def encoder_of(config: Config) -> ClipEncoder:
    """The encoder of a configuration, loaded once in a process."""
    return _encoder(config.clip, config.device, config.half)


@lru_cache(maxsize=1)
def _encoder(name: str, device: str, half: bool) -> ClipEncoder:
    return open_encoder(name, device, half)


def _go_to(
    text: str, pipeline: Pipeline, devices: Devices, witness: TruthRecorder, config: Config
) -> GoalResult:
    shortest = nearest_path_length(witness.world, text)
    steps, length, began = pipeline.steps, witness.path_length(), devices.clock.now()
    stopped = False
    try:
        [report] = drive_to_all(
            pipeline, devices, [pipeline.goal(text)], config.objectnav.max_steps
        )
        stopped, answer = report.outcome is Outcome.ARRIVED, report.reason
    except Exception as error:  # where it stands is judged all the same
        log.exception("on the way to %s", text)
        answer = told(error)
    verdict = judge(witness.world, text, stopped=stopped)
    return GoalResult(
        text,
        verdict.success,
        stopped,
        verdict.reason,
        answer,
        None if verdict.distance is None else round(verdict.distance, 3),
        pipeline.steps - steps,
        round(witness.path_length() - length, 3),
        None if shortest is None else round(shortest, 3),
        round(devices.clock.now() - began, 2),
    )


def told(error: Exception) -> str:
    """An error in one line, for tables."""
    return f"error: {type(error).__name__}: {' '.join(str(error).split())}"


def _broken(text: str, error: Exception) -> GoalResult:
    """What became of a goal where not even the scorer could be asked."""
    return GoalResult(
        text,
        success=False,
        claimed=False,
        reason="ended by an error",
        answer=told(error),
        distance=None,
        steps=0,
        path_length=0.0,
        shortest_path=None,
        simulated_seconds=0.0,
    )
