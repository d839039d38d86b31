"""Nothing is compiled while a wheel turns."""

import json
import os
import subprocess
import sys

import pytest
from numba import types
from numba.core.dispatcher import Dispatcher

from tests.helpers.checkout import ROOT
from vizbot.config import Config
from vizbot.core.program import kernel_folder
from vizbot.pipeline import Pipeline
from vizbot.rehearsal.rig import Rig

_PROGRAM = """
import json
from numba.core import event

listener = event.RecordingListener()
event.register("numba:compile", listener)
from tests.conftest import MeanColours
from vizbot.config import Config
from vizbot.pipeline import Pipeline
from vizbot.rehearsal.rig import Rig

config = Config()
with Rig(config, "sim", "sim", "1100") as rig:
    pipeline = Pipeline(rig.devices, MeanColours(), config, [])
    goal, before = pipeline.goal("red"), len(listener.buffer)
    for _ in range(60):
        pipeline.tick(goal)
print(json.dumps([before, len(listener.buffer) - before]))
"""
"""What counts the events of numba's compiler before the first tick and after it."""
_INTERRUPTED = """
import random
import signal

import numpy as np

from mapping.odometry.pose_refinement import refine

rng = np.random.default_rng(0)
pixels, points = rng.uniform(0.0, 600.0, (30, 2)), rng.uniform(1.0, 3.0, (30, 3))
camera = np.array([600.0, 600.0, 320.0, 240.0])


def interrupt(number, frame):
    raise KeyboardInterrupt


signal.signal(signal.SIGALRM, interrupt)
interrupts = 0
for _ in range(2000):
    try:
        signal.setitimer(signal.ITIMER_REAL, random.uniform(1e-5, 3e-4))
        while True:
            T, agrees, hessian, scatter = refine(
                np.eye(4), (pixels, points, pixels, points), camera, 1.0, 0.01
            )
    except KeyboardInterrupt:
        interrupts += 1
print(interrupts)
"""
"""Signals that arrive anywhere in the kernel that is called most often."""
_WITHOUT_A_HOME = """
import os
from vizbot.core.program import kernel_folder
kernel_folder.__file__ = "/proc/nowhere/vizbot/core/program/kernel_folder.py"
from pathlib import Path
import numba
import nav.explored_area
folder = Path(os.environ["NUMBA_CACHE_DIR"])
print(folder, len(list(folder.rglob("*.nbi"))), str(folder) == numba.config.CACHE_DIR)
"""
_NOWHERE_AT_ALL = """
import tempfile
from vizbot.core.program import kernel_folder
kernel_folder.__file__ = "/proc/nowhere/vizbot/core/program/kernel_folder.py"
tempfile.tempdir = "/proc/nowhere"
try:
    import vizbot.core.program.kernels
except Exception as error:
    print(f"{type(error).__name__}: {error}")
"""
NOWHERE = {"HOME": "/proc/nowhere", "XDG_CACHE_HOME": "/proc/nowhere"}
OURS = ("nav", "mapping", "vizbot", "drivers", "sim_stubs")


def kernels():
    """Our kernels that have been imported, by name."""
    ours = [each for name, each in sys.modules.items() if name.split(".")[0] in OURS]
    found = [each for module in ours for each in vars(module).values()]
    return {
        f"{each.py_func.__module__}.{each.py_func.__name__}": each
        for each in found
        if issubclass(type(each), Dispatcher)
    }


def signatures():
    """How many signatures each of our kernels has."""
    return {name: len(kernel.signatures) for name, kernel in kernels().items()}


def returns_arrays_in_a_tuple(kernel):
    returned = [signature.return_type for signature in kernel.nopython_signatures]
    return any(
        isinstance(each, types.BaseTuple) and any(isinstance(t, types.Array) for t in each)
        for each in returned
    )


def ran(program, folder, **environment):
    """What a program printed, which ended well."""
    path = folder / "program.py"
    path.write_text(program)
    environment = os.environ | {"PYTHONPATH": str(ROOT)} | environment
    done = subprocess.run(
        [sys.executable, path], env=environment, capture_output=True, text=True, check=True
    )
    return json.loads(done.stdout)


