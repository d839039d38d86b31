"""What obstacles around say of a lost robot's place, the comparison with the map being given."""

import pytest

from mapping.occupancy.config import DepthMapperConfig
from mapping.relocalisation import local_map
from mapping.relocalisation.config import LocalMapConfig
from mapping.relocalisation.local_map import LocalMap
from mapping.relocalisation.scan_matching import ScanMatch
from tests.helpers.box_room import T_BASE_CAM, render
from vizbot.core.geometry import planar

HERE, THERE = planar(1.0, 0.5, 0.3), planar(-2.0, 0.5, 0.3)


def believed(monkeypatch, found):
    """Whether the best place stands alone after each of so many turns."""
    matches = iter(ScanMatch(T, share, THERE, rival) for T, share, rival in found)
    monkeypatch.setattr(local_map, "match_scan", lambda *_: next(matches))
    around = LocalMap(lambda: None, DepthMapperConfig(), LocalMapConfig())
    alone = []
    for i in range(len(found) + 1):
        T_odom_base = planar(0.0, 0.0, 1.1 * i)
        around.add(render(T_odom_base, 0.2 * i), T_odom_base, T_BASE_CAM)
        places, stands_alone = around.candidate_poses()
        assert i > 0 or not places
        alone.append(stands_alone)
    return alone[1:]


@pytest.mark.parametrize(
    ("found", "expected"),
    [
        ([(HERE, 0.9, 0.6)], [True]),
        ([(HERE, 0.9, 0.75)] * 4, [False, False, True, True]),
        ([(HERE, 0.9, 0.8)] * 4, [False] * 4),
        ([(HERE, 0.9, 0.75)] * 2 + [(THERE, 0.9, 0.75)] + [(HERE, 0.9, 0.75)] * 2, [False] * 5),
        ([(HERE, 0.9, 0.75)] * 2 + [(HERE, 0.6, 0.5)] + [(HERE, 0.9, 0.75)] * 2, [False] * 5),
    ],
    ids=["far better", "again and again", "hardly better", "elsewhere between", "unfit between"],
)
def test_a_place_stands_alone_if_it_is_far_better_or_the_best_again_and_again(
    monkeypatch, found, expected
):
    assert believed(monkeypatch, found) == expected
