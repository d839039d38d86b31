import numpy as np
import pytest

from mapping.odometry.config import GatingConfig
from mapping.odometry.dead_reckoned_pose import (
    DeadReckonedPose,
    may_link,
    turns_like_gyro,
)
from mapping.odometry.rgbd_odometry import RelativePose
from vizbot.core.geometry import camera_mount, invert, planar
from vizbot.core.types import SE3

CONFIG = GatingConfig()


def turned(wheels: float, gyro: float) -> tuple[DeadReckonedPose, DeadReckonedPose]:
    """Half a metre and a turn, as the two of them have it."""
    before = DeadReckonedPose(
        planar(3.0, 1.0, 2.9), planar(1.0, 2.0, -0.4), 4, 10.0, 0.0, 1e-4, 0.0, 0.0
    )
    return before, DeadReckonedPose(
        before.T_odom_base @ planar(0.5, 0.0, gyro),
        before.T_wheels_base @ planar(0.5, 0.0, wheels),
        4,
        11.0,
        1e-7,
        1e-4,
        0.0,
        gyro,
    )


@pytest.mark.parametrize(
    ("wheels", "gyro", "images", "sure", "like"),
    [
        (0.3, 0.3, 0.3, False, True),
        (0.3, 0.3, 0.31, False, True),
        (0.3, 0.3, 0.29, False, True),
        (0.3, 0.3, 0.35, False, False),
        (0.3, 0.3, -0.3, False, False),
        # It lies: wheels and images that agree outvote it.
        (0.3, 0.5, 0.3, False, True),
        (0.3, 0.5, 0.42, False, False),
        (0.48, 0.5, 0.3, False, False),
        # It lies a little: wheels, and images that are sure, outvote it.
        (0.305, 0.34, 0.3, True, True),
        (0.305, 0.34, 0.3, False, False),
        (0.305, 0.34, 0.33, True, True),
        (0.305, 0.34, 0.28, True, False),
    ],
)
def test_images_must_turn_as_the_gyroscope_does_unless_it_is_outvoted(
    wheels: float, gyro: float, images: float, sure: bool, like: bool
) -> None:
    before, now = turned(wheels, gyro)
    assert turns_like_gyro(planar(0.1, 0.4, images), sure, before, now, CONFIG) is like


def test_wheels_that_slip_do_not_outvote_the_gyroscope() -> None:
    before, now = turned(wheels=0.6, gyro=0.3)
    assert turns_like_gyro(planar(0.0, 0.0, 0.3), False, before, now, CONFIG)
    assert not turns_like_gyro(planar(0.0, 0.0, 0.2), False, before, now, CONFIG)


def test_where_the_gyroscope_does_not_know_images_may_turn_as_they_like() -> None:
    before = DeadReckonedPose(np.eye(4), np.eye(4), 4, 10.0, 0.0, 1e-4, 0.0, 0.0)
    now = DeadReckonedPose(np.eye(4), np.eye(4), 5, 11.0, 1e-7, 1e-4, 0.0, 0.0)
    assert turns_like_gyro(planar(0.0, 0.0, 1.0), False, before, now, CONFIG)


@pytest.mark.parametrize(
    ("inliers", "share", "moved", "links"),
    [(60, 0.9, 0.3, True), (10, 0.9, 0.3, False), (60, 0.5, 0.3, False), (60, 0.9, 1.5, False)],
)
def test_keyframes_are_linked_by_what_is_sure_and_near(
    inliers: int, share: float, moved: float, links: bool
) -> None:
    found = RelativePose(planar(moved, 0.0, 0.0), np.eye(6), inliers, share)
    assert may_link(found, np.eye(4), None, CONFIG) is links


@pytest.mark.parametrize(
    ("up", "tilt", "links"),
    [
        (0.0, 0.0, True),
        (0.02, 0.01, True),
        (0.06, 0.0, False),
        (-0.06, 0.0, False),
        (0, 0.05, False),
    ],
)
def test_on_a_floor_no_keyframe_is_linked_that_would_rise_or_tilt(
    up: float, tilt: float, links: bool
) -> None:
    T_base_cam = camera_mount(height=0.6, forward=0.1, tilt=0.3)
    off = planar(0.1, 0.05, 0.3)
    off[2, 3] = up
    off = off @ pitched(tilt)
    found = RelativePose(invert(T_base_cam) @ off @ T_base_cam, np.eye(6), 100, 0.9)
    assert may_link(found, np.eye(4), T_base_cam, CONFIG) is links
    assert may_link(found, np.eye(4), None, CONFIG), "a camera in a hand may"


def pitched(angle: float) -> SE3:
    T = np.eye(4)
    T[[0, 0, 2, 2], [0, 2, 0, 2]] = (
        np.cos(angle), np.sin(angle), -np.sin(angle), np.cos(angle),
    )  # fmt: skip
    return T
