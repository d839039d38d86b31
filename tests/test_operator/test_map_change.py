"""Whether another map has begun is told from the steps of a run."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.scripted_robot import ScriptedBase
from tests.helpers.two_maps import EMPTY, KEPT, OLD, POINTS, mapped
from vizbot.core.geometry import planar
from vizbot.objectnav.tasks import Task
from vizbot.operator.report.events import MapChange


def noticed(steps):
    change = MapChange()
    return [step.index for step in steps if change.begins_with(step)]


def test_a_map_that_grows_and_is_corrected_is_the_same():
    T = planar(0.2, -0.1, 0.4)
    moved = POINTS[:4] @ T[:3, :3].T + T[:3, 3]
    assert not noticed([*OLD, replace(OLD[-1], points=moved), mapped(4, 11, [0, 4, 9, 11],
        [0, 0, 4, 9, 10, 11], np.vstack([moved, POINTS[:2]]))])  # fmt: skip


@pytest.mark.parametrize(
    "other",
    [
        EMPTY,
        KEPT,
        mapped(3, 40, [0, 4, 9], [0, 0, 4], POINTS[:3]),
        mapped(3, 40, [0, 4, 9], [0, 0, 4, 8], POINTS[:4]),
        mapped(3, 40, [0, 4], [0, 0, 4, 9], POINTS[:4]),
        mapped(3, 40, [0, 4, 9, 12], [0, 0, 4, 9], POINTS[4:8]),
        mapped(3, 2, [0, 4, 9, 12], [0, 0, 4, 9], POINTS[:4]),
    ],
    ids=["empty", "kept", "fewer", "other frames", "keyframe gone", "other places", "recounted"],
)
def test_another_map_is_noticed_once(other):
    assert noticed([*OLD, other, replace(other, index=4)]) == [3]


def test_a_kept_map_is_noticed_by_how_much_there_is_at_once():
    waiting = [mapped(0, 0, [0], []), mapped(1, 1, [0], [])]
    assert noticed([*waiting, KEPT]) == [3]


def ticked(pipeline, change, count, task=Task.EXPLORE):
    """For each of so many ticks whether another map was seen to begin."""
    return [change.begins_with(pipeline.tick(task)) for _ in range(count)]


def test_steps_of_a_robot_tell_when_it_leaves_its_map(pipeline_on):
    pipeline, change = pipeline_on(ScriptedBase()), MapChange()
    assert not any(ticked(pipeline, change, 30))
    kept = pipeline.bundle()
    assert not any(ticked(pipeline, change, 10))
    for other in (None, kept, None):
        pipeline.begin_map(other)
        assert ticked(pipeline, change, 10) == [True] + [False] * 9


def test_a_robot_that_waits_in_an_empty_map_is_seen_to_leave_it_for_a_kept_one(pipeline_on):
    first = pipeline_on(ScriptedBase())
    for _ in range(30):
        first.tick(Task.EXPLORE)
    pipeline, change = pipeline_on(ScriptedBase()), MapChange()
    assert not any(ticked(pipeline, change, 5, Task.MAP))
    pipeline.begin_map(first.bundle())
    assert ticked(pipeline, change, 5, Task.MAP) == [True] + [False] * 4
