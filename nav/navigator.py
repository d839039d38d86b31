"""Navigation of the paper's Algorithm 1: a costmap, a pose and goals in, an action out.

Both functions are pure. `previous`, the result of the tick before, keeps the robot on its path when
another path is only a little cheaper.

Every tick plans afresh. That takes 0.3 ms of the 70 ms of a rehearsed tick, and an old plan would
save none of them: in 163 plans that followed another one, the costs of the map had stayed the same
8 times, the goals with their costs never.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nav.astar import exits, plan
from nav.config import NavigatorConfig, Reach
from nav.costmap import Costmap
from nav.follower import bearing, face, follow_path, pursued_point
from nav.goal_region import NO_GOAL, fronts, goal_region, reached_goal
from vizbot.core.types import SE3, STOP, Twist


@dataclass(frozen=True, slots=True, eq=False)
class GoalPoints:
    """Goals to navigate to, of which one is enough.

    Attributes:
        xy: (N, 2) points on or in objects, in `map` [m].
        costs: (N,) 0 or more, added to the cost of the path to each goal; None adds nothing.
        seen_from: (N, 2) positions of the camera when it saw the goals, in `map` [m]; None lets a
            goal be reached from any side.
        least: (N,) the robot stops no nearer to each goal than this [m]; None for 0.
    """

    xy: NDArray[np.float64]
    costs: NDArray[np.float64] | None = None
    seen_from: NDArray[np.float64] | None = None
    least: NDArray[np.float64] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Navigation:
    """An action, and the path that it is part of.

    Attributes:
        twist: The twist to drive now; STOP when arrived.
        path: (P, 2) float64 the path ahead in `map` [m]; when exploring, to the end of the map.
        goal: Index of the goal that the path leads to; None when exploring.
        goal_xy: (2,) that goal, or the distant point, in `map` [m].
        distance: Length of the path ahead [m].
        arrived: Whether the goal is within reach, in front of the robot, and the robot stops.
    """

    twist: Twist
    path: NDArray[np.float64]
    goal: int | None
    goal_xy: NDArray[np.float64]
    distance: float
    arrived: bool


def navigate(
    costmap: Costmap,
    goals: GoalPoints,
    T_map_base: SE3,
    reach: Reach,
    config: NavigatorConfig,
    previous: Navigation | None = None,
) -> Navigation | None:
    """Act towards whichever goal is cheapest to reach; None when none can be reached.

    `costmap` has a frame, as of `LiveCostmap`; `previous` is the result of the tick before, None at
    first and after a stop.
    """
    goals_xy = np.asarray(goals.xy, np.float64).reshape(-1, 2)
    goal_costs, seen_from, least = goals.costs, goals.seen_from, goals.least
    position = T_map_base[:2, 3]
    extent, fronts_xy, indices = reach.extent, None, np.arange(len(goals_xy))
    if seen_from is not None:
        fronts_xy, seen = fronts(costmap, goals_xy, seen_from, extent)
        extent, indices = costmap.grid.resolution, np.flatnonzero(seen)
        goals_xy, fronts_xy = goals_xy[seen], fronts_xy[seen]
        goal_costs = None if goal_costs is None else goal_costs[seen]
        least = None if least is None else least[seen]
    margin = config.reach_margin
    inner = None if least is None else np.where(least > 0.0, least + margin, 0.0)
    region = goal_region(costmap, goals_xy, reach.distance - margin, extent, fronts_xy, inner)
    goal = reached_goal(costmap, goals_xy, position, reach.distance, extent, fronts_xy, least)
    if goal is None:
        # At the end of a path, a robot beside the centre of its cell may just not see the goal.
        here = region.goal_from(costmap.grid.to_cells(position))
        goal = None if here == NO_GOAL else here
    if goal is not None:
        goal_xy = goals_xy[goal]
        arrived = abs(bearing(T_map_base, goal_xy)) <= config.facing_tolerance
        twist = STOP if arrived else face(goal_xy, T_map_base, config.follower)
        index = int(indices[goal])
        return Navigation(twist, position[None].copy(), index, goal_xy, 0.0, arrived)
    stops, reached = region.stops()
    stop_costs = np.zeros(len(stops)) if goal_costs is None else goal_costs[reached]
    path_xy = _chosen_path(
        costmap, position, costmap.grid.to_xy(stops), stop_costs, config, previous
    )
    if path_xy is None:
        return None
    goal = region.goal_from(costmap.grid.to_cells(path_xy[-1]))
    return _along(costmap, path_xy, int(indices[goal]), goals_xy[goal], T_map_base, config)


def explore_distant(
    costmap: Costmap,
    T_map_base: SE3,
    config: NavigatorConfig,
    previous: Navigation | None = None,
) -> Navigation | None:
    """Act towards the distant point (the paper's g_distant), and so into unknown space.

    `costmap` and `previous` are as for `navigate`.

    Returns:
        None when the space around the robot is closed: nothing is left to explore.
    """
    distant_xy = np.array(config.distant_point)
    position = T_map_base[:2, 3]
    exits_xy, exit_costs = exits(costmap, distant_xy)
    path_xy = _chosen_path(costmap, position, exits_xy, exit_costs, config, previous)
    if path_xy is None:
        return None
    return _along(costmap, path_xy, None, distant_xy, T_map_base, config)


def _chosen_path(
    costmap: Costmap,
    position: NDArray[np.float64],
    ends_xy: NDArray[np.float64],
    end_costs: NDArray[np.float64],
    config: NavigatorConfig,
    previous: Navigation | None,
) -> NDArray[np.float64] | None:
    """The cheapest path to one of the ends, or the rest of the last path if almost as cheap.

    Otherwise two paths around a table that cost the same alternate, and the robot stands still.
    """
    path = plan(costmap, position, ends_xy, end_costs)
    if path is None or previous is None:
        return None if path is None else path.xy
    away = np.linalg.norm(previous.path - position, axis=1)
    kept = previous.path[int(np.argmin(away)) :]
    cells = costmap.grid.to_cells(kept)
    from_end = np.linalg.norm(ends_xy - kept[-1], axis=1)
    if (
        not costmap.grid.contains(cells).all()
        or away.min() > config.keep_path_within
        or from_end.min() > 0.5 * costmap.grid.resolution
    ):
        return path.xy
    # A blocked cell costs inf, and so does a path through it.
    cost = costmap.cost[tuple(cells.T)].astype(np.float64)
    lengths = np.linalg.norm(np.diff(kept, axis=0), axis=1)
    kept_cost = 0.5 * lengths @ (cost[1:] + cost[:-1]) + end_costs[np.argmin(from_end)]
    return kept if kept_cost < path.cost + config.keep_path_saving else path.xy


def _along(
    costmap: Costmap,
    path_xy: NDArray[np.float64],
    goal: int | None,
    goal_xy: NDArray[np.float64],
    T_map_base: SE3,
    config: NavigatorConfig,
) -> Navigation:
    position = T_map_base[:2, 3]
    gap = costmap.room(costmap.grid.to_cells(position)) - config.costmap.robot_radius
    twist = follow_path(path_xy, T_map_base, config.follower, gap)
    _, distance = pursued_point(path_xy, position, 0.0)
    return Navigation(twist, path_xy, goal, goal_xy, distance, arrived=False)
