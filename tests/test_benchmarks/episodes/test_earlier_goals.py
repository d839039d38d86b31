"""What was seen on the way to the earlier goals of a mission is used for the later ones."""

import numpy as np
import pytest

from benchmarks.episodes import run as runs
from benchmarks.episodes.calibration_error import EXACT
from benchmarks.episodes.episode import Episode
from sim_stubs.homes.floor_plan.walls import RectangularRoom, build_structure
from sim_stubs.homes.furniture import procedural
from sim_stubs.homes.geometry.house import House, Instance
from tests.test_benchmarks.episodes.one_room import true_encoder


def thing(label, x, yaw):
    return Instance(f"{label}#1", procedural.piece(label, np.random.default_rng(0)), x, 2.0, yaw)


@pytest.fixture
def room(monkeypatch):
    """A room in which the robot faces a sofa and has a bathtub behind it."""
    living = RectangularRoom("living room", 0, 0, 6, 4, (0.5, 0.4, 0.3), 1.0, (0.6, 0.6, 0.6))
    things = thing("sofa", 5.4, -np.pi / 2), thing("bathtub", 0.6, np.pi / 2)
    lights = np.array([[3.0, 2.0, 2.3]])
    house = House((living.room,), build_structure((living,), ()), things, lights, (3.0, 2.0, 0.0))
    monkeypatch.setattr(
        runs, "open_episode", lambda episode, config, error=EXACT: error.world(house, config, 3)
    )


def test_a_later_goal_that_was_seen_before_is_driven_to_at_once(room):
    """It takes 23 steps; one that forgets looks for it first, and takes 32."""
    job = true_encoder(80), Episode(1100, ("bathtub", "sofa"))
    bathtub, sofa = runs.run_episode(job).goals
    assert bathtub.success and sofa.success
    assert sofa.steps < 28
