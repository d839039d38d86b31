"""The whole loop in simulation."""

import json
import re
import sys
from contextlib import redirect_stdout
from functools import cache, partial
from io import StringIO

import cv2
import numpy as np
import pytest

from mapping import map_bundle
from tests.helpers.rrd import at, rows
from vizbot.cli import app as cli

pytestmark = pytest.mark.slow


def run_in(folder, *arguments):
    """Exit code and what is printed."""
    with pytest.MonkeyPatch.context() as patched, redirect_stdout(StringIO()) as out:
        patched.chdir(folder)
        patched.setattr(sys, "argv", ["vizbot", "dry-run", "--json", *arguments])
        with pytest.raises(SystemExit) as end:
            cli.main()
    return end.value.code, json.loads(out.getvalue())


@pytest.fixture
def dry_run(tmp_path):
    return partial(run_in, tmp_path)


SHORT = "[objectnav]\nmax_steps = 12\n"


@pytest.fixture(scope="module")
def short_run(tmp_path_factory):
    """Runs twelve steps in a world; each run is made once."""
    home = tmp_path_factory.mktemp("short")
    (home / "short.toml").write_text(SHORT)

    @cache
    def short_run(out, world):
        arguments = ("--world", world, "--config", "short.toml", "--out", out)
        return *run_in(home, "yellow chair", *arguments), home / out

    return short_run


def test_a_run_is_the_same_twice_byte_for_byte_and_another_seed_is_not(short_run):
    trajectories = []
    for out, world in (("a", "5"), ("b", "5"), ("c", "6")):
        code, result, run = short_run(out, world)
        assert code == 1
        assert result["goals"][0]["outcome"] == "gave_up"
        assert not result["success"] and not result["claimed"] and result["judged"]
        assert result["steps"] == 12
        trajectories.append((run / "trajectory.tum").read_bytes())
    assert trajectories[0] == trajectories[1]
    assert trajectories[0] != trajectories[2]


def test_a_run_leaves_its_folder_whole(short_run):
    _, result, run = short_run("a", "5")
    assert {path.name for path in run.iterdir()} == {
        "commands.csv", "config.toml", "map", "metrics.json", "report.html", "run.webm",
        "trajectory.tum", "vizbot.log",
    }  # fmt: skip
    assert json.loads((run / "metrics.json").read_text()) == result
    log = (run / "vizbot.log").read_text()
    for event in ("vizbot 0.", "encoder embedded-", "camera sim, base sim, world 5", "map saved"):
        assert event in log
    ended = r"goal ended: Gave up on the yellow chair after \d+ s, 0\.0 m: not done within 12 steps"
    assert re.search(ended, log)
    assert "steps 12" in log.splitlines()[-1]
    lines = (run / "trajectory.tum").read_text().splitlines()
    assert len([line for line in lines if not line.startswith("#")]) == result["steps"]


def test_a_run_whose_map_cannot_be_saved_ends_in_one_line_and_keeps_all_else(
    run, tmp_path, monkeypatch
):
    (tmp_path / "short.toml").write_text(SHORT)
    monkeypatch.setattr(map_bundle, "MOST_BYTES", 1000)
    arguments = ("--world", "5", "--config", "short.toml", "--out", "run", "--json")
    code, out, err = run("dry-run", "yellow chair", *arguments)
    told = err.splitlines()[-1]
    assert code == 1 and "run/map is not saved, it has " in told
    result, folder = json.loads(out), tmp_path / "run"
    assert result["map"] is None and f"vizbot: {result['map_error']}" == told
    assert json.loads((folder / "metrics.json").read_text()) == result
    assert f"The map is not kept: {result['map_error']}" in (folder / "report.html").read_text()
    for name in ("trajectory.tum", "commands.csv"):
        assert len((folder / name).read_text().splitlines()) == 1 + result["steps"] == 13


def test_an_exploration_cut_short_is_no_success_and_the_map_is_asked_all_the_same(
    dry_run, tmp_path
):
    (tmp_path / "short.toml").write_text("[objectnav]\nmax_exploration_steps = 5\n")
    code, result = dry_run(
        "yellow chair", "--explore", "--world", "5", "--config", "short.toml", "--out", "run"
    )
    assert code == 1
    assert not result["success"] and not result["judged"] and result["steps"] == 5
    (goal,) = result["goals"]
    assert goal["text"] == "yellow chair" and goal["outcome"] in ("located", "not_found")
    assert (tmp_path / "run" / "map").is_dir()


@pytest.mark.long
def test_an_exploration_without_goals_ends_when_nothing_is_left_to_see(dry_run):
    code, result = dry_run("--explore", "--world", "0", "--out", "run")
    assert code == 0
    assert result["success"] and result["claimed"] and not result["judged"]
    assert result["goals"] == []


@pytest.mark.long
def test_the_robot_goes_to_the_yellow_chair_in_nine_of_ten_homes(dry_run):
    results = [dry_run("yellow chair", "--world", str(seed))[1] for seed in range(10)]
    arrived = [result["success"] for result in results]
    assert sum(arrived) >= 9, arrived
    assert [result["claimed"] for result in results] == arrived


def test_a_recording_is_mapped_to_its_end_and_then_asked(
    dry_run, tmp_path, monkeypatch, mean_colours
):
    monkeypatch.setattr("vizbot.commands.open_run.open_encoder", lambda *_: mean_colours)
    for screen in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(screen, raising=False)
    rng = np.random.default_rng(0)
    walk = tmp_path / "walk"
    (walk / "rgb").mkdir(parents=True)
    (walk / "depth").mkdir()
    texture = rng.integers(0, 255, (60, 80, 1), np.uint8).repeat(3, axis=2)
    colour = cv2.resize(texture, (640, 480), interpolation=cv2.INTER_CUBIC)
    colour[:440, 60:600] = (10, 220, 240)  # yellow, as OpenCV orders it
    names = [f"{i}.png" for i in range(3)]
    for name in names:
        cv2.imwrite(str(walk / "rgb" / name), colour)
        cv2.imwrite(str(walk / "depth" / name), np.full((480, 640), 2000, np.uint16))
    lines = [f"{i}.0 rgb/{name} {i}.0 depth/{name}\n" for i, name in enumerate(names)]
    (walk / "associations.txt").write_text("".join(lines))
    code, result = dry_run(
        "go to the yellow chair", '"blue chair"', "--camera", "walk", "--out", "run",
        "--intrinsics", "600,600,319.5,239.5,1000", "--rerun",
    )  # fmt: skip
    assert code == 0
    assert result["success"] and not result["judged"] and result["steps"] == 3
    assert [goal["text"] for goal in result["goals"]] == ["yellow chair", "blue chair"]
    assert [goal["outcome"] for goal in result["goals"]] == ["located", "not_found"]
    assert result["simulated_seconds"] is None and result["collisions"] is None
    frames = map_bundle.load(tmp_path / "run" / "map").elements.frames
    assert set(np.unique(frames, return_counts=True)[1].tolist()) == {25}, "whole pictures"
    recorded = tmp_path / "run" / "run.rrd"
    shown = [row["step"] for row in rows(recorded, "map/robot")]
    assert shown[0] == 0 and set(shown) <= {0, 1, 2}, "a step without news is left out"
    assert at(recorded, "map/elements/0000", 2)["score"] is not None
    assert "yellow chair: 1, probability" in rows(recorded, "map/answers")[0]["Points3D:labels"][0]
    assert 'alt="what place 1 was found in"' in (tmp_path / "run" / "report.html").read_text()
