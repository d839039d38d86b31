"""Maps are asked for what is there and for what is not."""

import tomllib

import numpy as np
import pytest

from sim_stubs.homes.floor_plan.walls import RectangularRoom, build_structure
from sim_stubs.homes.furniture import procedural
from sim_stubs.homes.geometry.house import House, Instance
from sim_stubs.homes.vocabulary import THINGS
from tests.helpers.bundles import bundle_of
from vizbot.bench.episodes import absent_things
from vizbot.bench.episodes.absent_things import HomeQuestions, ThingAnswer, ask_home
from vizbot.bench.episodes.calibration_error import EXACT
from vizbot.bench.harness.bench_plan import UNATTENDED, BenchPlan
from vizbot.bench.harness.fingerprint import Fingerprint
from vizbot.bench.objectnav import absent
from vizbot.core.geometry import invert, transform
from vizbot.core.observer import Outcome
from vizbot.operator.session.place_answers import Answer, FoundPlace

MADE = Fingerprint("embedded", "homes", "episodes", "oracles", "c0ffee", "2 cores of X")


def answer(text, kind, located, correct=False, home=1100):
    return ThingAnswer(home, text, kind, located, 0.7, correct)


ANSWERS = [
    answer("sofa", "present", True, True), answer("bed", "present", True, False),
    answer("tv", "present", False, True), answer("sink", "present", True, True),
    answer("piano", "elsewhere", True), answer("crib", "elsewhere", False),
    answer("zebra", "nowhere", False), answer("tractor", "nowhere", False),
]  # fmt: skip


def test_what_is_there_has_to_be_located_rightly_and_what_is_not_to_be_refused():
    result = absent.absent_result({"default": ANSWERS})
    assert result.summary == {"asked": 4, "present_asked": 4, "refused": 0.75, "found": 0.5}
    lines = [[cell.strip() for cell in line.split("|")] for line in result.text.splitlines()]
    right = {line[2]: line[3:5] for line in lines[2:]}
    assert right == {
        "present": ["4", "50.0"], "elsewhere": ["2", "50.0"], "nowhere": ["2", "100.0"]
    }  # fmt: skip
    assert absent.absent_result({}).summary["refused"] is None


@pytest.fixture
def small_home(monkeypatch, mean_colours):
    room = RectangularRoom("kitchen", 0, 0, 4, 3, (0.5, 0.4, 0.3), 1.0, (0.6, 0.6, 0.6))
    sofa = Instance(
        "sofa#1", procedural.piece("sofa", np.random.default_rng(0)), 2.9, 1.5, -np.pi / 2
    )
    lights = np.array([[2.0, 1.5, 2.3]])
    house = House((room.room,), build_structure((room,), ()), (sofa,), lights, (0.9, 1.5, 0.0))
    monkeypatch.setattr(
        absent_things, "open_benchmark_home",
        lambda seed, config, error: EXACT.world(house, config, seed),
    )  # fmt: skip
    monkeypatch.setattr(absent_things, "explored_map", lambda *_: (None, bundle_of()))
    monkeypatch.setattr(absent_things, "encoder_of", lambda config: mean_colours)
    with EXACT.world(house, UNATTENDED, 1100) as world:
        return invert(world.T_world_base)


def test_a_home_is_asked_for_what_it_has_and_for_half_as_many_of_either_that_it_has_not(
    small_home, monkeypatch, tmp_path
):
    at_sofa, elsewhere = transform(small_home, np.array([[2.9, 1.5, 0.4], [0.3, 0.3, 0.4]]))

    def find_places(bundle, goal, log_odds, config):
        place = FoundPlace(tuple(at_sofa if goal.text == "sofa" else elsewhere), 0.8, 0, ())
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

    def find_places(bundle, goal, log_odds, config):
        asked.append((bundle.model_id, bundle.elements.embeddings.shape[1], len(goal.embedding)))
        return Answer(goal.text, Outcome.NOT_FOUND, 0.5, ())

    monkeypatch.setattr(absent_things, "find_places", find_places)
    answers = ask_home(HomeQuestions(UNATTENDED, "clip", 1100, tmp_path, ("zebra",), ("tv",), 2))
    assert {each.score for each in answers} == {0.0}
    [(model_id, dimension, of_goal)] = set(asked)
    assert model_id.endswith("-clip") and dimension == of_goal


def test_only_homes_without_answers_are_asked_and_other_rows_when_they_are_named(
    tmp_path, monkeypatch
):
    jobs = []

    def in_parallel(function, asked, name, line):
        jobs.extend((name, job.home, job.encoder_scale) for job in asked)
        yield from ((job, [answer("sofa", "present", True, True, job.home)]) for job in asked)

    monkeypatch.setattr(absent, "in_parallel", in_parallel)
    monkeypatch.setattr(absent, "require_unchanged", lambda plan: None)
    plan = BenchPlan(UNATTENDED, tmp_path, MADE, (1100, 1101))
    assert absent.run_absent(plan).summary["present_asked"] == 2
    absent.run_absent(plan)
    assert jobs == [("absent, default", 1100, None), ("absent, default", 1101, None)]
    plan = BenchPlan(UNATTENDED, tmp_path, MADE, (1100,), rows=("offset",))
    result = absent.run_absent(plan)
    assert jobs[2:] == [("absent, offset", 1100, "offset")]
    assert [row["row"] for row in result.rows] == ["offset"]


def test_the_words_are_asked_once_each_and_no_home_has_what_is_nowhere():
    words = tomllib.loads(absent.WORDS.read_text())
    assert len(words["nowhere"]) >= absent.COUNT // 2
    for texts in words.values():
        assert len(set(texts)) == len(texts)
    assert not set(THINGS) & set(words["nowhere"])
    assert set(words["elsewhere"]) <= set(THINGS)
