"""Nothing is compiled while a wheel turns."""

import gc
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from numba.core.dispatcher import Dispatcher

from vizbot.config import Config
from vizbot.pipeline import Pipeline
from vizbot.rig import Rig

_PROGRAM = """
import json
from numba.core import event

listener = event.RecordingListener()
event.register("numba:compile", listener)
from tests.conftest import MeanColours
from vizbot.config import Config
from vizbot.pipeline import Pipeline
from vizbot.rig import Rig

config = Config()
with Rig(config, "sim", "sim", "1100") as rig:
    pipeline = Pipeline(rig.devices, MeanColours(), config, [])
    goal, before = pipeline.goal("red"), len(listener.buffer)
    for _ in range(60):
        pipeline.tick(goal)
print(json.dumps([before, len(listener.buffer) - before]))
"""
"""What counts the events of numba's compiler before the first tick and after it."""
OURS = ("nav", "mapping", "vizbot", "drivers")


def signatures():
    """How many signatures each of our kernels has."""
    kernels = [o for o in gc.get_objects() if issubclass(type(o), Dispatcher)]
    return {
        f"{k.py_func.__module__}.{k.py_func.__name__}": len(k.signatures)
        for k in kernels
        if k.py_func.__module__.split(".")[0] in OURS
    }


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
            pipeline.map.scores.similarities_to(goal, pipeline.map.perception.clip_map.embeddings)
        pipeline.look_up(goal)
        assert moved > ticks / 3
        return before, signatures()


def test_a_drive_meets_no_kernel_with_arguments_that_it_was_not_compiled_for(mean_colours):
    before, after = drive(mean_colours)
    assert len(before) > 15
    assert after == before


@pytest.mark.long
def test_from_an_empty_cache_everything_is_compiled_before_the_first_tick(tmp_path):
    program = tmp_path / "program.py"
    program.write_text(_PROGRAM)
    root = Path(__file__).parents[2]
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": str(root)}
    done = subprocess.run(
        [sys.executable, program], env=environment, capture_output=True, text=True, check=True
    )
    before, during = json.loads(done.stdout)
    assert before > 15
    assert during == 0