def drive(encoder, ticks=30):
    """Signatures before the first tick and after the last."""
    config = Config()
    with Rig(config, "sim", "sim", "1100") as rig:
        pipeline = Pipeline(rig.devices, encoder, config, [])
        goal, before = pipeline.goal("red"), signatures()
        moved = 0
        for _ in range(ticks):
            step = pipeline.tick(goal)
            moved += step.command.angular != 0.0 or step.command.linear != 0.0
        pipeline.look_up(goal)
        assert moved > ticks / 3
        return before, signatures()


@pytest.mark.slow
def test_a_drive_meets_no_kernel_with_arguments_that_it_was_not_compiled_for(mean_colours):
    before, after = drive(mean_colours)
    assert len(before) > 15
    assert after == before


def test_no_kernel_that_python_calls_returns_a_tuple_with_arrays():
    """An interrupt while numba wraps such arrays leaves an empty place in the tuple: a crash."""
    called = {name: each for name, each in kernels().items() if not each._can_compile}
    assert len(called) > 10
    assert [name for name, each in called.items() if returns_arrays_in_a_tuple(each)] == []


@pytest.mark.slow
def test_a_signal_within_a_kernel_is_an_interrupt_and_no_crash(tmp_path):
    assert ran(_INTERRUPTED, tmp_path) == 2000


@pytest.mark.long
def test_from_an_empty_cache_everything_is_compiled_before_the_first_tick(tmp_path):
    before, during = ran(_PROGRAM, tmp_path, NUMBA_CACHE_DIR=str(tmp_path / "cache"))
    assert before > 15
    assert during == 0


def imported(program, **environment):
    """A Python that ran a program with no folder for kernels but these."""
    kept = {name: each for name, each in os.environ.items() if name != "NUMBA_CACHE_DIR"}
    return subprocess.run(
        [sys.executable, "-c", program],
        cwd=ROOT,
        env=kept | environment,
        capture_output=True,
        text=True,
    )


@pytest.mark.slow
def test_an_account_that_can_write_neither_home_nor_installation_compiles_for_one_run(tmp_path):
    done = imported(_WITHOUT_A_HOME, **NOWHERE, TMPDIR=str(tmp_path))
    folder, count, known = done.stdout.split()
    assert folder.startswith(str(tmp_path)) and int(count) > 0 and known == "True"
    [line] = done.stderr.splitlines()
    assert "neither the installation nor a home can be written" in line
    assert "NUMBA_CACHE_DIR" in line
    assert list(tmp_path.iterdir()) == []


def test_an_account_that_can_write_nowhere_at_all_is_told_in_a_line():
    done = imported(_NOWHERE_AT_ALL, **NOWHERE)
    assert done.stdout.startswith("ConfigError: no folder can be written"), done.stderr
    assert "set TMPDIR or NUMBA_CACHE_DIR" in done.stdout


@pytest.mark.slow
def test_what_compiles_first_says_what_takes_its_first_minutes(tmp_path):
    program = (
        "from vizbot.cli.logs import show_warnings; show_warnings()\n"
        "import vizbot.core.program.kernels"
    )
    [line] = imported(program, NUMBA_CACHE_DIR=str(tmp_path)).stderr.splitlines()
    assert line == "NOTE: compiling what computes maps and ways, once: one to two minutes"
    (tmp_path / "nav_1").mkdir()
    (tmp_path / "nav_1/costmap.inflate-8.py311.nbi").touch()
    assert imported(program, NUMBA_CACHE_DIR=str(tmp_path)).stderr == ""


def test_a_run_without_compiled_kernels_says_what_takes_its_first_minutes(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    assert kernel_folder.is_empty()
    (tmp_path / "nav_1").mkdir()
    (tmp_path / "nav_1/costmap.inflate-8.py311.nbi").touch()
    assert not kernel_folder.is_empty()


def test_kernels_of_an_installation_in_use_are_found(monkeypatch):
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    import nav.costmap  # noqa: F401  compiles them where they are not

    assert not kernel_folder.is_empty()
