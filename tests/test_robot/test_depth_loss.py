"""What the robot makes of depth that shows nothing."""

import numpy as np
import pytest

from vizbot.core.geometry import planar
from vizbot.core.types import ImuSamples, Intrinsics, OccupancyGrid, RGBDFrame
from vizbot.perception.depth_loss import DepthLossMonitor

CAMERA = Intrinsics(32, 24, 30.0, 30.0, 15.5, 11.5)


def frame(depth):
    rgb = np.zeros((24, 32, 3), np.uint8)
    return RGBDFrame(0.0, rgb, np.full((24, 32), depth, np.float32), CAMERA, ImuSamples.none())


def grid(*obstacles):
    occupancy = np.full((40, 40), 0.2, np.float32)
    empty = OccupancyGrid(occupancy, 0.1, np.array([-2.0, -2.0]))
    for row, col in empty.to_cells(np.array(obstacles).reshape(-1, 2)):
        occupancy[row, col] = 0.9
    return lambda: empty


def looked(seconds, *obstacles, yaw=0.0):
    monitor = DepthLossMonitor()
    for now in np.arange(0.0, seconds + 0.01, 0.25):
        monitor.observe(frame(0.0), planar(0.0, 0.0, yaw), grid(*obstacles), now)
    return monitor


def test_without_depth_the_robot_knows_for_how_long(caplog):
    assert looked(1.0).seconds == pytest.approx(1.0)
    assert caplog.text.count("depth shows nothing") == 1


@pytest.mark.parametrize(
    ("depth", "obstacles", "lost_for"), [(2.0, [], None), (0.0, [(0.4, 0.0)], 1.25)]
)
def test_with_depth_it_sees_again_and_not_by_a_wall_that_it_turns_to(
    caplog, depth, obstacles, lost_for
):
    monitor = looked(1.0)
    monitor.observe(frame(depth), planar(0.0, 0.0, 0.0), grid(*obstacles), 1.25)
    assert monitor.seconds == (lost_for and pytest.approx(lost_for))
    assert caplog.text.count("shows something again") == (lost_for is None)


def test_right_before_what_the_map_knows_of_black_is_no_wonder():
    assert looked(1.0, (0.4, 0.0)).seconds is None
    assert looked(1.0, (0.0, 0.4), yaw=np.pi / 2).seconds is None
    for elsewhere in ((1.2, 0.0), (-0.4, 0.0), (0.1, 0.5)):
        assert looked(1.0, elsewhere).seconds == pytest.approx(1.0)


def test_before_a_known_wall_that_fills_the_view_black_is_no_wonder_either():
    wall = [(1.0, y) for y in np.arange(-1.0, 1.0, 0.05)]
    assert looked(1.0, *wall).seconds is None
    for part in (wall[: len(wall) // 2], [(1.5, y) for _, y in wall]):
        assert looked(1.0, *part).seconds == pytest.approx(1.0)
