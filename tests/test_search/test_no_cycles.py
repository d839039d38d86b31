"""No two behaviours undo each other, whatever the plan and whatever fails.

All that decides runs as in a robot, the search and the navigator above the behaviours, on drawn
plans: with bare walls, glass, things that depth does not show, contacts, and sensors that freeze.
"""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from tests.test_search.plan_robot import (
    BARE,
    CELL,
    GLASS,
    LOW,
    MATT,
    PlanWorld,
    Trouble,
    plan_config,
    plan_goal,
    robot_on,
)
from vizbot.core.geometry import yaw_of
from vizbot.objectnav.tasks import ShortMove, Task, Waypoint

pytestmark = pytest.mark.slow

STEPS = 10_000
WIDTH = 3.4
TASKS = 4
"""So many are done one after another before the robot wakes up elsewhere, without a map."""
MOST_ROUNDS = 12
"""So often the robot may come to do the same in the same place without anything newly seen."""
LONGEST = 60.0
"""So long it may do the same in the same place without a break [s]."""
DOCKING = 95.0
"""The same where the base itself looks for its dock [s]."""
MOST_STEPS = 2500
"""Of one task."""
FROZEN = ("depth", "lost", "pose", "wheels", "bump", "wall", "edge", "overcurrent", "dock")
AWAITED = ("lift", "passive", "charger")
"""What a robot waits for people with: it lasts for seconds only."""


def drawn_plan(rng):
    """A room of up to four rooms, of all that may stand in one."""
    cells = round(WIDTH / CELL)
    plan = np.zeros((cells, cells), np.uint8)
    for wall in (plan[0], plan[-1], plan[:, 0], plan[:, -1]):
        wall[:] = rng.choice([MATT, BARE])
        begin = rng.integers(0, cells - 8)
        wall[begin : begin + rng.integers(5, cells)] = rng.choice([MATT, BARE])
    for _ in range(rng.integers(0, 3)):
        across, door = rng.integers(10, cells - 10), rng.integers(2, cells - 9)
        wall = plan[across] if rng.random() < 0.5 else plan[:, across]
        kept = wall[door : door + 8].copy()
        wall[1:-1] = rng.choice([MATT, BARE, GLASS], p=[0.5, 0.35, 0.15])
        wall[door : door + 8] = kept
    for _ in range(rng.integers(0, 5)):
        row, col = rng.integers(2, cells - 6, 2)
        plan[row : row + rng.integers(1, 5), col : col + rng.integers(1, 5)] = rng.choice(
            [MATT, BARE, GLASS, LOW]
        )
    return plan


def drawn_troubles(rng, frames):
    for _ in range(rng.integers(0, 4)):
        what = str(rng.choice([*FROZEN, *AWAITED]))
        lasts = int(rng.choice([10, 60] if what in AWAITED else [10, 60, 400]))
        yield Trouble(what, int(rng.integers(frames)), lasts)


def drawn_world(rng, frames):
    """A plan with a robot in it that stands free, and what goes wrong within some frames."""
    while True:
        world = PlanWorld(drawn_plan(rng), tuple(drawn_troubles(rng, frames)))
        free = [xy for xy in rng.uniform(0.3, WIDTH - 0.3, (50, 2)) if world.is_free(*xy)]
        if free:
            world.start_at(*free[0], rng.uniform(-np.pi, np.pi))
            return world


def drawn_task(rng):
    kind = rng.choice(["goal", "goal", "goal", "explore", "waypoint", "move", "other"])
    if kind == "goal":
        return plan_goal(f"thing {rng.integers(3)}")
    if kind == "explore":
        return Task.EXPLORE
    if kind == "move":
        turn, forward = float(rng.uniform(-6.0, 6.0)), float(rng.uniform(0.1, 3.0))
        return ShortMove(turn=turn) if rng.random() < 0.5 else ShortMove(forward=forward)
    if kind == "other":
        return Task(str(rng.choice([Task.COME_BACK.value, Task.DOCK.value, Task.FIND_PLACE.value])))
    return Waypoint(*rng.uniform(-WIDTH / 2, WIDTH / 2, 2).tolist())


