"""Recordings whose images are of formats that other programs ask the SDK for."""

import cv2
import numpy as np
import pytest

from drivers.realsense.playback import RealSenseRecording
from drivers.realsense.sdk import rs
from drivers.realsense.streams import to_rgb
from sim_stubs.realsense import software_device
from tests.helpers.d435i_frames import ANY, START, read_all
from vizbot.core.types import Intrinsics

CAMERA = Intrinsics(64, 48, 60.0, 60.0, 32.0, 24.0)
RED = np.full((48, 64, 3), (200, 40, 30), np.uint8)
GREY = np.full((48, 64), 90, np.uint8)
Y, U, V = 90, 100, 199  # of that red, ITU-R BT.601 with its narrow range
YUYV = np.tile(np.array([[Y, U], [Y, V]], np.uint8), (48, 32, 1))
UYVY = YUYV[..., ::-1]
IMAGES = {
    "rgb8": RED,
    "bgr8": RED[..., ::-1],
    "rgba8": cv2.cvtColor(RED, cv2.COLOR_RGB2RGBA),
    "bgra8": cv2.cvtColor(RED, cv2.COLOR_RGB2BGRA),
    "yuyv": YUYV,
    "uyvy": UYVY,
    "y8": GREY,
    "y16": GREY.astype(np.uint16) * 256,
}


def write_recording(path, name, monkeypatch):
    image, usual = IMAGES[name], software_device._video_stream

    def stream(kind, uid, camera, fps, fmt, size):
        if kind == rs.stream.color:
            fmt, size = getattr(rs.format, name), image.nbytes // (48 * 64)
        return usual(kind, uid, camera, fps, fmt, size)

    monkeypatch.setattr(software_device, "_video_stream", stream)
    device = software_device.SoftwareD435i(color=CAMERA)
    depth = np.full((48, 64), 1500, np.uint16)
    depth[:10] = 65535
    with device.record(path):
        for index in range(3):
            device.push_frame(image, depth, START + index / 30)


@pytest.mark.parametrize("name", IMAGES)
def test_colour_of_any_format_comes_back_as_rgb(tmp_path, monkeypatch, name):
    path = tmp_path / "home.db3"
    write_recording(path, name, monkeypatch)
    with RealSenseRecording(ANY, path) as recording:
        frames = read_all(recording)
    assert len(frames) == 3
    wanted = RED if name not in ("y8", "y16") else np.repeat(GREY[..., None], 3, axis=2)
    for frame in frames:
        assert frame.rgb.dtype == np.uint8
        assert np.abs(frame.rgb.astype(int) - wanted).max() <= 3
        assert (frame.depth[:10] == 0).all()
        assert frame.depth[10:] == pytest.approx(1.5)


def test_an_image_of_another_size_is_refused():
    with pytest.raises(RuntimeError, match="another size"):
        to_rgb(RED, "rgb8", 48, 63)
