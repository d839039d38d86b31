"""How much of the floor was truly seen, beside what the robot says of it."""

import numpy as np
import pytest

from benchmarks.episodes import run as runs
from benchmarks.episodes.calibration_error import EXACT
from benchmarks.episodes.episode import Episode
from benchmarks.episodes.run import SeenFloor
from tests.test_benchmarks.episodes.one_room import true_encoder
from vizbot.core.geometry import planar
from vizbot.core.observer import Outcome

VARIANT = true_encoder(120)


def test_what_the_camera_faces_from_where_it_truly_stands_is_seen(kitchen):
    with EXACT.world(kitchen, VARIANT.config, 3) as world:
        floor = SeenFloor(world, VARIANT.config)
        assert floor.share == 0.0
        T_world_base = world.T_world_base
        shares = []
        for turn in (0.0, 0.0, np.pi / 2, np.pi, -np.pi / 2):
            floor.look(T_world_base @ planar(0.0, 0.0, turn))
            shares.append(floor.share)
    assert 0.1 < shares[0] == shares[1] < shares[2] < shares[3] < shares[4] <= 1.0


def test_what_it_says_that_it_has_seen_is_within_ten_points_of_the_truth(kitchen, monkeypatch):
    monkeypatch.setattr(
        runs, "open_episode", lambda episode, config, error=EXACT: error.world(kitchen, config, 3)
    )
    [goal] = runs.run_episode((VARIANT, Episode(1100, ("elephant",)))).goals
    assert goal.outcome is Outcome.NOT_FOUND
    assert goal.truly_seen > 0.5
    assert goal.said_seen == pytest.approx(goal.truly_seen, abs=0.1)