def doing(step):
    """What the robot does, and where."""
    x, y = np.floor(step.T_map_base[:2, 3] / 0.2).astype(int).tolist()
    facing = int(yaw_of(step.T_map_base) // (np.pi / 4))
    end = None if step.path is None else tuple(np.floor(step.path[-1] / 0.4).astype(int).tolist())
    return step.activity, x, y, facing, end


class Judge:
    """Looks for a cycle in the steps of one task."""

    def __init__(self, task):
        self.task, self.steps, self.seen = task, 0, 0.0
        self.latest, self.since, self.rounds = None, 0.0, Counter()

    def look(self, step, seen, now):
        self.steps += 1
        did = doing(step)
        if seen > self.seen + 0.1:
            self.seen, self.rounds = seen, Counter()
        if did != self.latest:
            self.latest, self.since = did, now
            self.rounds[did] += 1
        told = step.index, did
        assert self.rounds[did] <= MOST_ROUNDS, ("goes round in a circle", told, self.task)
        longest = DOCKING if step.activity == "docking" else LONGEST
        assert now - self.since <= longest, ("does the same for ever", told, self.task)
        assert self.steps <= MOST_STEPS, ("finds no end", told, self.task)


def drive(seed, steps=STEPS):
    """Do one task after another in one plan after another, and look for cycles."""
    rng, done = np.random.default_rng(seed), 0
    while done < steps:
        world = drawn_world(rng, frames=600)
        places = [(*rng.uniform(-2.0, 2.0, 2), rng.uniform(0.0, 1.0)) for _ in range(3)]
        method = str(rng.choice(["belief", "belief", "belief", "paper"]))
        robot = robot_on(world, places, plan_config(method))
        for _ in range(TASKS):
            task = drawn_task(rng)
            judge, ended = Judge(task), None
            while ended is None and done < steps:
                step = robot.tick(task)
                explored = robot.map.exploration.frontiers.explored.mask_on(step.grid)
                seen = np.count_nonzero(explored) * CELL**2
                judge.look(step, seen, world.clock.now())
                done, ended = done + 1, step.ended or step.question  # whom nobody answers


@pytest.mark.sampled("0", "1")
@pytest.mark.parametrize("seed", range(5))
def test_no_behaviours_go_round_in_a_circle(seed):
    drive(seed)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(5, 205))
def test_no_behaviours_go_round_in_a_circle_in_many_plans(seed):
    drive(seed)


def dropped_where_nothing_fails(seed, steps):
    """How many goals and explorations the guard ends in plans in which nothing goes wrong."""
    rng, done, dropped = np.random.default_rng(seed), 0, 0
    while done < steps:
        world = replace(drawn_world(rng, frames=600), troubles=())
        world.start_at(*world.T_world_base[:2, 3], yaw_of(world.T_world_base))
        places = [(*rng.uniform(-2.0, 2.0, 2), rng.uniform(0.0, 1.0)) for _ in range(3)]
        robot = robot_on(world, places)
        for _ in range(TASKS):
            task = plan_goal(f"thing {rng.integers(3)}") if rng.random() < 0.5 else Task.EXPLORE
            ended = None
            while ended is None and done < steps:
                step = robot.tick(task)
                done, ended = done + 1, step.ended
            dropped += step.activity == "stopped, nothing comes of it"
    return dropped


def test_behaviours_do_not_leave_to_the_guard_what_they_can_end_themselves():
    assert dropped_where_nothing_fails(seed=6, steps=2500) <= 1


@pytest.mark.long
def test_behaviours_leave_little_to_the_guard_in_many_plans():
    assert sum(dropped_where_nothing_fails(seed, steps=2500) for seed in range(10, 30)) <= 8
