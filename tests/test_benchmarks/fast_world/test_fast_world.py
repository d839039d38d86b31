"""The fast world: places and views of a home, walks of the search, and the table of its rules."""

import json
from dataclasses import fields, replace
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.episodes.episode import Episode, EpisodeResult, GoalResult, HomeGoals
from benchmarks.episodes.run import encoder_of
from benchmarks.fast_world import bench, walk
from benchmarks.fast_world.bench import fast_result
from benchmarks.fast_world.walk import FastHome, SearchRule, Walk
from benchmarks.harness.bench_plan import ABLATION_ROWS, QUICK_SHARE, UNATTENDED, BenchPlan
from benchmarks.harness.fingerprint import Fingerprint
from sim_stubs.homes.geometry.occupancy_slice import PlanGrid
from vizbot.config import with_method
from vizbot.objectnav.search_parts import ALL_PARTS, SearchParts
from vizbot.rehearsal.belief_fit.places import Places
from vizbot.rehearsal.belief_fit.views import HEADINGS

HOME = 1100
BRIEF = UNATTENDED.model_copy(
    update={
        "objectnav": UNATTENDED.objectnav.model_copy(update={"max_steps": 25, "look_around": False})
    }
)


class Plan:
    """A world that is nothing but a plan of free cells."""

    def __init__(self, free, at):
        self.free = free, PlanGrid(np.zeros(2), 0.1, free.shape)
        self.T_world_base = np.eye(4)
        self.T_world_base[:2, 3] = at


def test_a_wall_through_a_block_gives_it_two_places():
    free = np.ones((5, 5), bool)
    free[2] = False
    free = np.vstack([free, np.ones((5, 5), bool)])
    free[7, :4] = False
    places = Places.in_world(Plan(free, (0.25, 0.95)))
    assert places.of_cell[0, 0] == -1  # behind a wall, where no way leads
    assert places.of_cell[3, 0] == places.of_cell[4, 4] != places.of_cell[9, 0]
    for place, (x, y) in enumerate(places.xy):
        assert places.nearest(x, y) == place
    for row, column in np.argwhere(places.of_cell >= 0):
        x, y = places.grid.pixels_to_xy(np.array([[column, row]], float))[0]
        assert places.nearest(x, y) == places.of_cell[row, column]


def test_places_are_where_the_robot_can_stand():
    free = np.ones((20, 30), bool)
    free[:, 13] = False
    places = Places.in_world(Plan(free, (0.5, 0.5)))
    cells = [places.grid.cell_of(x, y) for x, y in places.xy]
    assert all(free[cell] and cell[1] < 13 for cell in cells)
    assert len(cells) == 4 * 3
    assert places.nearest(2.5, 0.5) in {places.nearest(1.25, y) for y in (0.25, 0.75)}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("views")


@pytest.fixture(scope="module")
def home(folder):
    with FastHome(HOME, BRIEF, encoder_of(BRIEF), folder) as opened:
        yield opened


def walked(home):
    return Walk(home, SearchRule("a rule", BRIEF), Episode(HOME, ("sofa",))).run()


def same(a, b):
    return all(
        getattr(a, each.name) == getattr(b, each.name)
        for each in fields(EpisodeResult)
        if each.name != "wall_seconds"
    )


def test_a_walk_repeats_itself_with_views_that_were_kept(home, folder):
    first = walked(home)
    made = home.views.made
    assert 0 < made <= 25 and first.goals[0].steps == 25 and first.goals[0].path_length > 0.1
    assert same(walked(home), first) and home.views.made == made
    home.views.save()
    with FastHome(HOME, BRIEF, encoder_of(BRIEF), folder) as again:
        assert same(walked(again), first) and again.views.made == 0


def test_a_view_lies_where_its_picture_was_taken(home):
    T_world_base = home.world.T_world_base
    number, view, T_world_pictured = home.view_at(T_world_base)
    place, heading = divmod(number, HEADINGS)
    assert np.allclose(T_world_pictured[:2, 3], home.places.xy[place])
    assert np.array_equal(home.world.T_world_base, T_world_base)
    rgb, _ = home.world.render_from(T_world_pictured)
    again = home.encoder.embed_images([rgb[v0:v1, u0:u1] for u0, v0, u1, v1 in view.elements.boxes])
    assert np.abs(again - view.elements.embeddings).max() < 1e-3
    assert 0 <= heading < HEADINGS


@pytest.mark.parametrize("away", [None, 2.34567])
def test_how_far_the_judge_finds_the_goal_is_kept(home, monkeypatch, away):
    verdict = SimpleNamespace(success=False, reason="far", distance=away)
    monkeypatch.setattr(walk, "judge", lambda *args, **options: verdict)
    assert walked(home).goals[0].distance == (away and 2.346)


def test_the_papers_method_begins_without_a_turn(home):
    brief = BRIEF.objectnav.model_copy(update={"look_around": True, "max_steps": 12})
    turning = BRIEF.model_copy(update={"objectnav": brief})
    rules = SearchRule("default", turning), SearchRule("paper", with_method(turning, "paper"))
    turned, driven = (Walk(home, each, Episode(HOME, ("sofa",))).run() for each in rules)
    assert turned.goals[0].path_length < 0.1 < driven.goals[0].path_length


