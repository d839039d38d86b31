"""A robot has no MuJoCo, which simulated worlds alone need."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from mapping import map_bundle
from mapping.clip.embedded.encoder import load_embedded_clip
from tests.helpers.bundles import bundle_of
from tests.helpers.checkout import ROOT

PROGRAM = """
import sys

sys.modules["mujoco"] = None
if __name__ == "__main__":  # the process of the base imports this file again
    from vizbot.cli.app import main

    main()
"""


@pytest.fixture
def vizbot(tmp_path):
    """Run a command line in an empty folder, with MuJoCo blocked."""
    (tmp_path / "blocked.py").write_text(PROGRAM)
    (tmp_path / "launch.toml").write_text('serial_port = "/dev/ttyNONE"\n')

    def run(*arguments):
        return subprocess.run(
            [sys.executable, "blocked.py", *arguments],
            cwd=tmp_path,
            env={"PYTHONPATH": str(ROOT), "PATH": "/usr/bin:/bin"},
            capture_output=True,
            text=True,
            check=False,
        )

    return run


def test_launch_without_devices_names_them(vizbot):
    ended = vizbot(
        "launch", "--config", "launch.toml", "--force", "--port", "0", "--clip", "embedded"
    )
    assert ended.returncode == 1 and "mujoco" not in ended.stderr
    assert "no RealSense camera found" in ended.stderr and "/dev/ttyNONE" in ended.stderr


def test_the_doctor_examines_all_there_is(vizbot):
    ended = vizbot("doctor", "--config", "launch.toml", "--json")
    assert "mujoco" not in ended.stdout + ended.stderr
    for subject in ("serial port", "camera", "CLIP", "clock", "disk", "microphone"):
        assert f'"subject": "{subject}"' in ended.stdout


def test_a_map_is_asked(vizbot, tmp_path):
    encoder = load_embedded_clip()
    home = bundle_of(model_id=encoder.model_id)
    rows = len(home.elements.keyframes)
    embeddings = np.eye(rows, encoder.dimension, dtype=np.float32)
    elements = replace(home.elements, embeddings=embeddings)
    home = replace(home, elements=elements, pictures=embeddings)
    map_bundle.save(home, tmp_path / "home")
    ended = vizbot("map", "query", "home", "sofa")
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout.startswith("sofa: ") and "probability" in ended.stdout


@pytest.mark.parametrize(
    "arguments", [("dry-run", "chair"), ("stub", "realsense", "--out", "x.db3")]
)
def test_what_needs_a_simulated_world_names_the_package_in_one_line(vizbot, tmp_path, arguments):
    before = sorted(tmp_path.iterdir())
    ended = vizbot(*arguments)
    assert (ended.returncode, ended.stdout) == (1, "")
    assert ended.stderr == (
        "vizbot: simulated worlds need mujoco, not installed: pip install mujoco\n"
    )
    assert sorted(tmp_path.iterdir()) == before
