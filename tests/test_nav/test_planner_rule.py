"""The planner against a plain transcription of its rule, path for path.

Many paths cost the same, and which of them the robot takes decides the rest of its run. So the
order in which the search breaks ties is part of the rule: cells leave a binary heap in the order
that its swaps bring about, and of two ways that cost the same the first found stays.
"""

import math

import numpy as np
import pytest

from nav.astar import plan
from tests.test_nav.test_astar import STEP, costmap_of


def to_go(shape, terminal, step):
    """Cost of the cheapest way to a goal from every cell, had every cell the least cost."""
    field = {cell: terminal.get(cell, math.inf) for cell in np.ndindex(shape)}

    def lower(cells, straight, slanted):
        for r, c in cells:
            for down, right in straight + slanted:
                length = step * math.sqrt(2.0) if down and right else step
                before = field.get((r + down, c + right), math.inf) + length
                field[r, c] = min(field[r, c], before)

    cells = list(np.ndindex(shape))
    lower(cells, [(-1, 0), (0, -1)], [(-1, -1), (-1, 1)])
    lower(cells[::-1], [(1, 0), (0, 1)], [(1, -1), (1, 1)])
    return field


def push(heap, key, cell):
    heap.append((key, cell))
    at = len(heap) - 1
    while at > 0 and heap[(at - 1) // 2][0] > key:
        heap[at], at = heap[(at - 1) // 2], (at - 1) // 2
    heap[at] = (key, cell)


def pop(heap):
    """Take the top; the last entry sinks from there, below equal children never."""
    top, last = heap[0], heap.pop()
    at, size = 0, len(heap)
    while size and 2 * at + 1 < size:
        below = 2 * at + 1
        if below + 1 < size and heap[below + 1][0] < heap[below][0]:
            below += 1
        if heap[below][0] >= last[0]:
            break
        heap[at], at = heap[below], below
    if size:
        heap[at] = last
    return top


def path_by_rule(cost, start, goals, goal_costs):
    """Cells of the path and the index of its goal; None without one."""
    terminal, goal_of = {}, {}
    for i, (cell, goal_cost) in enumerate(zip(map(tuple, goals), goal_costs, strict=True)):
        inside = 0 <= cell[0] < cost.shape[0] and 0 <= cell[1] < cost.shape[1]
        if inside and np.isfinite(cost[cell]) and goal_cost <= terminal.get(cell, math.inf):
            terminal[cell], goal_of[cell] = float(goal_cost), i
    if not terminal:
        return None
    ahead = to_go(cost.shape, terminal, float(cost.min()) * STEP)
    costs = {cell: float(cost[cell]) for cell in np.ndindex(cost.shape) if cost[cell] < math.inf}
    reached, parent, heap = {start: 0.0}, {}, [(ahead[start], start)]
    total, goal = math.inf, None
    while heap and heap[0][0] < total:
        key, cell = pop(heap)
        here = reached[cell]
        if key > here + ahead[cell]:
            continue
        if here + terminal.get(cell, math.inf) < total:
            total, goal = here + terminal[cell], cell
        for down in (-1, 0, 1):
            for right in (-1, 0, 1):
                beside = [(cell[0] + down, cell[1]), (cell[0], cell[1] + right)]
                there = (cell[0] + down, cell[1] + right)
                if there == cell or there not in costs:
                    continue
                if down and right and not all(each in costs for each in beside):
                    continue
                length = STEP * math.sqrt(2.0) if down and right else STEP
                along = here + length * 0.5 * (costs[cell] + costs[there])
                if along < reached.get(there, math.inf):
                    reached[there], parent[there] = along, cell
                    push(heap, along + ahead[there], there)
    if goal is None:
        return None
    cells = [goal]
    while cells[-1] != start:
        cells.append(parent[cells[-1]])
    return np.array(cells[::-1]), goal_of[goal], total


def same_as_by_rule(cost, start, goals, goal_costs):
    """Whether there is a path; checks that it is the one of the rule, to the last bit."""
    costmap = costmap_of(cost)
    expected = path_by_rule(costmap.cost, start, goals, goal_costs)
    path = plan(costmap, costmap.grid.to_xy(np.array(start)), costmap.grid.to_xy(goals), goal_costs)
    if expected is None:
        assert path is None
        return False
    cells, goal, total = expected
    assert path is not None
    np.testing.assert_array_equal(costmap.grid.to_cells(path.xy), cells)
    assert (path.goal, path.cost) == (goal, total)
    return True


def floor_plan(rng, shape, kind):
    """Costs of open floor, of rooms with doors, of clutter, or of noise."""
    cost = np.full(shape, 1.0, np.float32)
    if kind == "rooms":
        for wall in range(9, shape[0] - 1, 10):
            cost[wall] = np.inf
            cost[wall, rng.integers(0, shape[1], 2)] = 1.0
        for wall in range(11, shape[1] - 1, 12):
            cost[:, wall] = np.inf
            cost[rng.integers(0, shape[0], 3), wall] = 1.0
    elif kind == "clutter":
        cost[rng.random(shape) < 0.3] = np.inf
        cost[rng.random(shape) < 0.2] = 1.5
    elif kind == "noise":
        cost = (1 + rng.exponential(2.0, shape)).astype(np.float32)
    cost[: rng.integers(0, shape[0]), : rng.integers(0, shape[1])] *= 1.5
    return cost


@pytest.mark.parametrize("kind", ["open", "rooms", "clutter", "noise"])
def test_every_path_is_that_of_the_rule(kind):
    rng, found = np.random.default_rng(sum(map(ord, kind))), 0
    for _ in range(60):
        shape = tuple(rng.integers(3, 60, 2))
        cost = floor_plan(rng, shape, kind)
        start = tuple(int(i) for i in rng.integers(0, shape))
        cost[start] = 1.0
        goals = rng.integers(-2, np.array(shape) + 2, (int(rng.choice([1, 2, 8, 60])), 2))
        goal_costs = rng.choice([0.0, 0.05, 3.0, 9.0]) * rng.random(len(goals))
        found += same_as_by_rule(cost, start, goals, goal_costs)
    assert found > 20


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["open", "rooms"])
def test_a_goal_near_by_on_a_large_map_is_no_exception(kind):
    rng, found = np.random.default_rng(len(kind)), 0
    for _ in range(6):
        cost = floor_plan(rng, (150, 190), kind)
        start = tuple(int(i) for i in rng.integers(40, (110, 150)))
        cost[start] = 1.0
        near = np.array(start) + rng.integers(-12, 13, (3, 2))
        far = rng.integers(0, cost.shape, (10, 2))
        goals = np.concatenate([near, far]) if rng.random() < 0.5 else near
        found += same_as_by_rule(cost, start, goals, rng.random(len(goals)))
    assert found > 3


def test_goals_that_share_a_cell_are_told_apart_by_their_costs():
    cost = np.ones((12, 12), np.float32)
    goals = np.array([[9, 9], [9, 9], [9, 9], [2, 9]])
    assert same_as_by_rule(cost, (2, 2), goals, np.array([0.3, 0.1, 0.1, 5.0]))


def test_a_goal_that_costs_more_is_taken_where_the_cheap_one_is_far_by_the_way():
    cost = np.ones((70, 90), np.float32)
    cost[5:65, 40] = np.inf
    cost[5, 20:41] = cost[64, 20:41] = np.inf
    goals = np.array([[35, 41], [20, 30], [3, 3], [50, 36]])
    for goal_costs in ([0.0, 2.5, 9.0, 9.0], [0.0, 9.0, 2.7, 9.0], [0.0, 9.0, 9.0, 9.0]):
        assert same_as_by_rule(cost, (35, 39), goals, np.array(goal_costs))
