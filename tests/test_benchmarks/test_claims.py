"""Figures of README and pages against the kept rows: what agrees, and each way to disagree."""

import json
from dataclasses import replace

import pytest

from benchmarks.claims import pages
from benchmarks.claims.claims import kept_facts, read_claims
from benchmarks.claims.pages import BEGIN, END
from benchmarks.episodes.episode import Episode, EpisodeResult, GoalResult, HomeGoals
from benchmarks.harness.store import Store
from tests.helpers.checkout import ROOT
from vizbot.core.errors import ConfigError

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


def test_rows_become_rates_in_percent_and_equal_paths_are_counted(tmp_path):
    ours = [episode(1100 + i, "sofa", i != 3) for i in range(4)]
    theirs = [episode(1100 + i, "sofa", i == 0) for i in range(4)]
    theirs[1:] = [replace(each, track=((0.0, 0.1),)) for each in theirs[1:]]
    for name, results in (("default", ours), ("former", theirs)):
        file = tmp_path / "bare" / f"objectnav-{name}.jsonl"
        Store(file, EpisodeResult).add("key", "c0ffee", "2 cores", *results)
    (tmp_path / "walk").mkdir()
    (tmp_path / "walk" / "results.json").write_text(json.dumps({"rows": [{"error": 0.1}]}))
    facts = kept_facts(tmp_path)
    row = facts["bare"]["objectnav-default"]
    assert (row["count"], row["of"], row["percent"]) == (3, 4, 75.0)
    assert row["low"] == pytest.approx(30.06, abs=0.01)
    assert row["spl"] == pytest.approx(0.75 * 5 / 20)
    assert row["commit"] == "c0ffee" and row["said_wrongly"]["count"] == 0
    assert facts["bare"]["objectnav-former"]["same_path"] == 1
    assert facts["walk"]["results"]["rows"][0]["error"] == 0.1


def test_every_figure_of_this_repository_is_what_its_rows_say(monkeypatch):
    monkeypatch.chdir(ROOT)
    assert pages.problems() == []


def test_judged_homes_are_driven_to_the_goals_that_were_counted_before():
    rows = ROOT / pages.ROWS
    driven = {
        stored.result.home: stored.result.goals
        for board in ("others", "search")
        for stored in Store(rows / board / "homes.jsonl", HomeGoals).fullest()
    }
    counted = {
        stored.result.home: stored.result.goals
        for stored in Store(rows / "goals" / "homes.jsonl", HomeGoals).fullest()
    }
    both = counted.keys() & driven.keys()
    assert len(both) >= 4
    assert {home: driven[home] for home in both} == {home: counted[home] for home in both}


def test_a_table_of_results_that_was_changed_by_hand_is_found(tmp_path, monkeypatch):
    monkeypatch.setattr(pages, "RESULTS", tmp_path)
    monkeypatch.setattr(pages, "ROWS", ROOT / pages.ROWS)
    monkeypatch.setattr(pages, "README", tmp_path / "README.md")
    monkeypatch.setattr(pages, "MADE", {})
    monkeypatch.setattr(pages, "kept_facts", lambda rows: {})
    section = '[[section]]\npage = "README.md"\n'
    (tmp_path / "claims.toml").write_text(section)
    (tmp_path / "README.md").write_text(f"# Title\n\n{BEGIN}| old | 3 |\n{END}\n\nText.\n")
    monkeypatch.chdir(tmp_path)
    [line] = pages.problems()
    assert line.startswith(f"{tmp_path / 'README.md'} is not what its rows make")
    pages.write_pages()
    text = (tmp_path / "README.md").read_text()
    assert text.startswith(f"# Title\n\n{BEGIN}| ") and text.endswith(f" |\n{END}\n\nText.\n")
    assert "| the robot says wrongly that it has arrived | 8 of 295, 2.7 % (" in text
    assert "92 and 104 (p = 0.02)" in text and "no direct comparison" in text
    assert pages.problems() == []
    (tmp_path / "README.md").write_text(text.replace("Text.", "Text, 4 times."))
    [line] = pages.problems()
    assert "Text, 4 times.' is in no claim" in line


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
    monkeypatch.setattr(pages, "README", tmp_path / "README.md")
    (tmp_path / "README.md").write_text("# Title\n")
    monkeypatch.setattr(pages, "MADE", {
        "walk": lambda rows, page: f"{rows.name} of {page.name}\n",
        "flat": lambda rows, page: "",
    })  # fmt: skip
    (tmp_path / "claims.toml").write_text("")
    (tmp_path / "rows").mkdir()
    assert pages.write_pages() == [tmp_path / "walk.md", tmp_path / "README.md"]
    assert pages.problems() == []
    (tmp_path / "walk.md").write_text("walk of walk.md, and more\n")
    [line] = pages.problems()
    assert "walk.md is not what its rows make" in line
