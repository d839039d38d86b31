import json

import pytest

from benchmarks.episodes.episode import Episode, EpisodeResult, GoalResult, HomeGoals
from benchmarks.harness.store import Store
from vizbot.core.errors import ConfigError


def result(goal="sofa", number=0):
    answer = GoalResult(goal, True, True, "", "seen", 1.25, 80, 6.5, None, 16.2)
    episode = Episode(1001, (goal,), number)
    return EpisodeResult(episode, (answer,), 0, None, 12.0, ((0.0, 1.0), (2.5, 1.0)), (2, 1, 0.1))


def test_a_result_comes_back_as_it_was_kept(tmp_path):
    Store(tmp_path / "new" / "a.jsonl", EpisodeResult).add("k", "c0ffee", "2 cores", result())
    again = Store(tmp_path / "new" / "a.jsonl", EpisodeResult)
    assert again.results_with_key("k") == [result()]
    assert hash(again.results_with_key("k")[0].episode) == hash(result().episode)
    assert again.fullest()[0].commit == "c0ffee"


def test_results_of_another_key_do_not_count(tmp_path):
    store = Store(tmp_path / "a.jsonl", EpisodeResult)
    store.add("old", "a", "", result("tv"), result("bed"))
    store.add("new", "b", "", result("sofa"))
    assert store.results_with_key("new") == [result("sofa")]
    assert store.results_with_key("other") == []


def test_the_fullest_key_is_shown_and_the_newer_of_two_as_full(tmp_path):
    store = Store(tmp_path / "a.jsonl", HomeGoals)
    assert store.fullest() == []
    store.add("old", "a", "", HomeGoals(1, ()), HomeGoals(2, ()))
    store.add("new", "b", "", HomeGoals(1, ("tv",)))
    assert {kept.key for kept in store.fullest()} == {"old"}
    store.add("new", "b", "", HomeGoals(2, ()))
    assert {kept.key for kept in store.fullest()} == {"new"}


def test_a_finished_row_leaves_no_others_behind(tmp_path):
    store = Store(tmp_path / "a.jsonl", HomeGoals)
    store.add("old", "a", "", HomeGoals(1, ()))
    store.add("new", "b", "", HomeGoals(1, ()))
    store.drop_others("new")
    lines = (tmp_path / "a.jsonl").read_text().splitlines()
    assert [json.loads(line)["key"] for line in lines] == ["new"]


@pytest.mark.parametrize(
    "line",
    [
        b"{",
        b'{"key": "k"}',
        b"[]",
        b"[1]",
        b"1",
        b"1.5",
        b"null",
        b"true",
        b'"key"',
        b"NaN",
        b"[" * 5000,
        b'{"key":1,"commit":1,"hardware":1}',
        b'{"key":["k"],"commit":"c","hardware":"","home":1,"goals":[]}',
        b"\xff\xfe",
        b"\x00",
    ],
)
def test_a_line_that_is_no_result_is_named(tmp_path, line):
    path = tmp_path / "a.jsonl"
    Store(path, HomeGoals).add("k", "c", "", HomeGoals(1, ()))
    path.write_bytes(path.read_bytes() + line + b"\n")
    with pytest.raises(ConfigError, match=r"a\.jsonl, line 2"):
        Store(path, HomeGoals)


def test_a_folder_in_the_place_of_the_results_is_told_in_a_line(tmp_path):
    with pytest.raises(ConfigError, match="cannot be read: Is a directory"):
        Store(tmp_path, HomeGoals)
