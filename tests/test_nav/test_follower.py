"""Path following in closed loop on ideal kinematics."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nav.config import FollowerConfig
from nav.follower import bearing, face, follow_path, pursued_point
from vizbot.core.diff_drive import rolled, wheel_speeds
from vizbot.core.geometry import planar, rotation_angle
from vizbot.core.types import Twist

CONFIG = FollowerConfig()
WHEEL_BASE = 0.235


def driven(T_map_base: np.ndarray, twist: Twist, seconds: float) -> np.ndarray:
    left, right = (speed * seconds for speed in wheel_speeds(twist, WHEEL_BASE))
    return T_map_base @ rolled(left, right, WHEEL_BASE)


@given(
    st.lists(st.tuples(st.floats(-3, 3), st.floats(-3, 3)), min_size=1, max_size=6),
    st.floats(-np.pi, np.pi),
    st.floats(0.0, 1.0),
)
def test_twists_stay_within_one_step_of_the_paper(points, yaw, clearance):
    twist = follow_path(np.array(points), planar(0.0, 0.0, yaw), CONFIG, clearance)
    assert 0.0 <= twist.linear <= CONFIG.max_linear
    assert abs(twist.angular) <= CONFIG.max_angular
    moved = driven(np.eye(4), twist, CONFIG.twist_duration)
    assert np.linalg.norm(moved[:3, 3]) <= 0.25
    assert rotation_angle(moved) <= np.radians(30)


@settings(max_examples=20)
@given(st.floats(-np.pi, np.pi), st.floats(1, 2), st.floats(1, 2), st.sampled_from([0.2, 0.25]))
def test_the_robot_comes_to_rest_at_the_end_of_the_path(yaw, x, y, period):
    path = np.array([[0.0, 0.0], [x, 0.0], [x, y], [x - 1.0, y]])
    T = planar(0.0, 0.0, yaw)
    for _ in range(150):
        twist = follow_path(path, T, CONFIG)
        T = driven(T, twist, period)
    assert np.linalg.norm(T[:2, 3] - path[-1]) < 0.02
    assert abs(twist.linear) < 0.01


@pytest.mark.parametrize("period", [0.2, 0.25])
def test_a_straight_path_is_kept_without_swinging(period):
    path = np.column_stack([np.arange(0.0, 5.0, 0.05), np.zeros(100)])
    T = planar(0.0, 0.12, 0.5)
    offsets = []
    for _ in range(60):
        T = driven(T, follow_path(path, T, CONFIG), period)
        offsets.append(T[1, 3])
    assert np.abs(offsets[-20:]).max() < 0.01
    assert np.min(offsets) > -0.05


def test_it_turns_in_place_when_the_path_leads_backwards():
    twist = follow_path(np.array([[0.0, 0.0], [-1.0, 0.1]]), planar(0.0, 0.0, 0.0), CONFIG)
    assert twist.linear == 0.0
    assert twist.angular == CONFIG.max_angular


def test_it_slows_down_beside_an_obstacle():
    path = np.array([[0.0, 0.0], [2.0, 0.0]])
    beside = follow_path(path, planar(0.0, 0.0, 0.0), CONFIG, gap=0.025)
    free = follow_path(path, planar(0.0, 0.0, 0.0), CONFIG)
    assert 0.0 < beside.linear < 0.6 * free.linear


def test_facing_a_point_neither_overshoots_nor_stalls():
    point, T = np.array([-1.0, -0.2]), planar(0.0, 0.0, 0.0)
    errors = []
    for _ in range(40):
        errors.append(bearing(T, point))
        T = driven(T, face(point, T, CONFIG), 0.25)
    assert (np.abs(np.diff(np.sign(errors))) == 0).all()
    assert abs(errors[-1]) < 0.01


def test_the_pursued_point_lies_the_lookahead_further_along_a_bend():
    path = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])
    target, to_go = pursued_point(path, np.array([0.8, 0.1]), 0.5)
    np.testing.assert_allclose(target, [1.0, 0.3])
    assert to_go == pytest.approx(1.2 + 0.1)
