"""A room is explored once, and its map asked by every scale set."""

import itertools
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.episodes import exploration
from benchmarks.episodes.calibration_error import EXACT
from benchmarks.episodes.episode import BelievedAnswer
from benchmarks.episodes.exploration import SCALE_SETS, HomeToAsk
from benchmarks.objectnav.single_goal import with_scales
from mapping.clip.places.likeliest_places import LikelyPlace
from mapping.clip.places.place_rows import PlaceRows
from mapping.clip.scores import Query
from sim_stubs.scoring.success import GOALS
from sim_stubs.world.world_plan import D435I_COLOUR
from tests.helpers.failing import raising
from vizbot.config import Config
from vizbot.core.geometry import invert, transform
from vizbot.objectnav.tasks import Task

CONFIG = Config.model_validate({"objectnav": {"max_exploration_steps": 3}})


@pytest.fixture(autouse=True)
def small_home(monkeypatch, mean_colours, kitchen):
    monkeypatch.setattr(
        exploration, "open_benchmark_home",
        lambda seed, config, error=EXACT: error.world(kitchen, config, seed),
    )  # fmt: skip
    monkeypatch.setattr(exploration, "encoder_of", lambda config: mean_colours)


def test_every_goal_is_asked_by_every_scale_set_and_scored_by_the_truth(tmp_path, monkeypatch):
    job = HomeToAsk(with_scales(CONFIG, SCALE_SETS[-1]), 1000, tmp_path / "maps" / "home-1000")
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
    monkeypatch.setattr(exploration, "explore", raising(AssertionError))
    assert exploration.explore_and_ask(job) == (ended, answers)


@pytest.mark.parametrize(
    ("text", "right"), [("sofa", True), ("bed", False)], ids=["the home has it", "it has not"]
)
def test_an_answer_is_right_where_the_thing_is_and_wrong_elsewhere(text, right, monkeypatch):
    with exploration.open_benchmark_home(1000, CONFIG) as world:
        T_world_map = world.T_world_base
        points = transform(invert(T_world_map), np.array([[2.9, 1.5, 0.4], [0.3, 0.3, 0.4]]))
        bundle = SimpleNamespace(
            elements=SimpleNamespace(embeddings=np.eye(2, dtype=np.float32)),
            element_points=lambda: points,
        )
        asked = exploration._OfScales((0,), np.arange(2), PlaceRows.empty(), 0.5)
        for similar, likely in itertools.product(range(2), range(2)):
            question = Query(np.float32([0.8, 0.6])[[similar, 1 - similar]], None)
            place = LikelyPlace(points[likely], 0.7, likely, 0.0)
            monkeypatch.setattr(exploration, "_likeliest", lambda *_, place=place: place)
            query = exploration._Query(text, question, right)
            answer = exploration._ask(query, asked, bundle, world, T_world_map)
            assert answer.most_similar_correct == (right and similar == 0)
            assert answer.correct == (right and likely == 0)
            assert answer.believed == BelievedAnswer(0.7, right and likely == 0)
            assert answer.similarity == pytest.approx(0.8)


def test_the_answer_is_the_likeliest_place_of_the_map(monkeypatch):
    places = [LikelyPlace(np.zeros(3), 0.7, 0, 0.0), LikelyPlace(np.ones(3), 0.2, 1, 0.0)]
    keyframes = SimpleNamespace(poses=dict)
    elements = SimpleNamespace(embeddings=None)
    bundle = SimpleNamespace(
        statistics=0, pictures=0, keyframes=keyframes, elements=elements,
        intrinsics=D435I_COLOUR, frames=None,
    )  # fmt: skip
    monkeypatch.setattr(exploration, "belief_of_map", lambda *_: None)
    for found in (places, places[1:], []):
        monkeypatch.setattr(exploration, "likeliest_places", lambda *_, found=found: found)
        answer = exploration._likeliest(bundle, PlaceRows.empty(), None)
        assert answer is (found[0] if found else None)


def test_with_some_scales_alone_the_views_show_what_these_show():
    rows = PlaceRows.empty()
    rows = replace(rows, elements=np.array([[10, 20, 30]], np.int32))  # finest to coarsest
    bundle = SimpleNamespace(places=rows)
    config = CONFIG.perception.clip_mapper.model_copy(update={"scales": (1, 0, -1, -2)})
    for scales, columns in (
        ((1,), [30, 30, 30]), ((0,), [20, 20, 20]), ((-1,), [10, 10, 10]), ((1, 0), [20, 30, 30]),
        ((1, 0, -1), [10, 20, 30]), ((1, 0, -1, -2), [10, 20, 30]),
    ):  # fmt: skip
        of_scales = exploration.rows_of_scales(bundle, scales, config)
        assert of_scales.elements.tolist() == [columns]
    assert exploration.rows_of_scales(bundle, (-2,), config) is None


def test_what_was_mapped_before_an_error_is_asked(tmp_path, monkeypatch):
    def broken(pipeline, devices, max_steps):
        pipeline.tick(Task.EXPLORE)
        raise ZeroDivisionError("division by zero")

    monkeypatch.setattr(exploration, "explore", broken)
    job = HomeToAsk(with_scales(CONFIG, SCALE_SETS[-1]), 1000, tmp_path / "home-1000")
    ended, answers = exploration.explore_and_ask(job)
    assert not ended.explored and ended.steps == 1
    assert ended.reason == "error: ZeroDivisionError: division by zero"
    assert len(answers) == len(SCALE_SETS) * len(GOALS)
