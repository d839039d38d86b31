import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mapping.occupancy import planar_scan
from mapping.occupancy.config import ScanConfig
from mapping.occupancy.planar_scan import DROP, FLOOR, flatten, level_pose
from vizbot.core.geometry import camera_mount
from vizbot.core.types import Intrinsics

LENS = Intrinsics(32, 24, 30.7, 30.7, 15.5, 11.5)


@pytest.fixture
def checked(monkeypatch):
    """The kernel as Python, in which an index out of bounds is an error."""
    monkeypatch.setattr(planar_scan, "_project", planar_scan._project.py_func)


def mounted(height, tilt):
    """T_level_cam of a camera at a height above the floor [m], tilted down [rad]."""
    T_cam = camera_mount(height=height, forward=0.0, tilt=tilt)
    return np.linalg.inv(level_pose(T_cam)) @ T_cam


@pytest.mark.usefixtures("checked")
@pytest.mark.parametrize("height", [-2.0, -0.24, -0.01])
@pytest.mark.parametrize("tilt", [0.1, 0.8])
def test_a_camera_whose_pose_has_sunk_below_the_floor_shows_no_drop(height, tilt):
    scan = flatten(np.full((24, 32), 2.3, np.float32), LENS, mounted(height, tilt), ScanConfig())
    assert not (scan.evidence() == DROP).any()


@pytest.mark.usefixtures("checked")
@given(
    height=st.floats(-2.0, 2.0),
    tilt=st.floats(-1.5, 1.5),
    depth=st.floats(0.0, 70.0, width=32),
    max_range=st.floats(0.5, 20.0),
    drop_range=st.floats(0.0, 20.0),
)
def test_whatever_the_pose_the_depth_and_the_ranges_each_pixel_falls_into_the_scan(
    height, tilt, depth, max_range, drop_range
):
    config = ScanConfig(max_range=max_range, drop_range=drop_range, stride=8)
    evidence = flatten(
        np.full((24, 32), depth, np.float32), LENS, mounted(height, tilt), config
    ).evidence()
    assert evidence.shape[1] == int(np.ceil(max_range / config.range_step))


def test_floor_just_within_the_longest_range_is_in_the_last_cell():
    T_level_cam, config = mounted(1.0, 0.0), ScanConfig(max_range=4.5, stride=2)
    depth = np.zeros((24, 32), np.float32)
    v, u = 21, 15
    depth[v, u] = np.nextafter(np.float32(4.5), np.float32(0)) / np.hypot(1.0, (u - 15.5) / 30.7)
    below = (v - 11.5) / 30.7 * float(depth[v, u])
    T_level_cam[2, 3] = below
    evidence = flatten(depth, LENS, T_level_cam, config).evidence()
    assert [*np.argwhere(evidence == FLOOR)[:, 1]] == [evidence.shape[1] - 1]
