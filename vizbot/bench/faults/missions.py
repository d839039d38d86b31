"""Whole missions in benchmark homes in which something goes wrong on the way to the goal."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass

import numpy as np

from sim_stubs.clock import SimulatedClock
from sim_stubs.faults.catalogue import CATALOGUE
from sim_stubs.faults.faulty_encoder import FaultyEncoder
from sim_stubs.faults.faulty_program import FaultyObserver
from sim_stubs.scoring.shortest_path import nearest_path_length
from sim_stubs.scoring.success import judge
from vizbot.bench.episodes.episode import Episode
from vizbot.bench.episodes.homes import open_episode, survey
from vizbot.bench.episodes.run import encoder_of
from vizbot.bench.faults.minimal_robot import LogObserver, is_kept
from vizbot.bench.faults.monitor import FaultMonitor, FaultStop
from vizbot.bench.faults.run import not_for_ever, plan_faults, run_to_end
from vizbot.bench.harness.board import UNATTENDED
from vizbot.config import Config
from vizbot.core.observer import Observer, Outcome
from vizbot.pipeline import Pipeline
from vizbot.rig import Rig

HOMES = (1000, 1001, 1002)
FARTHEST = 10.0
"""Way to a goal [m]."""
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
"""What happens together in houses: somebody lifts the robot and the lamp blinds it; the plug of the
hub is pulled; the carpet slips under wheels in glaring sun."""
_BEGINS = (8.0, 25.0)
"""When the first fault is due [s]."""
_HUNG = 3600.0
"""A mission that takes longer on this machine hangs [s]."""


@dataclass(frozen=True, slots=True)
class FaultMission:
    """What is asked for, and what goes wrong.

    Attributes:
        home: Seed.
        goal: In words.
        faults: Names; none for the same mission undisturbed.
    """

    home: int
    goal: str
    faults: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class FaultMissionResult:
    """What became of it.

    Attributes:
        mission: Which.
        happened: Whether all faults showed before it ended.
        reached: The scorer's verdict.
        answer: What the robot said in the end.
        steps: Runs of Algorithm 1.
        stops: As in `fault_drives`.
        crash: What ended the program; empty where nothing did.
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
        """Whether its faults allow it."""
        return all(CATALOGUE[name].goal for name in self.mission.faults)


@dataclass(frozen=True, slots=True)
class NearGoals:
    """What can be asked for in a home and is near.

    Attributes:
        home: Seed.
        goals: Within FARTHEST [m] of the start that is drawn for them.
    """

    home: int
    goals: tuple[str, ...]


def near_goals(home: int) -> NearGoals:
    """Measure the ways."""
    near = []
    for goal in survey(home).goals:
        with open_episode(Episode(home, (goal,)), Config()) as world:
            length = nearest_path_length(world, goal)
        if length is not None and length <= FARTHEST:
            near.append(goal)
    return NearGoals(home, tuple(near))


def missions_in(near: Sequence[NearGoals], quick: bool = False) -> list[FaultMission]:
    """Every fault in each home, the pairs in the first, and each of these goals undisturbed."""
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
    plain = dict.fromkeys(FaultMission(m.home, m.goal, ()) for m in missions)
    return [*plain, *missions]


def run_mission(mission: FaultMission) -> FaultMissionResult:
    """Drive to the goal, whatever happens on the way."""
    config = UNATTENDED
    encoder = encoder_of(config)
    rng = np.random.default_rng((mission.home, *mission.goal.encode(), len(mission.faults)))
    planned = plan_faults(mission.faults, _BEGINS, math.inf, rng)
    with ExitStack() as opened:
        world = opened.enter_context(open_episode(Episode(mission.home, (mission.goal,)), config))
        rig = opened.enter_context(Rig(config, "sim", "sim", world, faults=planned))
        clock = rig.devices.clock
        assert isinstance(clock, SimulatedClock)
        observers: list[Observer] = []
        diary = watch = None
        if rig.schedule is not None and rig.faulty_base is not None:
            encoder = FaultyEncoder(encoder, rig.schedule)
            diary = LogObserver(rig.schedule, clock.now)
            observers = [diary, FaultyObserver(LogObserver(rig.schedule, clock.now), rig.schedule)]
            watch = FaultMonitor(rig.faulty_base, rig.schedule, clock, 1.0 / config.sim_camera.rate)
            clock.attach(watch)
        pipeline = Pipeline(rig.devices, encoder, config, observers)
        goal = pipeline.goal(mission.goal)
        with not_for_ever(_HUNG):
            outcome, reason, crash = run_to_end(
                pipeline,
                rig.devices,
                goal,
                diary,
                watch,
                lambda: pipeline.steps >= config.objectnav.max_steps,
            )
        verdict = judge(world, mission.goal, stopped=outcome is Outcome.ARRIVED)
        return FaultMissionResult(
            mission,
            watch is None or watch.happened,
            verdict.success,
            verdict.reason if outcome is Outcome.ARRIVED else reason,
            pipeline.steps,
            () if watch is None else watch.stops(),
            crash,
            True if diary is None else is_kept(pipeline, diary),
        )
