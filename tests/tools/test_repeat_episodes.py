"""What counts as the same episode, on episodes that nobody drives."""

from dataclasses import replace

import pytest
import typer

from benchmarks.episodes.episode import Episode, EpisodeResult, GoalResult
from benchmarks.harness.bench_plan import results_file
from benchmarks.harness.fingerprint import Fingerprint
from benchmarks.harness.store import Store
from tests.tools import repeat_episodes
from tests.tools.repeat_episodes import differences, drawn, kept_results, repeat, variant_of
from vizbot.core.errors import ConfigError


def result(number, steps=9):
    goal = GoalResult("bed", True, True, "", "seen", 1.0, steps, 2.0, 1.0, 1.8)
    return EpisodeResult(
        Episode(1100, ("bed",), number), (goal,), 0, 0.01, 3.0, ((0.0, 0.5),), (0.1, 0.2, 0.3)
    )


KEPT = [result(number) for number in range(30)]
MADE = Fingerprint("embedded", "homes", "episodes", "oracles", "c0ffee", "2 cores")
DEFAULT = variant_of("objectnav", "default")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """With the default row of 30 episodes."""
    monkeypatch.setattr(Fingerprint, "taken", staticmethod(lambda clip: MADE))
    store = Store(results_file(tmp_path, "objectnav", "default"), EpisodeResult)
    store.add(MADE.key_of(DEFAULT), MADE.commit, MADE.hardware, *KEPT)
    return tmp_path


def test_ten_are_drawn_the_same_every_time_in_another_order():
    chosen = drawn(KEPT)
    assert chosen == drawn(KEPT) and len(set(map(id, chosen))) == 10
    numbers = [each.episode.number for each in chosen]
    assert numbers != sorted(numbers)
    for few in range(2, 6):
        numbers = [each.episode.number for each in drawn(KEPT[:few])]
        assert numbers != sorted(numbers) and sorted(numbers) == list(range(few))


def test_all_but_the_duration_here_must_be_equal():
    assert differences(KEPT[0], replace(KEPT[0], wall_seconds=99.0)) == []
    changed = {
        "collisions": 1,
        "ate": 0.0100001,
        "stop": (0.1, 0.2, 0.30001),
        "track": ((0.0, 0.51),),
        "goals": result(0, steps=10).goals,
    }
    for name, value in changed.items():
        [line] = differences(KEPT[0], replace(KEPT[0], **{name: value}))
        assert line.startswith(f"{name}: ")


@pytest.mark.parametrize(("changed", "code", "said"), [(None, 0, "10 of 10"), (4, 1, "9 of 10")])
def test_the_end_says_whether_an_episode_differs(folder, monkeypatch, capsys, changed, code, said):
    driven = []

    def inline(work, jobs, title, describe):
        for job in jobs:
            driven.append(job[1].number)
            again = result(job[1].number, steps=10 if len(driven) == changed else 9)
            assert describe(job, again)
            yield job, replace(again, wall_seconds=7.0)

    monkeypatch.setattr(repeat_episodes, "in_parallel", inline)
    with pytest.raises(typer.Exit) as end:
        repeat(folder, "objectnav", "default")
    assert end.value.exit_code == code
    assert f"objectnav, default: {said} episodes are equal" in (out := capsys.readouterr().out)
    assert ("goals: " in out) is (changed is not None)
    assert driven == [each.episode.number for each in drawn(KEPT)]


def test_rows_of_other_sources_and_unknown_rows_are_refused(folder, monkeypatch, capsys):
    another = replace(MADE, episodes="others")
    monkeypatch.setattr(Fingerprint, "taken", staticmethod(lambda clip: another))
    with pytest.raises(ConfigError, match=r"check out its commit \(there: c0ffee\)"):
        kept_results(folder, "objectnav", DEFAULT)
    with pytest.raises(typer.Exit) as end:
        repeat(folder, "multi", "over 9 m")
    assert end.value.exit_code == 1
    assert "no row 'over 9 m' of 'multi'" in capsys.readouterr().err
    assert variant_of("multi", "over 3 m").name == "over 3 m"
