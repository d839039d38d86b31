"""No two behaviours undo each other, whatever the plan and whatever fails.

All that decides runs as in a robot, the search and the navigator above the behaviours, on drawn
plans: with bare walls, glass, things that depth does not show, contacts, and sensors that freeze.
"""

from collections import Counter

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
    plan_goal,
    robot_on,
)
from vizbot.core.geometry import yaw_of
from vizbot.objectnav.tasks import Task, Waypoint

STEPS = 10_000
WIDTH = 3.4
TASKS = 4
"""So many are done one after another before the robot wakes up elsewhere, without a map."""
MOST_ROUNDS = 12
"""So often the robot may come to do the same in the same place without anything newly seen."""
LONGEST = 60.0
"""So long it may do the same in the same place without a break [s]."""
MOST_STEPS = 2500
"""Of one task."""
FROZEN = ("depth", "lost", "pose", "wheels", "bump", "wall")


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


def drawn_world(rng, frames):
    """A plan with a robot in it that stands free, and what goes wrong within some frames."""
    while True:
        troubles = tuple(
            Trouble(
                str(rng.choice(FROZEN)), int(rng.integers(frames)), int(rng.choice([10, 60, 400]))
            )
            for _ in range(rng.integers(0, 4))
        )
        world = PlanWorld(drawn_plan(rng), troubles)
        free = [xy for xy in rng.uniform(0.3, WIDTH - 0.3, (50, 2)) if world.is_free(*xy)]
        if free:
            world.start_at(*free[0], rng.uniform(-np.pi, np.pi))
            return world


def drawn_task(rng):
    kind = rng.choice(["goal", "goal", "goal", "explore", "waypoint"])
    if kind == "goal":
        return plan_goal(f"thing {rng.integers(3)}")
    if kind == "explore":
        return Task.EXPLORE
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
        assert now - self.since <= LONGEST, ("does the same for ever", told, self.task)
        assert self.steps <= MOST_STEPS, ("finds no end", told, self.task)


def drive(seed, steps=STEPS):
    """Do one task after another in one plan after another, and look for cycles."""
    rng, done = np.random.default_rng(seed), 0
    while done < steps:
        world = drawn_world(rng, frames=600)
        places = [(*rng.uniform(-2.0, 2.0, 2), rng.uniform(0.0, 1.0)) for _ in range(3)]
        robot = robot_on(world, places)
        for _ in range(TASKS):
            task = drawn_task(rng)
            judge, ended = Judge(task), None
            while ended is None and done < steps:
                step = robot.tick(task)
                explored = robot.map.exploration.frontiers.explored.mask_on(step.grid)
                seen = np.count_nonzero(explored) * CELL**2
                judge.look(step, seen, world.clock.now())
                done, ended = done + 1, step.ended


@pytest.mark.parametrize("seed", range(5))
def test_no_behaviours_go_round_in_a_circle(seed):
    drive(seed)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(5, 205))
def test_no_behaviours_go_round_in_a_circle_in_many_plans(seed):
    drive(seed)
