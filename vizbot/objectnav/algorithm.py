"""The paper's Algorithm 1: where to go for what is asked, given the maps of this moment."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from mapping.clip.retrieval import find
from nav.navigator import Navigation, NavigatorConfig, Reach, navigate
from vizbot.config import ObjectNavConfig
from vizbot.core.types import SE3, OccupancyGrid


@dataclass(frozen=True, slots=True, eq=False)
class Action:
    """What Algorithm 1 returns as a_t.

    Attributes:
        navigation: The way to go and the twist to begin it.
        exploring: Whether it leads into what is unknown rather than to something found.
        threshold: Theta after lowering.
    """

    navigation: Navigation
    exploring: bool
    threshold: float


def objectnav(
    points: NDArray[np.float64],
    seen_from: NDArray[np.float64],
    similarities: NDArray[np.float32],
    threshold: float,
    floor: float,
    grid: OccupancyGrid,
    T_map_base: SE3,
    config: ObjectNavConfig,
    navigator: NavigatorConfig,
    previous: Navigation | None,
    explore: Callable[[], Navigation | None],
    hurried: bool = False,
) -> Action | None:
    """One decision of Algorithm 1 (paper, section III-C), after the maps were updated.

    Theta starts at `threshold` in every step, the algorithm's input; what is lowered in a closed
    space does not outlive the step, so a better view later counts again.

    Args:
        points: (N, 3) elements of the CLIP map in `map` [m].
        seen_from: (N, 2) where the camera saw them from, in `map` [m].
        similarities: (N,) of the elements to the goal.
        threshold: Theta.
        floor: It is not lowered below this.
        grid: The obstacle map.
        T_map_base: Where the robot is.
        config: Step of the lowering.
        navigator: How the robot drives.
        previous: The navigation of the step before; None after a stop.
        explore: The way into what is unknown; None when nothing is left to explore.
        hurried: Lower theta before exploring, not after.

    Returns:
        The action, or None when nothing is left to explore and nothing reachable is above the
        floor: it is not found.
    """

    def navigate_to(found: NDArray[np.int64]) -> Navigation | None:
        return approach(
            points[found],
            seen_from[found],
            similarities[found],
            grid,
            T_map_base,
            config.reaches,
            config.similarity_worth,
            navigator,
            previous,
        )

    def lowered() -> Action | None:
        """To the first that can be reached when theta sinks step by step."""
        steps = int((threshold - floor) / config.threshold_step) + 1
        thetas = [threshold - step * config.threshold_step for step in range(steps)]
        # Whatever can be reached can still be reached when theta is lower.
        first = bisect_left(thetas, True, key=lambda theta: at(theta) is not None)
        return at(thetas[first]) if first < len(thetas) else None

    @cache
    def at(theta: float) -> Action | None:
        navigation = navigate_to(find(similarities, theta))
        return None if navigation is None else Action(navigation, False, theta)

    found = at(threshold)
    if found is None and hurried:
        found = lowered()
    if found is not None:
        return found
    navigation = explore()
    if navigation is not None:
        return Action(navigation, True, threshold)
    return None if hurried else lowered()


def approach(
    points: NDArray[np.float64],
    seen_from: NDArray[np.float64],
    similarities: NDArray[np.float32],
    grid: OccupancyGrid,
    T_map_base: SE3,
    reaches: Sequence[Reach],
    worth: float,
    navigator: NavigatorConfig,
    previous: Navigation | None,
) -> Navigation | None:
    """The way to one of several elements, as near to it as there is room; None if there is none.

    Args:
        points: (N, 3) of the elements in `map` [m].
        seen_from: (N, 2) where the camera saw them from: they are gone to from that side.
        similarities: (N,) of the elements; what is more similar is worth more way.
        grid: The obstacle map.
        T_map_base: Where the robot is.
        reaches: How near, the best first.
        worth: How much more way something is worth that is more similar by 1 [m].
        navigator: How the robot drives.
        previous: The navigation of the step before; None after a stop.
    """
    if len(points) == 0:
        return None
    costs = worth * (similarities.max() - similarities)
    # What nothing free was seen before is gone to from wherever there is room.
    tries = [(reach, seen_from) for reach in reaches] + [(reaches[-1], None)]
    for reach, cameras in tries:
        heights = points[:, 2]
        level = (heights >= reach.least_height) & (heights <= reach.most_height)
        if not level.any():
            continue
        navigation = navigate(
            grid,
            points[level, :2],
            T_map_base,
            reach,
            navigator,
            previous,
            costs[level],
            None if cameras is None else cameras[level],
        )
        if navigation is not None:
            return navigation
    return None
