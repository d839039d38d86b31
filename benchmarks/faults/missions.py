"""Missions in benchmark homes in which faults happen on the path to the goal."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass

import numpy as np

from benchmarks.episodes.calibration_error import CalibrationError
from benchmarks.episodes.episode import Episode
from benchmarks.episodes.homes import open_episode, survey
from benchmarks.episodes.latency import Latencies, slow_devices
from benchmarks.episodes.run import encoder_of
from benchmarks.faults.minimal_robot import LogObserver, map_survives
from benchmarks.faults.monitor import FaultMonitor, FaultStop
from benchmarks.faults.run import limit_wall_time, plan_faults, run_to_end
from benchmarks.faults.scores import RESTS_BY_DEFAULT, ended_by_default
from benchmarks.harness.bench_plan import UNATTENDED
from sim_stubs.faults.catalogue import CATALOGUE
from sim_stubs.faults.faulty_program import FaultyEncoder, FaultyObserver
from sim_stubs.scoring.shortest_path import nearest_path_length
from sim_stubs.scoring.success import judge
from vizbot.config import Config
from vizbot.core.observer import Observer, Outcome
from vizbot.core.simulated_clock import SimulatedClock
from vizbot.perception.interfaces import PerceptionParts
from vizbot.pipeline import Pipeline
from vizbot.rehearsal.config import RehearsalConfig
from vizbot.rehearsal.rig import Rig

HOMES = (1000, 1001, 1002)
FARTHEST = 10.0
"""Longest path to a goal [m]."""
PAIRS = (
    ("bump", "camera-frozen"),
    ("bump", "lost-bytes"),
    ("cliff", "stream-silent"),
    ("cliff", "mode-passive"),
    ("wheel-drop", "camera-frozen"),
    ("wheel-drop", "overexposed"),
    ("wheel-slip", "overexposed"),
    ("wheel-slip", "imu-gap"),
    ("stuck-wheel", "black-depth"),
    ("encoder-jump", "overexposed"),
    ("port-vanishes", "camera-vanishes"),
    ("port-vanishes", "half-rate"),
    ("base-asleep", "encoder-slow"),
    ("mode-off-by-one", "bump"),
    ("mode-off-by-one", "cliff"),
    ("kidnapped", "imu-gap"),
    ("kidnapped", "half-rate"),
    ("depth-holes", "unpaired-frames"),
    ("stamps-jump", "imu-gap"),
    ("encoder-out-of-memory", "disk-full"),
)
"""Faults that happen together in houses: somebody lifts the robot and a lamp blinds it; the plug of
the hub is pulled; a carpet slips under the wheels in glaring sun."""
_BEGINS = (8.0, 25.0)
"""Earliest and latest time at which the first fault is due [s]."""
_HUNG = 3600.0
"""Wall time after which a mission counts as hung [s]."""


@dataclass(frozen=True, slots=True)
class FaultMission:
    """A mission with faults.

    Attributes:
        home: Seed of the home.
        goal: The goal in words.
        faults: Names of the faults; none for the same mission undisturbed.
        by_default: Whether the robot has the product's settings; else it resumes Safe mode by
            itself.
    """

    home: int
    goal: str
    faults: tuple[str, ...]
    by_default: bool = False


@dataclass(frozen=True, slots=True)
class FaultMissionResult:
    """How a mission ended.

    Attributes:
        mission: The mission.
        happened: Whether all faults showed before it ended.
        reached: The scorer's verdict.
        answer: The robot's last message.
        steps: Runs of Algorithm 1.
        stops: How the wheels stopped for each fault.
        crash: The error that ended the program; empty without one.
        map_kept: Whether the map could be saved and loaded; None where that is not tried.
    """

    mission: FaultMission
    happened: bool
    reached: bool
    answer: str
    steps: int
    stops: tuple[FaultStop, ...]
    crash: str
    map_kept: bool | None

    @property
    def should_arrive(self) -> bool:
        """Whether the faults allow the robot to reach the goal."""
        return all(CATALOGUE[name].goal for name in self.mission.faults)

    @property
    def ended_by_default(self) -> bool:
        """Whether it ended as the product's settings demand for its fault, with their reason."""
        mission = self.mission
        given_up = mission.by_default and self.happened and not self.reached
        return given_up and ended_by_default(mission.faults, self.answer)

    @property
    def right_by_default(self) -> bool:
        """Whether it ended so, or reached its goal where its fault lets it drive on unasked."""
        rests = self.happened and any(name in RESTS_BY_DEFAULT for name in self.mission.faults)
        return self.ended_by_default or (self.reached and not rests)


