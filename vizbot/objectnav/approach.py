"""The way to elements of the CLIP map, as near to one of them as there is room."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from nav.config import NavigatorConfig, Reach
from nav.costmap import Costmap
from nav.navigator import GoalPoints, Navigation, navigate
from vizbot.core.types import SE3, OccupancyGrid
from vizbot.perception.sightings import Sightings


@dataclass(frozen=True, slots=True, eq=False)
class NavigationState:
    """What every way is planned on (M^Depth and P in the paper's Algorithm 1).

    Attributes:
        grid: The obstacle map.
        costmap: That of `grid`, with a frame, as of `nav.costmap.LiveCostmap`.
        T_map_base: Where the robot is.
        previous: The navigation of the previous step; None at first and after a stop.
    """

    grid: OccupancyGrid
    costmap: Costmap
    T_map_base: SE3
    previous: Navigation | None


def approach(
    sightings: Sightings,
    reaches: Sequence[Reach],
    similarity_worth: float,
    state: NavigationState,
    navigator: NavigatorConfig,
) -> Navigation | None:
    """Navigate to one of several elements; None when none of them can be reached.

    The robot goes to the side of an element from which the camera saw it, or to any side if the map
    shows nothing free in front of any element.

    Args:
        sightings: The elements to choose from.
        reaches: How near the robot goes, the best first.
        similarity_worth: Length of way that one more unit of similarity makes up for [m].
        state: The obstacle map and the robot on it.
        navigator: How the robot drives.
    """
    if len(sightings.points) == 0:
        return None
    costs = similarity_worth * (sightings.similarities.max() - sightings.similarities)
    heights = sightings.points[:, 2]
    attempts = [(reach, sightings.seen_from) for reach in reaches] + [(reaches[-1], None)]
    for reach, seen_from in attempts:
        level = (heights >= reach.least_height) & (heights <= reach.most_height)
        if not level.any():
            continue
        goals = GoalPoints(
            sightings.points[level, :2],
            costs[level],
            None if seen_from is None else seen_from[level],
        )
        navigation = navigate(
            state.costmap, goals, state.T_map_base, reach, navigator, state.previous
        )
        if navigation is not None:
            return navigation
    return None
