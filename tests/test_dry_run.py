"""The whole loop in simulation."""

import json
import sys

import pytest

from vizbot import cli


@pytest.fixture
def dry_run(monkeypatch, capfd, tmp_path):
    def run(*arguments):
        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr(sys, "argv", ["vizbot", "dry-run", "--json", *arguments])
        with pytest.raises(SystemExit) as end:
            cli.main()
        out, _ = capfd.readouterr()
        return end.value.code, json.loads(out)

    return run


SHORT = "[objectnav]\nmax_steps = 12\n"


def test_a_run_is_the_same_twice_byte_for_byte_and_another_seed_is_not(dry_run, tmp_path):
    (tmp_path / "short.toml").write_text(SHORT)
    trajectories = []
    for out, world in (("a", "5"), ("b", "5"), ("c", "6")):
        code, result = dry_run(
            "yellow chair", "--world", world, "--config", "short.toml", "--out", out
        )
        assert code == 1
        assert result["goals"][0]["outcome"] == "gave_up"
        assert not result["success"] and not result["claimed"] and result["judged"]
        assert result["steps"] == 12
        trajectories.append((tmp_path / out / "trajectory.tum").read_bytes())
    assert trajectories[0] == trajectories[1]
    assert trajectories[0] != trajectories[2]


def test_a_run_leaves_its_folder_whole(dry_run, tmp_path):
    (tmp_path / "short.toml").write_text(SHORT)
    _, result = dry_run("yellow chair", "--config", "short.toml", "--out", "run")
    run = tmp_path / "run"
    names = {path.name for path in run.iterdir()}
    assert names == {
        "config.toml", "map", "metrics.json", "report.html", "run.webm", "trajectory.tum"
    }  # fmt: skip
    assert json.loads((run / "metrics.json").read_text()) == result
    lines = (run / "trajectory.tum").read_text().splitlines()
    assert len([line for line in lines if not line.startswith("#")]) == result["steps"]


@pytest.mark.long
@pytest.mark.parametrize("seed", range(10))
def test_the_robot_goes_to_the_yellow_chair(dry_run, seed):
    code, result = dry_run("yellow chair", "--world", str(seed))
    assert code == 0, result
    assert result["success"] and result["claimed"]
