"""The benchmark homes: the goals that exist in them, and the start of an episode."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from benchmarks.episodes.calibration_error import EXACT, CalibrationError
from benchmarks.episodes.episode import Episode, Home, HomeGoals, seed_of_home
from sim_stubs.homes.geometry.house import House, Instance
from sim_stubs.homes.home import home
from sim_stubs.homes.start_pose import start_for
from sim_stubs.scoring.success import goals_of, instances_of
from sim_stubs.world.bare import bare
from sim_stubs.world.world import World
from sim_stubs.world.world_file import read_world
from sim_stubs.world.world_spec import is_bare, seed_of
from vizbot.config import Config
from vizbot.core.errors import ConfigError
from vizbot.rehearsal.config import RehearsalConfig

FIRST_HOME = 1000
"""Seed of the first benchmark home; homes are taken in order and none is skipped."""
OWN_SHAPE = "own shape: "
"""Beginning of the name of a model that our program drew."""
_NOISE_APART = 1_000_000
"""Far above any seed of a home, so that no two episodes share their noise."""


@lru_cache(maxsize=1)
def house_of(name: Home) -> House:
    """The house of a home, made once where it is asked for several times in turn."""
    seed = name if isinstance(name, int) else seed_of(name)
    if seed is None:
        return read_world(Path(str(name)))
    return bare(home(seed)) if is_bare(str(name)) else home(seed)


def survey(name: Home) -> HomeGoals:
    """The goals that exist in a home, and the models of furniture that count as them.

    In a home drawn by others a goal counts only where an episode can start far enough from it; ours
    are drawn so that it can.
    """
    house, seed = house_of(name), seed_of_home(name)
    with World(house, RehearsalConfig().world, seed=seed) as world:
        goals = tuple(goals_of(world))
        if isinstance(name, str):
            goals = tuple(g for g in goals if start_for(house, g, np.random.default_rng(seed)))
        models = {
            (goal, _model(world.instances[i], name))
            for goal in goals
            for i in instances_of(world, goal)
        }
    return HomeGoals(name, goals, tuple(sorted(models)))


def _model(instance: Instance, name: Home) -> str:
    """The model of the catalogue, or the name of a shape of our own; a home has one without name.

    That is its stairs, which are built in their place.
    """
    piece = instance.piece
    return piece.attribution or OWN_SHAPE + (piece.shape or f"{instance.label} of home {name}")


def open_benchmark_home(name: Home, config: Config, error: CalibrationError = EXACT) -> World:
    """A home with the robot at its entrance, as for `dry-run --explore` but for `error`."""
    return error.world(house_of(name), config, seed_of_home(name))


def open_episode(episode: Episode, config: Config, error: CalibrationError = EXACT) -> World:
    """The home of an episode with the robot where it begins.

    Number 0 without an error has the world of `vizbot dry-run GOAL --world HOME`.

    Raises:
        ConfigError: no place is far enough from the first goal.
    """
    house, seed = house_of(episode.home), seed_of_home(episode.home)
    world_seed = seed + _NOISE_APART * episode.number
    return error.world(replace(house, start=start_of(episode)), config, world_seed)


def start_of(episode: Episode) -> tuple[float, float, float]:
    """Where the robot begins an episode: x, y [m], yaw [rad] in the world.

    Raises:
        ConfigError: no place is far enough from the first goal.
    """
    goal = episode.goals[0]
    rng = np.random.default_rng((seed_of_home(episode.home), 3, episode.number))
    start = start_for(house_of(episode.home), goal, rng)
    if start is None:
        message = f"home {episode.home} has no start for {goal!r}"
        raise ConfigError(f"{message}, which is a bug; report it")
    return start
