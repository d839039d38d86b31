"""A home is asked for what it has and for what it has not."""

import numpy as np
import pytest

from benchmarks.episodes import absent_things
from benchmarks.episodes.absent_things import HomeQuestions, ask_home
from benchmarks.episodes.calibration_error import EXACT
from benchmarks.harness.bench_plan import UNATTENDED
from tests.helpers.bundles import bundle_of
from vizbot.core.geometry import invert, transform
from vizbot.core.observer import Outcome
from vizbot.operator.session.place_answers import Answer, FoundPlace


@pytest.fixture
def small_home(monkeypatch, mean_colours, kitchen):
    monkeypatch.setattr(
        absent_things, "open_benchmark_home",
        lambda seed, config, error: EXACT.world(kitchen, config, seed),
    )  # fmt: skip
    monkeypatch.setattr(absent_things, "explored_map", lambda *_: (None, bundle_of()))
    monkeypatch.setattr(absent_things, "encoder_of", lambda config: mean_colours)
    with EXACT.world(kitchen, UNATTENDED, 1100) as world:
        return invert(world.T_world_base)


def test_a_home_is_asked_for_what_it_has_and_for_half_as_many_of_either_that_it_has_not(
    small_home, monkeypatch, tmp_path
):
    at_sofa, elsewhere = transform(small_home, np.array([[2.9, 1.5, 0.4], [0.3, 0.3, 0.4]]))

    def find_places(bundle, goal, config):
        place = FoundPlace(
            tuple(at_sofa if goal.text == "sofa" else elsewhere),
            0.8,
            0,
            (),
            "2026-11-29T12:00:00+00:00",
        )
        located = Outcome.LOCATED if goal.text in ("sofa", "zebra") else Outcome.NOT_FOUND
        return Answer(goal.text, located, 0.5, (place,))

    monkeypatch.setattr(absent_things, "find_places", find_places)
    job = HomeQuestions(
        UNATTENDED, None, 1100, tmp_path, ("zebra", "tractor", "giraffe"),
        ("sofa", "piano", "couch", "crib", "tv"), 4,
    )  # fmt: skip
    answers = ask_home(job)
    assert answers == ask_home(job)
    of_kind = {}
    for each in answers:
        of_kind.setdefault(each.kind, {})[each.text] = (each.located, each.correct)
    assert of_kind["present"] == {"sofa": (True, True), "kitchen": (False, True)}
    assert len(of_kind["nowhere"]) == 2 and len(of_kind["elsewhere"]) == 2
    assert set(of_kind["elsewhere"]) <= {"piano", "crib", "tv"}
    assert all(each.located == (each.text == "zebra") for each in answers if each.kind == "nowhere")


def test_a_map_is_asked_with_the_cosines_of_another_encoder(small_home, monkeypatch, tmp_path):
    asked = []

    def find_places(bundle, goal, config):
        asked.append((bundle.model_id, bundle.elements.embeddings.shape[1], len(goal.embedding)))
        return Answer(goal.text, Outcome.NOT_FOUND, 0.5, ())

    monkeypatch.setattr(absent_things, "find_places", find_places)
    answers = ask_home(HomeQuestions(UNATTENDED, "clip", 1100, tmp_path, ("zebra",), ("tv",), 2))
    assert {each.score for each in answers} == {0.0}
    [(model_id, dimension, of_goal)] = set(asked)
    assert model_id.endswith("-clip") and dimension == of_goal
