"""The page of the pose benchmarks: what is kept, and what is said of rows that are not."""

import json
from dataclasses import replace

import pytest

from benchmarks.harness.store import Store
from benchmarks.slam.homes import AS_RECORDED, FAULTS, TWINS
from benchmarks.slam.hours import DrivenHours, Hour
from benchmarks.slam.lap_scores import LapResult
from benchmarks.slam.page import slam_page
from benchmarks.slam.relocalisation import StartResult
from tests.test_benchmarks.slam.driven_lap import LAP


@pytest.fixture
def page(tmp_path):
    def of(*laps, starts=(), hours=()):
        for file, kind, results in (
            ("homes", LapResult, laps), ("starts", StartResult, starts),
            ("hours", DrivenHours, hours),
        ):  # fmt: skip
            if results:
                Store(tmp_path / f"{file}.jsonl", kind).add("key", "c0ffee", "2 cores", *results)
        return slam_page(tmp_path, tmp_path.parent / "slam.md")

    return of


def test_before_any_home_was_driven_there_is_no_page(page):
    assert page() == ""


def test_homes_whose_covariances_are_not_true_are_named_with_their_bounds(page):
    text = page(LAP, replace(LAP, home=1001, nees=6.8), replace(LAP, home=1002, nees=5.2))
    assert "in 2 of 3 homes: 1001 (6.80, 5.34 to 6.70), 1002 (5.20, 5.34 to 6.70)." in text


def test_where_all_covariances_are_true_the_page_says_so(page):
    assert "In each of the 1 homes NEES lies within" in page(LAP)


def test_faults_without_rows_are_named(page):
    text = page(LAP, replace(LAP, fault=TWINS))
    left = ", ".join(fault for fault in FAULTS if fault not in (AS_RECORDED, TWINS))
    assert f"No rows are kept of: {left}." in text
    assert "No rows are kept of" not in page(*(replace(LAP, fault=fault) for fault in FAULTS))


def test_starts_and_hours_have_their_tables_where_they_are_kept(page):
    text = page(LAP)
    assert "| random starts in a saved map |" not in text and "## Hours in one home" not in text
    start = StartResult(1000, 0, True, 0.02, 0.5, 3, 90.0)
    hour = Hour(100, 9.0, 5, 1, 0.02, 20.0, 40.0, 10**9)
    text = page(starts=[start], hours=[DrivenHours(1000, 3, 5.0, (hour, hour))])
    assert "| random starts in a saved map |" in text and "## Hours in one home" in text
    assert "The last hour costs 1.00 times the first" in text


@pytest.mark.parametrize(("commit", "said"), [("c0ffee", False), ("c0ffee+", True)])
def test_sources_that_no_commit_holds_are_called_so(tmp_path, page, commit, said):
    summary = dict.fromkeys(("path_length", "rate", "ms_mean_least", "ms_mean_most"), 1.0)
    summary |= {"frames": 9, "runs": 5, "reference_kernel_ms": 40.0}
    kept = {"commit": commit, "hardware": "2 cores", "rows": [], "summary": summary}
    (tmp_path / "hololens_office").mkdir()
    (tmp_path / "hololens_office/results.json").write_text(json.dumps(kept))
    text = page(LAP)
    assert f"Commit {commit}, 2 cores." in text and ("are in none" in text) == said