@dataclass(frozen=True, slots=True)
class NearGoals:
    """The near goals of a home.

    Attributes:
        home: Seed of the home.
        goals: Goals whose path from their start is at most FARTHEST [m] long.
    """

    home: int
    goals: tuple[str, ...]


def near_goals(home: int) -> NearGoals:
    """Measure the shortest paths to the goals of a home."""
    near = []
    for goal in survey(home).goals:
        with open_episode(Episode(home, (goal,)), Config()) as world:
            length = nearest_path_length(world, goal)
        if length is not None and length <= FARTHEST:
            near.append(goal)
    return NearGoals(home, tuple(near))


def missions_in(near: Sequence[NearGoals], quick: bool = False) -> list[FaultMission]:
    """Each goal undisturbed, every fault in each home, and the pairs in the first home."""
    faults = list(CATALOGUE)[::6] if quick else list(CATALOGUE)
    homes = near[:1] if quick else near
    missions = [
        FaultMission(home.home, home.goals[number % len(home.goals)], (name,))
        for home in homes
        for number, name in enumerate(faults)
    ]
    first = homes[0]
    missions += [
        FaultMission(first.home, first.goals[number % len(first.goals)], pair)
        for number, pair in enumerate(PAIRS[::8] if quick else PAIRS)
    ]
    undisturbed = dict.fromkeys(FaultMission(m.home, m.goal, ()) for m in missions)
    return [*undisturbed, *missions]


def run_mission(mission: FaultMission) -> FaultMissionResult:
    """Run a mission with its faults."""
    config = Config() if mission.by_default else UNATTENDED
    encoder = encoder_of(config)
    rng = np.random.default_rng((mission.home, *mission.goal.encode(), len(mission.faults)))
    planned = plan_faults(mission.faults, _BEGINS, math.inf, rng)
    with ExitStack() as opened:
        episode = Episode(mission.home, (mission.goal,))
        error = CalibrationError.drawn(episode)
        world = opened.enter_context(open_episode(episode, config, error))
        rig = opened.enter_context(Rig(config, "sim", "sim", world, faults=planned))
        clock = rig.devices.clock
        assert isinstance(clock, SimulatedClock)
        devices = slow_devices(rig.devices, Latencies.kept(), config, world.seed)
        observers: list[Observer] = []
        observer = monitor = None
        if rig.schedule is not None and rig.faulty_base is not None:
            encoder = FaultyEncoder(encoder, rig.schedule)
            observer = LogObserver(rig.schedule, clock.now)
            observers = [
                observer,
                FaultyObserver(LogObserver(rig.schedule, clock.now), rig.schedule),
            ]
            rate = RehearsalConfig.read(config).sim_camera.rate
            monitor = FaultMonitor(rig.faulty_base, rig.schedule, clock, 1.0 / rate)
            clock.attach(monitor)
        parts = PerceptionParts(every_pose=True)
        pipeline = Pipeline(devices, encoder, config, observers, parts)
        goal = pipeline.goal(mission.goal)
        with limit_wall_time(_HUNG):
            outcome, reason, crash = run_to_end(
                pipeline,
                devices,
                goal,
                observer,
                monitor,
                lambda: pipeline.steps >= config.objectnav.max_steps,
            )
        verdict = judge(world, mission.goal, stopped=outcome is Outcome.ARRIVED)
        return FaultMissionResult(
            mission,
            monitor is None or monitor.happened,
            verdict.success,
            verdict.reason if outcome is Outcome.ARRIVED else reason,
            pipeline.steps,
            () if monitor is None else monitor.stops(),
            crash,
            True if observer is None else map_survives(pipeline, observer),
        )
