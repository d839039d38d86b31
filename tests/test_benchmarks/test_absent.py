"""Maps are asked for what is there and for what is not."""

import tomllib

from benchmarks.episodes.absent_things import ThingAnswer
from benchmarks.episodes.episode import Episode, EpisodeResult, GoalResult
from benchmarks.episodes.homes import house_of
from benchmarks.harness.bench_plan import UNATTENDED, BenchPlan
from benchmarks.harness.fingerprint import Fingerprint
from benchmarks.objectnav import absent
from sim_stubs.homes.start_pose import things_named
from tests.test_benchmarks.printed_table import rows_in
from vizbot.core.home_vocabulary import THINGS
from vizbot.core.observer import Outcome

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
    right = {row[1]: row[2:4] for row in rows_in(result.text)[2:]}
    assert right == {
        "present": ["4", "50.0"], "elsewhere": ["2", "50.0"], "nowhere": ["2", "100.0"]
    }  # fmt: skip
    assert absent.absent_result({}).summary["refused"] is None


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


def searched(text, outcome, home=1100):
    claimed = outcome is Outcome.ARRIVED
    goal = GoalResult(text, False, claimed, "", "", None, 600, 50.0, None, 250.0, outcome)
    return EpisodeResult(Episode(home, (text,)), (goal,), 0, None, 60.0, (), (0.0, 0.0, 0.0))


def test_a_search_in_vain_has_to_be_ended_by_decision_and_not_by_its_last_step():
    ends = (Outcome.NOT_FOUND, Outcome.NOT_FOUND, Outcome.GAVE_UP, Outcome.ARRIVED, None)
    result = absent.absent_result({}, [searched("zebra", outcome) for outcome in ends])
    [row] = result.rows
    assert (row["asked"], row["refused"], row["claimed"]) == (5, 0.4, 0.2)
    alone = {"asked": 5, "present_asked": 0, "refused": 0.4, "found": None}
    assert result.summary == alone
    both = absent.absent_result({"default": ANSWERS}, [searched("zebra", Outcome.ARRIVED)])
    assert both.summary == absent.absent_result({"default": ANSWERS}).summary != alone
    assert "| 40.0 |" in " ".join(result.text.split())


def test_searches_are_driven_where_their_row_is_named_for_what_the_home_has_not(
    tmp_path, monkeypatch
):
    driven = []

    def run_missing(plan, bench, jobs):
        driven.extend(jobs)
        return {job: searched(job[1].goals[0], Outcome.NOT_FOUND, job[1].home) for job in jobs}

    monkeypatch.setattr(absent, "run_missing", run_missing)
    monkeypatch.setattr(absent, "require_unchanged", lambda plan: None)
    plan = BenchPlan(UNATTENDED, tmp_path, MADE, (1100,), rows=("by searching",))
    assert absent.run_absent(plan).rows[0]["asked"] == absent.SEARCHES
    assert [(variant.name, episode.home) for variant, episode in driven] == [
        ("by searching", 1100)
    ] * absent.SEARCHES
    house = house_of(1100)
    assert not any(any(things_named(house, episode.goals[0])) for _, episode in driven)


def test_the_words_are_asked_once_each_and_no_home_has_what_is_nowhere():
    words = tomllib.loads(absent.WORDS.read_text())
    assert len(words["nowhere"]) >= absent.COUNT // 2
    for texts in words.values():
        assert len(set(texts)) == len(texts)
    assert not set(THINGS) & set(words["nowhere"])
    assert set(words["elsewhere"]) <= set(THINGS)
