"""The paper's Algorithm 1: where to go for what is asked, given the maps of this moment."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mapping.retrieval import find
from nav.navigator import Navigation, NavigatorConfig, navigate
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
    similarities: NDArray[np.float32],
    threshold: float,
    grid: OccupancyGrid,
    T_map_base: SE3,
    config: ObjectNavConfig,
    navigator: NavigatorConfig,
    previous: Navigation | None,
    explore: Callable[[], Navigation | None],
) -> Action | None:
    """One decision of Algorithm 1 (paper, section III-C), after the maps were updated.

    Theta starts at `threshold` in every step, as the algorithm's input; what is lowered in a closed
    space does not outlive the step, so a better view later counts again.

    Args:
        points: (N, 3) elements of the CLIP map in `map` [m].
        similarities: (N,) of the elements to the goal.
        threshold: Theta.
        grid: The obstacle map.
        T_map_base: Where the robot is.
        config: Step and floor of the lowering.
        navigator: How the robot drives.
        previous: The navigation of the step before; None after a stop.
        explore: The way into what is unknown; None when nothing is left to explore.

    Returns:
        The action, or None when nothing is left to explore and nothing reachable is above the
        floor: it is not found.
    """

    def navigate_to(found: NDArray[np.int64]) -> Navigation | None:
        if len(found) == 0:
            return None
        return navigate(grid, points[found, :2], T_map_base, navigator, previous)

    found = find(similarities, threshold)
    navigation = navigate_to(found)
    if navigation is not None:
        return Action(navigation, False, threshold)
    navigation = explore()
    if navigation is not None:
        return Action(navigation, True, threshold)
    floor = threshold * config.threshold_floor
    while threshold - config.threshold_step >= floor:
        threshold -= config.threshold_step
        wider = find(similarities, threshold)
        if len(wider) == len(found):
            continue  # the same goals on the same map give the same answer
        found = wider
        navigation = navigate_to(found)
        if navigation is not None:
            return Action(navigation, False, threshold)
    return None
