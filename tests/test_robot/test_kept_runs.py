"""What a run keeps where its map, or any other part of its folder, cannot be written."""

import json
import os
import shutil
import tempfile
from pathlib import Path
from types import SimpleNamespace

import pytest

from mapping import map_bundle
from mapping.tum import read_trajectory
from tests.helpers.bundles import NO_MAP, a_full_disk, bundle_of
from tests.test_robot.test_recorder import step
from vizbot.commands import launch
from vizbot.commands.open_run import OpenRun
from vizbot.config import Config
from vizbot.core.errors import DeviceError, MapError
from vizbot.operator.report.report import Report
from vizbot.recorder import Recorder

NOBODY = 65534


def recorded_in(folder):
    """A recorder of two steps."""
    recorder = Recorder(folder, Config())
    for stamp in (0.25, 0.5):
        recorder.on_step(step(stamp))
    return recorder


@pytest.fixture
def recorder(tmp_path):
    return recorded_in(tmp_path / "run")


@pytest.mark.parametrize("cause", NO_MAP)
def test_a_run_whose_map_cannot_be_saved_keeps_all_else(recorder, monkeypatch, cause):
    cause(monkeypatch)
    metrics, error = recorder.finish(bundle_of, {"success": True})
    assert error is not None and not isinstance(error, OSError)
    assert metrics["success"] and metrics["map"] is None and NO_MAP[cause] in metrics["map_error"]
    assert_all_but_the_map(recorder.folder, metrics)
    assert not (recorder.folder / "map").exists()


def assert_all_but_the_map(run, metrics):
    assert json.loads((run / "metrics.json").read_text()) == metrics
    assert read_trajectory(run / "trajectory.tum")[0].tolist() == [0.25, 0.5]
    assert (run / "commands.csv").read_text().splitlines() == [
        "stamp,linear,angular,by", "0.250,0.200,-0.500,robot", "0.500,0.200,-0.500,robot",
    ]  # fmt: skip


def test_a_run_whose_folder_is_lost_writes_all_of_it_again(recorder):
    shutil.rmtree(recorder.folder)
    metrics, error = recorder.finish(bundle_of, {})
    assert error is None and metrics["map"] == str(recorder.folder / "map")
    assert_all_but_the_map(recorder.folder, metrics)
    assert len(map_bundle.load(recorder.folder / "map").keyframes.ids)


@pytest.fixture
def read_only_run():
    """A run in a folder that nobody may write to any more, not even who may write everywhere."""
    shared = Path(tempfile.mkdtemp())  # not of pytest: other users may enter it
    shared.chmod(0o755)
    recorder = recorded_in(shared / "run")
    recorder.folder.chmod(0o555)
    if os.geteuid() == 0:
        os.seteuid(NOBODY)
    yield recorder
    os.seteuid(os.getuid())
    recorder.folder.chmod(0o755)
    shutil.rmtree(shared)


def test_a_run_whose_folder_is_read_only_says_so_and_what_was_driven_stays(read_only_run):
    metrics, error = read_only_run.finish(bundle_of, {"success": True})
    assert "Permission denied" in str(error) and "\n" not in str(error)
    assert metrics["success"] and metrics["map"] is None
    assert "Permission denied" in metrics["map_error"]
    assert read_trajectory(read_only_run.folder / "trajectory.tum")[0].tolist() == [0.25, 0.5]
    assert len((read_only_run.folder / "commands.csv").read_text().splitlines()) == 3


def test_a_run_without_a_frame_has_no_map_and_no_error(recorder):
    metrics, error = recorder.finish(lambda: None, {})
    assert error is None and (metrics["map"], metrics["map_error"]) == (None, "there was no frame")


def opened_with(recorder, bundle=bundle_of, close=lambda: None, finish=lambda: None):
    """An open run, as far as it is written."""
    return OpenRun(
        config=Config(),
        devices=None,
        close=close,
        rehearsal=None,
        pipeline=SimpleNamespace(
            bundle=bundle, finish=finish, map=SimpleNamespace(has_frames=False)
        ),
        recorder=recorder,
        report=Report(recorder.folder, None),
        notice=None,
        served=None,
        began=0.0,
    )


def test_the_report_says_why_there_is_no_map(recorder, monkeypatch):
    a_full_disk(monkeypatch)
    opened = opened_with(recorder)
    _, error = opened.write(opened.totals())
    assert isinstance(error, MapError)
    page = (recorder.folder / "report.html").read_text()
    assert "The map is not kept: cannot save the map" in page and "No space left" in page
    monkeypatch.undo()


def test_the_report_of_a_run_with_a_map_says_nothing_of_it(recorder):
    opened = opened_with(recorder)
    assert opened.write(opened.totals())[1] is None
    assert "not kept" not in (recorder.folder / "report.html").read_text()


def test_a_report_that_cannot_be_written_costs_nothing_else(recorder):
    (recorder.folder / "report.html").mkdir()
    opened = opened_with(recorder)
    metrics, error = opened.write(opened.totals())
    assert "report.html is there and is not a file" in str(error)
    assert_all_but_the_map(recorder.folder, metrics)
    assert len(map_bundle.load(recorder.folder / "map").keyframes.ids)


def gone(*_):
    raise DeviceError("the base is gone")


@pytest.mark.parametrize("part", ["serve", "close", "finish"])
def test_a_launch_that_fails_anywhere_keeps_the_run_and_says_what_failed(
    recorder, monkeypatch, part
):
    monkeypatch.setattr(launch, "_take_dictation", lambda *_: None)
    parts = {part: gone} if part != "serve" else {}
    opened = opened_with(recorder, **parts)
    served = SimpleNamespace(base=None, session=None, serve=lambda *_: None)
    if part == "serve":
        served.serve = gone
    with pytest.raises(DeviceError, match="the base is gone"):
        launch._serve(opened, served, None, None)
    metrics = json.loads((recorder.folder / "metrics.json").read_text())
    assert metrics["error"] == "the base is gone" and metrics["map"] is not None
    assert_all_but_the_map(recorder.folder, metrics)
    assert (recorder.folder / "report.html").exists()
