"""A robot has neither the simulator nor what measures and trains it."""

import json
import subprocess
import sys
import tomllib
from dataclasses import replace

import numpy as np
import pytest

from mapping import map_bundle
from mapping.clip.embedded.encoder import load_embedded_clip
from tests.fuzz.spoilt_sequences import write_sequence
from tests.helpers.bundles import bundle_of
from tests.helpers.checkout import ROOT
from tests.helpers.served import served

pytestmark = pytest.mark.slow

PROGRAM = """
import os, sys

class Absent:
    @staticmethod
    def find_spec(name, *_):
        if name.partition(".")[0] in os.environ["ABSENT"].split():
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Absent)
if __name__ == "__main__":  # the process of the base imports this file again
    from vizbot.cli.app import main

    main()
"""


ABSENT = "sim_stubs mujoco benchmarks training"
SETTINGS = """
serial_port = "/dev/ttyNONE"
[world]
wheel_base = 0.25
"""
"""A file that a rehearsal reads, too."""


@pytest.fixture
def vizbot(tmp_path):
    """Run a command line in an empty folder, with packages blocked."""
    (tmp_path / "blocked.py").write_text(PROGRAM)
    (tmp_path / "launch.toml").write_text(SETTINGS)

    def run(*arguments, absent=ABSENT):
        return subprocess.run(
            [sys.executable, "blocked.py", *arguments],
            cwd=tmp_path,
            env={"PYTHONPATH": str(ROOT), "PATH": "/usr/bin:/bin", "ABSENT": absent},
            capture_output=True,
            text=True,
            check=False,
        )

    return run


def test_launch_without_devices_names_them(vizbot):
    ended = vizbot(
        "launch", "--config", "launch.toml", "--force", "--port", "0", "--clip", "embedded"
    )
    assert ended.returncode == 1 and "No module" not in ended.stderr
    assert "no RealSense camera found" in ended.stderr and "/dev/ttyNONE" in ended.stderr


def test_the_doctor_examines_all_there_is(vizbot):
    ended = vizbot("doctor", "--config", "launch.toml", "--json")
    assert "No module" not in ended.stdout + ended.stderr
    for subject in ("serial port", "camera", "CLIP", "clock", "disk", "microphone"):
        assert f'"subject": "{subject}"' in ended.stdout


def test_a_map_is_asked(vizbot, tmp_path):
    encoder = load_embedded_clip()
    home = bundle_of(model_id=encoder.model_id)
    embeddings = np.eye(len(home.elements.keyframes), encoder.dimension, dtype=np.float32)
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
    ended = vizbot(*arguments, absent="mujoco")
    assert (ended.returncode, ended.stdout) == (1, "")
    assert ended.stderr == (
        "vizbot: simulated worlds need mujoco, not installed: pip install mujoco\n"
    )
    assert sorted(tmp_path.iterdir()) == before


def test_a_map_is_built(vizbot, tmp_path):
    write_sequence(tmp_path / "walk")
    ended = vizbot("map", "build", "walk", "--out", "home", "--config", "launch.toml")
    assert ended.returncode == 0, ended.stderr
    assert len(map_bundle.load(tmp_path / "home").trajectory.stamps) == 4


def test_something_is_said_to_a_robot(vizbot):
    with served() as server:
        ended = vizbot("say", "stop", "--url", server.url)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, "stopped\n", "")


def test_the_settings_are_shown_and_those_of_rehearsals_passed_over(vizbot, tmp_path):
    shown = vizbot("config", "show", "--config", "launch.toml")
    assert (shown.returncode, shown.stderr) == (0, "")
    settings = tomllib.loads(shown.stdout)
    assert settings["world"] == {"wheel_base": 0.25} and settings["mount"]["height"] == 0.6
    schema = json.loads(vizbot("config", "schema").stdout)
    assert {"mount", "world"} <= set(schema["properties"])
    assert vizbot("config", "init", "--all").returncode == 0
    assert "#height = 0.6" in (tmp_path / "robot.toml").read_text()


@pytest.mark.parametrize("command", ["launch", "map", "remote", "doctor", "dry_run", "open_run"])
def test_a_command_loads_nothing_of_the_simulator_by_its_import(command):
    script = f"import sys, vizbot.commands.{command}; print(*sys.modules)"
    ended = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    packages = {name.partition(".")[0] for name in ended.stdout.split()}
    assert "vizbot" in packages and not packages & set(ABSENT.split())
    assert "vizbot.rehearsal" not in ended.stdout
