"""Pose estimation with images, wheels and gyroscope failing for a while in all combinations."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise, product

import numpy as np
import pytest

from mapping.slam.config import SlamConfig
from mapping.slam.slam import Slam
from tests.helpers.box_room import CAMERA, T_BASE_CAM, errors, lap, render, turns, with_gyro
from vizbot.core.geometry import invert, planar, yaw_of
from vizbot.core.types import SE3, RGBDFrame, Tracking

pytestmark = pytest.mark.slow

STANDS, FAILS = 5, range(20, 32)
PATH = [lap(100)[0]] * STANDS + lap(100)[:22] + lap(100)[20::-1] + [lap(100)[0]] * 5
IMAGES = ("right", "dark", "frozen")
WHEELS = ("right", "missing", "slipping", "stuck")
GYRO = ("right", "missing", "lying")


@pytest.fixture(scope="module")
def frames() -> dict[str, list[RGBDFrame]]:
    lit = [render(T, 0.2 * i) for i, T in enumerate(PATH)]
    dark = [render(T, 0.2 * i, dark=True) for i, T in enumerate(PATH)]
    return {"right": lit, "dark": dark, "frozen": [lit[FAILS.start - 1]] * len(lit)}


def by_wheels(kind: str) -> list[SE3 | None]:
    told: list[SE3 | None] = [PATH[0]]
    T_odom_base = PATH[0]
    for i, (a, b) in enumerate(pairwise(PATH), 1):
        step = invert(a) @ b
        if i in FAILS and kind == "slipping":
            step = planar(1.3 * step[0, 3], 1.3 * step[1, 3], 1.3 * yaw_of(step))
        if i in FAILS and kind == "stuck":
            step = np.eye(4)
        T_odom_base = T_odom_base @ step
        told.append(None if i in FAILS and kind == "missing" else T_odom_base)
    return told


def seen(shown: Sequence[RGBDFrame], lit: Sequence[RGBDFrame], gyro: str) -> list[RGBDFrame]:
    told = []
    for i, turn in enumerate(turns(PATH)):
        fails = i in FAILS
        frame = replace((shown if fails else lit)[i], stamp=0.2 * i)
        off = 0.02 if fails and gyro == "lying" else 0.0  # 0.1 rad/s
        told.append(frame if fails and gyro == "missing" else with_gyro(frame, turn + off))
    return told


# Each sensor fails alone, then two and three of them at once.
@pytest.mark.sampled(
    "right-right", "right-missing-right", "right-slipping-right", "right-stuck-right",
    "dark-slipping-right", "frozen-missing-lying",
)  # fmt: skip
@pytest.mark.parametrize(("images", "wheels", "gyro"), [*product(IMAGES, WHEELS, GYRO)])
def test_sensors_that_fail_for_a_while_leave_no_error_behind(
    frames: dict[str, list[RGBDFrame]], images: str, wheels: str, gyro: str
) -> None:
    slam = Slam(CAMERA, T_BASE_CAM, SlamConfig())
    moments = zip(seen(frames[images], frames["right"], gyro), by_wheels(wheels), strict=True)
    estimates = [slam.track(frame, T_odom_base) for frame, T_odom_base in moments]
    off = errors(estimates, PATH)
    assert estimates[-1].tracking is Tracking.TRACKING
    assert off[-5:].max() < 0.1
    if [images, wheels, gyro].count("right") >= 2:
        known = [e.tracking is not Tracking.LOST for e in estimates]
        assert off[known].max() < 0.15
