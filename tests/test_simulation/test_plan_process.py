"""A world that another process plans is the one that this process would plan."""

import os
import sys
from pathlib import Path

import numpy as np
import pytest

from sim_stubs.world.body import WorldConfig
from sim_stubs.world.world_name import plan_world, shape_of
from tests.test_homes.test_home_digests import digest_of
from vizbot.commands.run_plan import DeviceChoice, DryRunPlan, RunPlan, world_beside
from vizbot.config import Config
from vizbot.core.geometry import planar
from vizbot.rehearsal.choice import choose
from vizbot.rehearsal.plan_process import PlanProcess

OUTLINE = WorldConfig().outline(height=0.6, forward=0.05)


@pytest.mark.slow
def test_it_is_the_same_world():
    with PlanProcess("3", OUTLINE, "sofa") as process:
        planned = process.plan()
        shape = process.shape(planned)
    own = plan_world("3", "sofa")
    assert digest_of(planned.house) == digest_of(own.house)
    assert (planned.house.start, planned.seed, planned.notice) == (
        own.house.start, own.seed, own.notice
    )  # fmt: skip
    own_shape, T_world_cam = shape_of(own, OUTLINE), planar(*own.house.start)
    assert np.array_equal(shape.touch.free()[0], own_shape.touch.free()[0])
    assert np.array_equal(
        shape.visibility.seen(T_world_cam), own_shape.visibility.seen(T_world_cam)
    )


def test_where_the_process_fails_the_world_is_planned_here(monkeypatch):
    monkeypatch.setattr(sys, "executable", "/bin/false")
    monkeypatch.setattr("sim_stubs.world.world_name.plan_world", lambda *asked: asked)
    monkeypatch.setattr("sim_stubs.world.world_name.shape_of", lambda *asked: asked)
    with PlanProcess("7", OUTLINE, "sofa", (1.0, 2.0, 0.5)) as process:
        planned = process.plan()
        assert planned == ("7", "sofa", None, (1.0, 2.0, 0.5))
        assert process.shape(planned) == (planned, OUTLINE)


def test_nothing_is_left_of_a_process_that_nobody_waits_for():
    with PlanProcess("3", OUTLINE) as process:
        pid = process._process.pid
    process.close()
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


@pytest.mark.parametrize(
    ("camera", "world", "is_planned"),
    [("sim", "1100", True), ("sim", "office", False), ("realsense", "1100", False)],
)
def test_only_the_home_of_a_seed_is_planned_beside(camera, world, is_planned, monkeypatch):
    begun = []
    monkeypatch.setattr(PlanProcess, "__init__", lambda self, *asked: begun.append(asked))
    monkeypatch.setattr(PlanProcess, "close", lambda self: None)
    devices = DeviceChoice(camera, "sim", None, choose(camera, "sim", world, "sofa"))
    plan = DryRunPlan(RunPlan(Path(), Config(), None, False), devices, ["sofa"])
    with world_beside(plan) as process:
        assert (process is not None) is is_planned
    assert begun == [("1100", OUTLINE, "sofa", None)] * is_planned
