"""Figures of README and pages against the kept rows: what agrees, and each way to disagree."""

import json
from dataclasses import replace

import pytest

from benchmarks.claims import pages
from benchmarks.claims.claims import read_claims
from benchmarks.claims.facts import kept_facts
from benchmarks.episodes.absent_things import ThingAnswer
from benchmarks.episodes.episode import Episode, EpisodeResult, GoalResult
from benchmarks.harness.store import Store
from benchmarks.objectnav.overshoot import Overshoot
from tests.helpers.checkout import ROOT
from vizbot.core.errors import ConfigError
from vizbot.core.observer import Outcome

FACTS = {"walk": {"error": 0.0678, "metres": 31.2}}
PAGE = """# Title of 2026

## Results

The error is **0.07 m** on a walk of
31 m ([how](page2.md)), where `--stride 3` is 1.

### Below

4 more.

## Other

17 unclaimed things.
"""
CLAIMS = """
[[section]]
page = "PAGE.md"
heading = "Results"
constants = ["is 1."]

[[claim]]
page = "PAGE.md"
text = "**{walk[error]:.2f} m** on a walk of {walk[metres]:.0f} m"

[[claim]]
page = "PAGE.md"
text = "4 more"
"""


@pytest.fixture
def problems(tmp_path):
    def of(page=PAGE, claims=CLAIMS, facts=FACTS):
        (tmp_path / "PAGE.md").write_text(page)
        (tmp_path / "claims.toml").write_text(claims)
        return read_claims(tmp_path / "claims.toml").problems(tmp_path, facts)

    return of


def test_a_page_that_says_what_the_rows_say_has_no_problem(problems):
    assert problems() == []


def test_another_figure_in_the_rows_is_a_problem_of_the_page(problems):
    [line, *left] = problems(facts={"walk": {"error": 0.0751, "metres": 31.2}})
    assert line.startswith("PAGE.md does not say '**0.08 m** on a walk of 31 m'")
    assert len(left) == 2 and all("is in no claim" in each for each in left)


def test_a_number_in_a_section_that_nobody_claims_is_a_problem(problems):
    [line] = problems(PAGE.replace("31 m (", "31 m, in 12 s ("))
    assert line.startswith("PAGE.md, Results: ") and "12 s" in line
    [below] = problems(PAGE.replace("4 more.", "4 more, 5 less."))
    assert "5 less" in below


def test_numbers_of_other_sections_and_targets_of_links_are_left_alone(problems):
    assert problems(PAGE.replace("17", "18").replace("page2.md", "page3.md")) == []
    whole = CLAIMS.replace('heading = "Results"\n', "")
    assert len(problems(claims=whole)) == 2


def test_a_claim_of_a_row_that_is_not_kept_names_it(problems):
    [line, *_] = problems(facts={"walk": {"metres": 31.2}})
    assert "no row says" in line and "walk[error]" in line


def test_a_heading_that_is_gone_is_a_problem(problems):
    assert problems(PAGE.replace("## Results", "## Figures")) == [
        "PAGE.md has no heading 'Results'"
    ]


@pytest.mark.parametrize("content", ["[[claim]\n", "[[claim]]\npage = 3\n", "[[clam]]\n"])
def test_a_spoilt_list_of_claims_is_refused_with_its_name(problems, content):
    with pytest.raises(ConfigError, match=r"claims .*claims\.toml cannot be read"):
        problems(claims=content)


def test_a_page_that_is_missing_is_named(problems):
    with pytest.raises(ConfigError, match=r"page GONE\.md of a claim is missing"):
        problems(claims=CLAIMS + '[[claim]]\npage = "GONE.md"\ntext = ""\n')


def episode(home, goal, success, steps=100):
    found = GoalResult(goal, success, success, "", "", 0.5, steps, 20.0, 5.0, 60.0)
    return EpisodeResult(Episode(home, (goal,)), (found,), 1, 0.02, 9.0, (), (0.0, 0.0, 0.0))


