"""What the first frames of a camera give away about its calibration, depth and stamps."""

import logging
import re
from dataclasses import replace

import numpy as np
import pytest

from drivers.tum_sequence import RecordedSequence
from tests.helpers.checkout import OFFICE_WALK
from vizbot.config import Config
from vizbot.core.geometry import camera_mount
from vizbot.core.types import ImuSamples, Intrinsics, RGBDFrame
from vizbot.perception.first_frames import FirstFrames
from vizbot.rehearsal.rig import Rig

CAMERA = Intrinsics(320, 240, 150.0, 150.0, 160.0, 120.0)
MOUNT = camera_mount(0.6, 0.0, 0.0)


def room(height=0.6, wall=4.0, stamp=0.0, camera=CAMERA, scale=1.0):
    """A floor `height` below a level camera, and a wall ahead."""
    down = (np.arange(240, dtype=np.float32) - 120.0) / 150.0
    floor = np.divide(height, down, out=np.full(240, np.inf, np.float32), where=down > 0)
    depth = np.tile(np.minimum(floor, wall)[:, None], (1, 320)).astype(np.float32) * scale
    return RGBDFrame(stamp, np.zeros((240, 320, 3), np.uint8), depth, camera, ImuSamples.none())


def said(caplog, frames, T_base_cam=MOUNT):
    first = FirstFrames(T_base_cam)
    with caplog.at_level(logging.INFO):
        for frame in frames:
            first.note(frame)
        first.note(None)
    return [record.getMessage() for record in caplog.records if record.levelname == "WARNING"]


def course(count=60, period=1 / 30, **values):
    """Frames of a robot that goes back from a wall."""
    return [
        room(stamp=7.5 + index * period, wall=3.0 + index / 15, **values) for index in range(count)
    ]


@pytest.mark.parametrize("count", [6, 49, 50, 51, 60])
def test_what_is_wrong_is_said_once_however_many_frames_there_are(caplog, count):
    frames = [room(stamp=float(index)) for index in range(count)]
    assert len(said(caplog, frames)) == 1


@pytest.mark.parametrize("count", [0, 1, 4, 60])
def test_good_frames_give_no_warning(caplog, count):
    assert said(caplog, course(count)) == []


def test_the_floors_height_is_always_said(caplog):
    said(caplog, course())
    assert re.search(r"the floor is 0\.6\d m below the camera", caplog.text)


def test_a_floor_that_is_not_seen_is_said_and_warns_of_nothing(caplog):
    wall = np.full((240, 320), 2.0, np.float32)
    assert said(caplog, [replace(frame, depth=wall) for frame in course()]) == []
    assert "show no floor" in caplog.text


@pytest.mark.parametrize(
    ("mount", "height", "scale"),
    [(MOUNT, 0.6, 0.5), (MOUNT, 0.6, 5.0), (None, 1.5, 0.2), (None, 1.5, 5.0)],
)
def test_a_wrong_depth_scale_is_a_warning(caplog, mount, height, scale):
    lines = said(caplog, course(height=height, scale=scale), mount)
    assert any("below the camera" in line or "of the depth lies" in line for line in lines)


def test_a_height_other_than_the_mounts_is_a_warning_with_both(caplog):
    [line] = said(caplog, course(height=0.9))
    assert "0.9" in line and "0.60 m" in line and "[mount]" in line


def test_intrinsics_of_another_resolution_are_a_warning(caplog):
    camera = replace(CAMERA, fx=300.0, fy=300.0, cx=320.0, cy=240.0)
    lines = said(caplog, course(camera=camera))
    assert "principal point 320, 240 is far from the centre of 320x240 images" in lines[0]


@pytest.mark.parametrize(
    ("first", "period", "words"),
    [
        (0.0, 1.0, "numbers or nanoseconds"),
        (1.7e18, 33_333_333.0, "numbers or nanoseconds"),
        (1.7e12, 33.0, "numbers or nanoseconds"),
        (1.5, 30.5, "give stamps in seconds"),
        (1.5, 0.000033, "give stamps in seconds"),
    ],
)
def test_stamps_that_are_no_seconds_are_a_warning(caplog, first, period, words):
    frames = [room(stamp=first + index * period) for index in range(6)]
    [line] = said(caplog, frames)
    assert words in line


def test_a_shelf_in_some_frames_is_not_taken_for_the_floor(caplog):
    frames = course()
    frames[0] = frames[30] = room(height=0.25)
    assert said(caplog, frames) == []


def test_a_bed_before_a_robot_at_rest_is_not_taken_for_the_floor(caplog):
    assert said(caplog, [room(height=0.25, stamp=1.5 + index / 30) for index in range(700)]) == []


@pytest.mark.parametrize(
    ("force", "warned"),
    [
        ((0.0, -9.8, 0.0), False),
        ((0.0, -8.0, -5.5), False),
        ((0.0, 9.8, 0.0), True),
        ((9.8, 0.0, 0.0), True),
    ],
)
def test_a_camera_that_is_not_upright_is_a_warning(caplog, force, warned):
    none = ImuSamples.none()
    imu = replace(none, accel=np.array([force, force]), accel_stamps=np.array([7.4, 7.45]))
    lines = said(caplog, [replace(frame, imu=imu) for frame in course()[:3]])
    assert any("upside down" in line for line in lines) == warned


@pytest.mark.skipif(not OFFICE_WALK.exists(), reason="the office recording is not here")
def test_the_office_walk_gives_no_warning(caplog):
    with RecordedSequence(OFFICE_WALK) as camera:
        frames = [camera.frame(index) for index in range(60)]
    assert said(caplog, frames, None) == []


@pytest.mark.slow
@pytest.mark.parametrize("world", ["3", pytest.param("10", marks=pytest.mark.long)])
def test_the_first_frames_of_a_simulated_home_give_no_warning(caplog, world):
    with Rig(Config(), "sim", "none", world) as rig:
        frames = [rig.devices.camera.read() for _ in range(60)]
        assert said(caplog, frames, rig.devices.T_base_cam) == []