def test_a_part_is_taken_away_from_the_search_of_its_row(home):
    rules = {rule.name: rule for rule in bench.rules(BRIEF)}
    assert set(ABLATION_ROWS.values()) < set(rules)
    for name, parts in (
        ("default", ALL_PARTS),
        ("without likeness at frontiers", SearchParts(likeness=False)),
    ):
        walk = Walk(home, rules[name], Episode(HOME, ("sofa",)))
        assert walk._mind._search._parts == parts


def test_the_row_of_the_papers_method_is_one_of_the_rules():
    methods = {rule.name: rule.config.objectnav.method for rule in bench.rules(BRIEF)}
    assert methods.pop("paper") == "paper"
    assert set(methods.values()) == {"belief"}


def results(spls, homes, claimed=True):
    made = {}
    for number, (value, home) in enumerate(zip(spls, homes, strict=True)):
        success = value > 0
        way = 4.0 / value if success else 9.0
        goal = GoalResult("sofa", success, claimed, "", "", 1.0, 100, way, 4.0, 20.0)
        episode = Episode(home, ("sofa",), number)
        made[episode] = EpisodeResult(episode, (goal,), 0, None, 1.0, (), (0.0, 0.0, 0.0))
    return list(made.values())


def test_rules_are_paired_episode_by_episode():
    homes = [1100, 1101, 1108, 1108]
    result = fast_result(
        {
            "default": results([0.5, 0.5, 0.25, 0.0], homes),
            "other": results([1, 0.5, 0.5, 0], homes),
        }
    )
    row = {(each["row"], each["homes"]): each for each in result.rows}
    assert row["other", "to tune in"]["gain"] == pytest.approx(0.25)
    assert row["other", "to tune in"]["gain_low"] == 0.0
    assert row["other", "to report on"]["gain_low"] is None
    assert row["other", "to report on"]["gain"] == pytest.approx(0.125)
    assert row["default", "all"]["gain"] == 0.0
    assert row["other", "all"]["spl"] == pytest.approx(0.5)
    assert row["other", "all"]["false_claims"] == pytest.approx(0.25)
    assert result.summary["other"]["success_rate"] == pytest.approx(0.75)
    assert "never for a figure" in result.text


def test_a_quick_run_walks_the_episodes_of_the_quick_share(tmp_path, monkeypatch):
    walked, asked = [], []

    def goals(plan):
        asked.append(plan.homes)
        return [HomeGoals(home, ("bed", "sofa", "sink", "tv")) for home in plan.homes]

    def walk_at_once(_, jobs, *__):
        for job in jobs:
            walked.extend(job.episodes)
            [goal] = results([0.5], [1100])[0].goals
            yield (
                job,
                [
                    EpisodeResult(each, (goal,), 0, None, 1.0, (), (0.0, 0.0, 0.0))
                    for each in job.episodes
                ],
            )

    monkeypatch.setattr(bench, "goals_of_homes", goals)
    monkeypatch.setattr(bench, "in_parallel", walk_at_once)
    monkeypatch.setattr(bench, "fast_result", lambda results: results)
    made = Fingerprint("embedded", "homes", "episodes", "oracles", "c0ffee", "2 cores")
    plan = BenchPlan(UNATTENDED, tmp_path, made, None, quick=True, rows=("default",))
    assert list(bench.run_fast(plan)) == ["default"] and asked == [QUICK_SHARE]
    assert [(each.home, each.goals) for each in walked[:4]] == [
        (1100, ("bed",)), (1100, ("tv",)), (1101, ("sofa",)), (1102, ("sink",)),
    ]  # fmt: skip
    assert {each.number for each in walked} == {0}
    walked.clear()
    kept = bench.run_fast(replace(plan, quick=False, homes=(1100,)))
    assert [each.goals for each in walked] == [("sofa",), ("sink",)]  # two are walked already
    assert [each.episode.goals[0] for each in kept["default"]] == ["bed", "sofa", "sink", "tv"]


def test_the_command_walks_the_rows_that_are_asked_for(vizbot, monkeypatch, tmp_path):
    asked = []

    def run_fast(plan, scale):
        asked.append((plan, scale))
        return fast_result({"default": results([0.5, 0.5], [1100, 1108])})

    monkeypatch.setattr(bench, "run_fast", run_fast)
    code, out, _ = vizbot(
        "objectnav", "--fast", "--rows", "default,without z-score", "--out", str(tmp_path), "--json"
    )
    assert code == 0 and json.loads(out)["summary"]["default"]["spl"] == 0.5
    [(plan, scale)] = asked
    assert plan.rows == ("default", "without z-score") and plan.folder == tmp_path and not scale
    assert vizbot("objectnav", "--fast", "--method", "paper")[0] == 0
    assert asked[1][0].rows == ("paper",)
    assert vizbot("objectnav", "--fast", "--rows", "default", "--encoder-scale", "offset")[0] == 0
    assert asked[2][0].rows == ("default",) and asked[2][1] == "offset"


def test_another_encoder_has_its_cosines_in_the_same_views(home, folder):
    with FastHome(HOME, BRIEF, encoder_of(BRIEF), folder, "clip") as other:
        T = home.world.T_world_base
        own, scaled = home.view_at(T), other.view_at(T)
        assert own[0] == scaled[0] and own[1].scan.packed == scaled[1].scan.packed
        texts = ["sofa", "kitchen"]
        before, now = (
            each.view_at(T)[1].elements.embeddings @ each.encoder.embed_texts(texts).T
            for each in (home, other)
        )
        slope = other.encoder._slope
        assert np.allclose(now, slope * before + other.encoder._shift, atol=1e-4)
        assert other.view_at(T)[1] is scaled[1]