def test_rows_become_rates_in_percent_and_pairs(tmp_path):
    ours = [episode(1100 + i, "sofa", i != 3) for i in range(4)]
    theirs = [episode(1100 + i, "sofa", i == 0) for i in range(4)]
    theirs[1:] = [replace(each, track=((0.0, 0.1),)) for each in theirs[1:]]
    for name, results in (("default", ours), ("scale-1", theirs)):
        file = tmp_path / "scoreboard" / f"objectnav-{name}.jsonl"
        Store(file, EpisodeResult).add("key", "c0ffee", "2 cores", *results)
    (tmp_path / "walk").mkdir()
    (tmp_path / "walk" / "results.json").write_text(json.dumps({"rows": [{"error": 0.1}]}))
    facts = kept_facts(tmp_path)
    row = facts["scoreboard"]["objectnav-default"]
    assert (row["count"], row["of"], row["percent"]) == (3, 4, 75.0)
    assert row["low"] == pytest.approx(30.06, abs=0.01)
    assert row["spl"] == pytest.approx(0.75 * 5 / 20)
    assert (row["driven"], row["shortest"], row["commit"]) == (20.0, 5.0, "c0ffee")
    other = facts["scoreboard"]["objectnav-scale-1"]
    assert other["default_against"] == {"wins": 2, "losses": 0, "p": 0.5, "same_path": 1}
    assert facts["walk"]["results"]["rows"][0]["error"] == 0.1


def test_default_rows_of_two_folders_are_paired_where_they_share_episodes(tmp_path):
    for folder, homes, failed in (("one", range(5), 3), ("two", range(1, 6), 1), ("far", [9], 9)):
        file = tmp_path / folder / "objectnav-default.jsonl"
        results = [episode(1100 + i, "sofa", i != failed) for i in homes]
        results[0] = replace(results[0], track=((0.0, failed),))
        Store(file, EpisodeResult).add("key", "c0ffee", "2 cores", *results)
    facts = kept_facts(tmp_path)
    against = facts["one"]["objectnav-default"]["against"]
    assert against == {"two": {"wins": 1, "losses": 1, "p": 1.0, "same_path": 3}}
    assert facts["far"]["objectnav-default"]["against"] == {}


def test_episodes_of_several_goals_are_counted_by_home_and_by_goals_in_a_row(tmp_path):
    reached, missed = (episode(1100, "sofa", success).goals[0] for success in (True, False))
    wrong = replace(missed, claimed=True)
    runs = [
        replace(episode(home, "sofa", True), episode=Episode(home, ("sofa",) * 4), goals=goals)
        for home, goals in ((1100, (reached,) * 4), (1100, (reached, wrong)), (1101, (missed,)))
    ]
    Store(tmp_path / "few" / "multi-default.jsonl", EpisodeResult).add("key", "c0", "2", *runs)
    facts = kept_facts(tmp_path)["few"]["multi-default"]
    assert facts["of_home"] == {1100: 2, 1101: 1}
    assert (facts["asked_for"], facts["ended_at"], facts["ended"]) == ({"sofa": 7}, {"sofa": 2}, 2)
    assert facts["ended_in"] == {1100: 1, 1101: 1}
    assert [facts[f"at_least_{n}"]["count"] for n in (1, 2, 3, 4)] == [2, 1, 1, 1]
    assert (facts["all"]["count"], facts["all"]["of"]) == (1, 3)
    assert facts["said_wrongly"] == 1
    assert facts["steps"] == 100.0


def test_goals_in_a_row_are_paired_with_goals_in_a_row(tmp_path):
    for name, failed in (("objectnav-default", ()), ("multi-default", (1, 2)), ("multi-old", (3,))):
        results = [episode(1100 + i, "sofa", i not in failed) for i in range(5)]
        Store(tmp_path / "few" / f"{name}.jsonl", EpisodeResult).add("key", "c0", "2", *results)
    paired = kept_facts(tmp_path)["few"]["multi-old"]["default_against"]
    assert paired == {"wins": 1, "losses": 2, "p": 1.0}


