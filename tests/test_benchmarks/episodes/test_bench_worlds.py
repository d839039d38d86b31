from dataclasses import replace

import numpy as np
import pytest

from benchmarks.episodes import homes as worlds
from benchmarks.episodes.episode import Episode
from sim_stubs.homes.floor_plan.walls import RectangularRoom, build_structure
from sim_stubs.homes.geometry.house import House, Instance
from sim_stubs.homes.geometry.occupancy_slice import FreeSpace
from sim_stubs.homes.geometry.solids import Piece
from sim_stubs.world import world_name as worlds_of_dry_runs
from sim_stubs.world.body import WorldConfig
from sim_stubs.world.world import MOUNT
from sim_stubs.world.world_name import open_world
from vizbot.config import Config
from vizbot.core.errors import ConfigError


@pytest.fixture(autouse=True)
def two_rooms(monkeypatch):
    """For every seed: a kitchen on the left, a hallway on the right, a doorway between."""
    kitchen = RectangularRoom("kitchen", 0, 0, 3, 3, (0.5, 0.4, 0.3), 1.0, (0.6, 0.6, 0.6))
    hallway = RectangularRoom("hallway", 3, 0, 9, 3, (0.5, 0.4, 0.3), 1.0, (0.6, 0.6, 0.6))
    parts = build_structure((hallway,), ())
    lights = np.array([[4.0, 1.5, 2.3]])
    house = House((kitchen.room, hallway.room), parts, (), lights, (7.0, 1.5, 0.0))
    monkeypatch.setattr(worlds, "home", lambda seed: house)
    space = FreeSpace.from_house(house)
    monkeypatch.setattr(worlds_of_dry_runs, "home_and_space", lambda seed: (house, space))
    worlds.house_of.cache_clear()
    cached = worlds.house_of
    yield
    cached.cache_clear()


def start(number=0):
    with worlds.open_episode(Episode(1000, ("kitchen",), number), Config()) as world:
        return world.T_world_base, world.seed


def test_an_episode_starts_as_a_dry_run_does():
    with open_world("1000", WorldConfig(), MOUNT, "kitchen") as dry_run:
        at, seed = start()
        assert np.array_equal(at, dry_run.T_world_base)
        assert seed == dry_run.seed


def test_another_number_has_another_start_and_other_noise():
    (first, seed), (second, other) = start(1), start(2)
    assert not np.allclose(first, second)
    assert len({1000, seed, other}) == 3


def test_a_goal_without_a_start_is_an_error():
    with pytest.raises(ConfigError, match="home 1000 has no start for 'hallway'"):
        worlds.open_episode(Episode(1000, ("hallway",)), Config())


def test_a_survey_names_what_the_home_has():
    surveyed = worlds.survey(1000)
    assert surveyed.goals == ("kitchen", "hallway")
    assert surveyed.models == ()  # rooms are no models


def test_a_survey_names_each_model_once_under_every_goal_that_it_counts_as(monkeypatch):
    def piece(label, attribution):
        return Piece(label, "Seat", np.ones(3), (), attribution)

    chair, red = piece("chair", "Seat by A"), piece("red chair", "Seat by A")
    pieces = (chair, red, piece("armchair", "Seat by B"), piece("stairs", ""), piece("oven", ""))
    instances = tuple(Instance(f"it#{i}", each, 5.0, 1.5, 0.0) for i, each in enumerate(pieces))
    furnished = replace(worlds.house_of(1000), instances=instances)
    monkeypatch.setattr(worlds, "house_of", lambda seed: furnished)
    monkeypatch.setattr(worlds, "goals_of", lambda world: ["chair", "stairs", "kitchen"])
    assert worlds.survey(1000).models == (
        ("chair", "Seat by A"), ("chair", "Seat by B"), ("stairs", "own shape: stairs of home 1000")
    )  # fmt: skip
