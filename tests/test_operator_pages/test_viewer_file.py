"""The file that `--rerun` writes: killed programs, full disks, viewers that follow it."""

import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sim_stubs.faults.faulty_program import full_disk
from tests.helpers.checkout import ROOT
from tests.helpers.roomba_rig import wait_for
from tests.helpers.rrd import rows
from tests.helpers.served import resting
from vizbot.core.errors import ConfigError
from vizbot.operator.viewer.open_viewer import require_rerun
from vizbot.operator.viewer.viewer import Viewer


@pytest.mark.filterwarnings("ignore:RRD file has no footer")
def test_what_was_recorded_can_be_read_before_the_end_as_after_a_kill(tmp_path):
    with Viewer(tmp_path / "run.rrd") as viewer:
        for index in range(3):
            viewer.on_step(resting(index))
        viewer._recording.flush()

        def left():
            shutil.copy(tmp_path / "run.rrd", tmp_path / "left.rrd")
            try:
                return len(rows(tmp_path / "left.rrd", "map/robot"))
            except RuntimeError:  # copied in the middle of a message
                return 0

        wait_for(lambda: left() == 3)


def test_a_disk_that_fills_up_costs_the_recording_not_the_run(tmp_path, caplog):
    noise = np.random.default_rng(0).integers(0, 255, (480, 640, 3), np.uint8)
    step = replace(resting(0), frame=replace(resting(0).frame, rgb=noise))
    with Viewer(tmp_path / "run.rrd") as viewer, full_disk(100_000):
        for index in range(20):
            viewer.on_step(replace(step, index=index))
        viewer.close()
    assert "run.rrd is not whole" in caplog.text and "free some space" in caplog.text


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
def test_a_disk_that_is_full_is_told_before_the_run(tmp_path):
    (tmp_path / "run.rrd").symlink_to("/dev/full")
    with pytest.raises(ConfigError, match=r"run\.rrd.*No space left.*free some space"):
        Viewer(tmp_path / "run.rrd")


def test_a_viewer_follows_the_file_until_the_program_ends(tmp_path):
    path, shown = tmp_path / "a run.rrd", tmp_path / "shown"
    path.write_bytes(b"first ")
    script = (
        "from pathlib import Path; from vizbot.operator.viewer.open_viewer import show_recording;"
        f"path = Path({str(path)!r}); show_recording(path, 'tee {shown}');"
        "path.open('ab').write(b'second')"
    )
    subprocess.run([sys.executable, "-c", script], cwd=ROOT, check=True)
    wait_for(lambda: shown.exists() and shown.read_bytes() == b"first second")


def test_rerun_that_is_missing_is_one_line_with_the_remedy(monkeypatch):
    monkeypatch.setitem(sys.modules, "rerun", None)
    with pytest.raises(ConfigError, match=r"--rerun needs rerun-sdk.*pip install rerun-sdk"):
        require_rerun()
