"""What the search expects behind frontiers."""

import numpy as np
import pytest

from mapping.clip.places.belief import PlaceBelief
from mapping.clip.places.footprint import PLACE
from nav.costmap import LiveCostmap
from nav.frontier import FrontierSearch
from nav.way_field import WayField
from vizbot.config import Config
from vizbot.core.geometry import planar
from vizbot.core.types import OccupancyGrid
from vizbot.objectnav.place_options import FrontierOptions

CONFIG = Config()
SEEN = 3.0
"""So much of the west end of the floor was looked at [m]."""


def behind(length, width, likeness=0.0):
    """The one option in a closed hall of this size [m], from its west end."""
    rows, columns = round(width / 0.05), round(length / 0.05)
    occupancy = np.pad(np.zeros((rows, columns), np.float32), 5, constant_values=1.0)
    grid = OccupancyGrid(occupancy, 0.05, np.array([-0.25, -0.25]))
    frontiers = FrontierSearch(CONFIG.frontier)
    frontiers.explored.mask_on(grid)[:, : 5 + round(SEEN / 0.05)] = True
    costmap = LiveCostmap(CONFIG.navigator.costmap).update(grid)
    ways = WayField()
    ways.update(costmap, np.array([1.0, width / 2]))
    plan = round(width / PLACE), round(length / PLACE)
    values = np.zeros(plan, np.float32)
    values[:, round(SEEN / PLACE) - 2 :] = likeness
    belief = PlaceBelief(
        np.zeros(2, np.int64), np.zeros(plan), values, np.ones(plan, bool), np.zeros((*plan, 2)),
        values,
    )  # fmt: skip
    here = planar(1.0, width / 2, 0.0)
    [option] = FrontierOptions(CONFIG, frontiers, likeness=True).options(
        belief, costmap, ways, here
    )
    return option


@pytest.mark.parametrize(("length", "seen_within_reach"), [(5.0, 2.0), (7.0, 4.0), (14.0, 5.0)])
def test_the_unseen_floor_behind_counts_up_to_the_reach(length, seen_within_reach):
    assert behind(length, 1.5).area == pytest.approx(1.5 * seen_within_reach, rel=0.1)


def test_no_hall_counts_for_more_than_the_largest_area():
    assert behind(14.0, 8.0).area == pytest.approx(30.0)


def test_a_large_area_is_likelier_to_show_it_and_so_is_one_beside_what_is_like_it():
    small, large, like = behind(5.0, 1.5), behind(14.0, 1.5), behind(5.0, 1.5, likeness=3.0)
    assert small.probability < large.probability
    assert small.probability < like.probability and small.likeness == 0.0
    assert 0.0 < like.likeness <= FrontierOptions.MOST_LIKENESS
