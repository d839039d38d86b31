"""A room is explored once, and its map asked by every scale set."""

import numpy as np
import pytest

from sim_stubs.homes.floor_plan.walls import RectangularRoom, build_structure
from sim_stubs.homes.furniture import procedural
from sim_stubs.homes.geometry.house import House, Instance
from sim_stubs.scoring.goals import GOALS
from vizbot.bench.episodes import exploration
from vizbot.bench.episodes.calibration_error import EXACT
from vizbot.bench.episodes.exploration import SCALE_SETS
from vizbot.bench.objectnav.single_goal import with_scales
from vizbot.config import Config
from vizbot.core.geometry import invert, transform
from vizbot.objectnav.tasks import Task
from vizbot.perception.sightings import Sightings

CONFIG = Config.model_validate({"objectnav": {"max_exploration_steps": 3}})


@pytest.fixture(autouse=True)
def small_home(monkeypatch, mean_colours):
    room = RectangularRoom("kitchen", 0, 0, 4, 3, (0.5, 0.4, 0.3), 1.0, (0.6, 0.6, 0.6))
    sofa = Instance(
        "sofa#1", procedural.piece("sofa", np.random.default_rng(0)), 2.9, 1.5, -np.pi / 2
    )
    lights = np.array([[2.0, 1.5, 2.3]])
    house = House((room.room,), build_structure((room,), ()), (sofa,), lights, (0.9, 1.5, 0.0))
    opened = []

    def open_benchmark_home(seed, config, error=EXACT):
        opened.append(seed)
        return error.world(house, config, seed)

    monkeypatch.setattr(exploration, "open_benchmark_home", open_benchmark_home)
    monkeypatch.setattr(exploration, "encoder_of", lambda config: mean_colours)


def test_every_goal_is_asked_by_every_scale_set_and_scored_by_the_truth(tmp_path, monkeypatch):
    job = (with_scales(CONFIG, SCALE_SETS[-1]), 1000, tmp_path / "maps" / "home-1000")
    ended, answers = exploration.explore_and_ask(job)
    assert (ended.home, ended.explored, ended.steps) == (1000, False, 3)
    assert ended.reason == "not done within 3 steps"
    assert len(answers) == len(SCALE_SETS) * len(GOALS)
    assert {answer.home for answer in answers} == {1000}
    assert {answer.text for answer in answers if answer.exists} == {"sofa", "kitchen"}
    kitchens = [answer for answer in answers if answer.text == "kitchen"]
    assert all(answer.correct for answer in kitchens)  # there is nothing else
    assert not any(answer.correct for answer in answers if not answer.exists)
    x, y = np.array([answer.position for answer in answers]).T
    assert ((x > 0) & (x < 4.1) & (y > -0.1) & (y < 3.1)).all()

    def explored_again(*_):
        raise AssertionError

    monkeypatch.setattr(exploration, "explore", explored_again)
    assert exploration.explore_and_ask(job) == (ended, answers)


@pytest.mark.parametrize(
    ("text", "right"), [("sofa", True), ("bed", False)], ids=["the home has it", "it has not"]
)
def test_an_answer_is_right_where_the_thing_is_and_wrong_elsewhere(text, right):
    with exploration.open_benchmark_home(1000, CONFIG) as world:
        T_world_map = world.T_world_base
        points = transform(invert(T_world_map), np.array([[2.9, 1.5, 0.4], [0.3, 0.3, 0.4]]))
        alike, number = np.zeros(2, np.int32), np.arange(2, dtype=np.int32)
        query = exploration._Query(text, right, (0,), 0.3)
        for likely, correct in (((0.8, 0.4), right), ((0.4, 0.8), False)):
            sightings = Sightings(
                points, np.array(likely, np.float32), number, number, points[:, :2],
                alike.astype(np.float32),
            )  # fmt: skip
            answer = exploration._ask(query, sightings, world, T_world_map, CONFIG)
            assert (answer.correct, answer.most_similar_correct) == (correct, correct)
            assert answer.similarity == pytest.approx(0.8)


def test_what_was_mapped_before_an_error_is_asked(tmp_path, monkeypatch):
    def broken(pipeline, devices, max_steps):
        pipeline.tick(Task.EXPLORE)
        raise ZeroDivisionError("division by zero")

    monkeypatch.setattr(exploration, "explore", broken)
    job = (with_scales(CONFIG, SCALE_SETS[-1]), 1000, tmp_path / "home-1000")
    ended, answers = exploration.explore_and_ask(job)
    assert not ended.explored and ended.steps == 1
    assert ended.reason == "error: ZeroDivisionError: division by zero"
    assert len(answers) == len(SCALE_SETS) * len(GOALS)
