"""The scoreboard's bookkeeping, on episodes that nobody drives."""

from pathlib import Path

import pytest

from vizbot.bench import board, fingerprint, objectnav
from vizbot.bench.board import Board
from vizbot.bench.episodes import Episode, EpisodeResult, GoalResult, HomeGoals
from vizbot.config import Config

GOALS = ("bed", "chair", "sofa", "kitchen", "window")


def driven(job, fails=()):
    """What a robot would do that fails at some goals, unless it has a counterpart for them."""
    variant, episode = job
    success = episode.goals[0] not in fails or variant.counterpart == "encoder"
    reason = "" if success else "3.00 m away"
    answer = GoalResult(episode.goals[0], success, True, reason, "seen", 3.0, 100, 8.0, 4.0, 20.0)
    return EpisodeResult(episode, (answer,), 0, 0.01, 5.0, ((0.0, 0.0),), (0.0, 0.0, 0.0))


@pytest.fixture
def fake(monkeypatch):
    """Homes and episodes without a simulator; which episodes were driven, in order."""
    ran = []

    def inline(work, jobs, title, describe):
        for job in jobs:
            result = HomeGoals(job, GOALS) if title == "homes" else driven(job, ("sofa", "window"))
            if title != "homes":
                ran.append((job[0].name, job[1]))
            describe(job, result)
            yield job, result

    monkeypatch.setattr(board, "in_parallel", inline)
    monkeypatch.setattr(fingerprint, "home_key", lambda: "homes")
    monkeypatch.setattr(fingerprint, "key_of", lambda variant: f"key of {variant.name}")
    return ran


def asked(tmp_path: Path, **options) -> Board:
    return Board(Config(), tmp_path, **options)


def test_homes_are_taken_in_order_until_there_are_54_episodes(fake, tmp_path):
    objectnav.run(asked(tmp_path, rows=("default",)))
    homes = [episode.home for _, episode in fake]
    assert homes == sorted(homes)
    assert sorted(set(homes)) == list(range(1000, 1011))
    assert len(fake) == 55


def test_every_goal_of_every_home_is_one_episode(fake, tmp_path):
    objectnav.run(asked(tmp_path, rows=("default",), homes=(1007, 1003)))
    assert fake == [("default", Episode(h, (goal,))) for h in (1007, 1003) for goal in GOALS]


def test_the_rows_are_driven_on_the_same_episodes(fake, tmp_path):
    objectnav.run(asked(tmp_path, homes=(1000,)))
    of_row = {}
    for row, episode in fake:
        of_row.setdefault(row, []).append(episode)
    assert of_row["scale 1"] == of_row["scale 0"] == of_row["scale -1"] == of_row["default"]
    assert [v.config.perception.clip_mapper.scales for v in objectnav.variants(Config())][:4] == [
        (1, 0, -1), (1,), (0,), (-1,)
    ]  # fmt: skip


def test_counterparts_repeat_what_failed_and_as_many_that_succeeded(fake, tmp_path):
    outcome = objectnav.run(asked(tmp_path, homes=(1000,)))
    for part in ("pose", "depth", "encoder", "map"):
        repeated = [episode.goals[0] for row, episode in fake if row == f"true {part}"]
        assert repeated[:2] == ["sofa", "window"]
        assert len(set(repeated)) == 4
    lines = {line.split("|")[1].strip(): line for line in outcome.text.splitlines() if "|" in line}
    assert "2 of 2 " in lines["true encoder"] and "0 of 2" not in lines["true encoder"]
    assert "0 of 2 " in lines["true pose"]
    assert "Of 2 failed episodes the truth about one part mends 2" in outcome.text


def test_a_second_run_does_only_what_is_missing(fake, tmp_path):
    objectnav.run(asked(tmp_path, rows=("default",), homes=(1000,)))
    fake.clear()
    objectnav.run(asked(tmp_path, rows=("default",), homes=(1000, 1001)))
    assert {episode.home for _, episode in fake} == {1001}


def test_a_run_that_is_killed_keeps_what_was_finished(fake, tmp_path, monkeypatch):
    through = board.in_parallel

    def killed(work, jobs, title, describe):
        for count, finished in enumerate(through(work, jobs, title, describe)):
            if title != "homes" and count == 3:
                raise KeyboardInterrupt
            yield finished

    monkeypatch.setattr(board, "in_parallel", killed)
    with pytest.raises(KeyboardInterrupt):
        objectnav.run(asked(tmp_path, rows=("default",), homes=(1000,)))
    fake.clear()
    monkeypatch.setattr(board, "in_parallel", through)
    objectnav.run(asked(tmp_path, rows=("default",), homes=(1000,)))
    assert [episode.goals[0] for _, episode in fake] == ["kitchen", "window"]


def test_quick_takes_every_third_episode_of_four_homes_and_says_that_it_claims_nothing(
    fake, tmp_path
):
    outcome = objectnav.run(asked(tmp_path, quick=True))
    assert {row for row, _ in fake} == {"default"}
    assert {episode.home for _, episode in fake} == {1000, 1001, 1002, 1003}
    assert len(fake) == 7
    assert outcome.text.startswith("A smoke test")


def test_the_paper_stands_beside_ours_and_is_marked(fake, tmp_path):
    outcome = objectnav.run(asked(tmp_path, rows=("default",), homes=(1000,)))
    quoted = [row for row in outcome.rows if "source" in row]
    assert len(quoted) == 5
    assert {row["source"] for row in quoted} == {"paper, not run here"}
    assert quoted[-1]["success_rate"] == pytest.approx(0.87)
    assert outcome.text.count("paper, not run here") == 6
    scales = next(line for line in outcome.text.splitlines() if line.startswith("| {1, 0, -1} "))
    assert [cell.strip() for cell in scales.split("|")[2:5]] == ["25", "87.0", "60.0"]


def test_the_summary_has_what_checks_read(fake, tmp_path):
    summary = objectnav.run(asked(tmp_path, rows=("default",), homes=(1000,))).summary
    assert set(summary) == {
        "episodes", "success_rate", "success_low", "success_high", "others_success_rate", "spl"
    }  # fmt: skip
    assert summary["episodes"] == 5
    assert summary["success_rate"] == 0.6
    assert summary["success_low"] == pytest.approx(0.2307, abs=1e-4)
    assert summary["others_success_rate"] == 0.5
    assert summary["spl"] == pytest.approx(0.3)


def test_where_nothing_failed_there_is_nobody_to_blame():
    results = [driven((objectnav.variants(Config())[0], Episode(1000, ("bed",))))]
    assert objectnav.failed_and_as_many(results) == []