def test_every_figure_of_this_repository_is_what_its_rows_say(monkeypatch):
    monkeypatch.chdir(ROOT)
    assert pages.problems() == []


def test_of_each_mutant_the_last_line_counts_and_none_that_fails_at_import(tmp_path):
    mutant = {"path": "a.py", "kind": "constant", "before": "1", "after": "2", "number": 0}
    lines = [
        {"mutant": mutant | {"line": line, "number": number}, "outcome": outcome,
         "commit": commit}
        for line, number, outcome, commit in (
            (3, 0, "survived", "0a1"), (3, 1, "void", "0a1"), (5, 0, "killed", "2b3"),
            (6, 2, "survived", "2b3"),
        )
    ]  # fmt: skip
    (tmp_path / "mutants.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
    assert kept_facts(tmp_path)["mutants"] == {
        "commits": "0a1, 2b3", "drawn": 2, "killed": 1, "killed_at_first": 0,
    }  # fmt: skip


def test_a_page_that_was_changed_by_hand_is_found(tmp_path, monkeypatch):
    monkeypatch.setattr(pages, "RESULTS", tmp_path)
    monkeypatch.setattr(pages, "ROWS", tmp_path / "rows")
    monkeypatch.setattr(pages, "MADE", {
        "walk": lambda rows, page: f"{rows.name} of {page.name}\n",
        "flat": lambda rows, page: "",
    })  # fmt: skip
    (tmp_path / "claims.toml").write_text("")
    (tmp_path / "rows").mkdir()
    assert pages.write_pages() == [tmp_path / "walk.md"]
    assert pages.problems() == []
    (tmp_path / "walk.md").write_text("walk of walk.md, and more\n")
    [line] = pages.problems()
    assert "walk.md is not what its rows make" in line


def test_answers_of_maps_and_what_is_driven_on_are_facts(tmp_path):
    there = [("sofa", "present", True, True), ("bed", "present", True, False)]
    absent = [("crib", "elsewhere", False, False), ("zebra", "nowhere", True, False)]
    answers = [
        ThingAnswer(1, text, kind, located, 0.7, correct)
        for text, kind, located, correct in (*there, *absent)
    ]
    Store(tmp_path / "b" / "absent-offset.jsonl", ThingAnswer).add("k", "c0", "hw", *answers)
    goals = [
        GoalResult("crib", False, claimed, "", "", None, 100, 9.0, None, 9.0, outcome, 0.9, truly)
        for claimed, outcome, truly in (
            (False, Outcome.NOT_FOUND, 0.85), (False, Outcome.NOT_FOUND, 0.75),
            (True, Outcome.ARRIVED, 0.9),
        )
    ]  # fmt: skip
    searches = [
        EpisodeResult(Episode(1, ("crib",), n), (goal,), 0, None, 1.0, (), (0.0, 0.0, 0.0))
        for n, goal in enumerate(goals)
    ]
    Store(tmp_path / "b" / "absent-by-searching.jsonl", EpisodeResult).add(
        "k", "c0", "hw", *searches
    )
    ways = [
        Overshoot(Episode(home, ("sofa",)), 9.0, before, before is not None)
        for home, before in ((1, 4.0), (2, None))
    ]
    Store(tmp_path / "b" / "overshoot-old.jsonl", Overshoot).add("k", "c0", "hw", *ways)
    facts = kept_facts(tmp_path)["b"]
    offset, vain = facts["absent-offset"], facts["absent-by-searching"]
    assert (offset["found"]["count"], offset["found"]["of"]) == (1, 2)
    assert (offset["refused"]["percent"], offset["elsewhere"]["percent"]) == (50.0, 100.0)
    assert (vain["refused"]["count"], vain["claimed"]["of"], vain["steps"]) == (2, 3, 100)
    assert (vain["seen_close"]["count"], vain["seen_close"]["of"]) == (1, 2)
    on = facts["overshoot-old"]
    assert (on["of"], on["stood"], on["before"], on["after"]) == (2, 1, 4.0, 5.0)
