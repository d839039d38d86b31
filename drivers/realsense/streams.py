"""Colour, depth and IMU of one RealSense device while they stream.

Depth is filtered by the SDK's own filters before it is registered to colour: in disparity, as Intel
recommends, where the error of a stereo camera does not depend on distance, so that a step that
counts as an edge is the same near and far.
"""

from __future__ import annotations

import logging
import math
import time
import weakref
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from drivers.realsense.config import (
    DepthFilterConfig,
    RealSenseConfig,
    SpatialFilterConfig,
    TemporalFilterConfig,
)
from drivers.realsense.imu import RealSenseImu
from drivers.realsense.sdk import rs
from drivers.realsense.timestamps import Accepted
from vizbot.core.camera_limits import (
    is_stamp,
    require_camera,
    require_depth_scale,
    without_saturated,
)
from vizbot.core.types import ImuSamples, Intrinsics, RGBDFrame

log = logging.getLogger(__name__)


class RealSenseStreams:
    """Streams from the constructor to `close()`; it does not start again.

    Attributes:
        intrinsics: Of the colour image, to which depth is registered.
        period: From one image to the next [s].
    """

    def __init__(
        self, pipeline: Any, wanted: Any, config: RealSenseConfig, name: str, queue: Any = None
    ) -> None:
        """Start the streams.

        `pipeline` (`rs.pipeline`) is stopped; `wanted` (`rs.config`) has colour and depth (Z16);
        without a `queue` (`rs.frame_queue`) the framesets are left to the pipeline.

        Raises:
            RuntimeError: the SDK fails.
        """
        with ExitStack() as opened:
            # The motion sensor is closed after the pipeline has stopped: while a recording's
            # reader waits for the pipeline to take a frame, closing the sensor waits for it.
            imu_opened = opened.enter_context(ExitStack())
            profile = pipeline.start(wanted) if queue is None else pipeline.start(wanted, queue)
            opened.callback(_quietly, pipeline.stop)
            device = profile.get_device()
            color = profile.get_stream(rs.stream.color).as_video_stream_profile()
            self.intrinsics = _pinhole(color)
            self._depth_scale = np.float32(device.first_depth_sensor().get_depth_scale())
            _require_calibration(self.intrinsics, float(self._depth_scale))
            self._color_format = str(color.format().name)
            require_format(self._color_format)
            self.period = 1.0 / max(color.fps(), 1)
            if any(distortion := color.get_intrinsics().coeffs):
                log.warning("%s: lens distortion %s is ignored", name, distortion)
            depth = profile.get_stream(rs.stream.depth).as_video_stream_profile()
            self._align = None if _coincide(depth, color) else rs.align(rs.stream.color)
            self._filters = DepthFilters(config.filters)
            self._take = (
                queue.try_wait_for_frame if queue is not None else pipeline.try_wait_for_frames
            )
            self._imu: RealSenseImu | None = None
            if config.imu:
                self._imu = RealSenseImu(device, color, config.gyro_rate, config.accel_rate)
                imu_opened.callback(_quietly, self._imu.close)
            # Also at the interpreter's exit: a callback of the SDK after that ends the process.
            self._release = weakref.finalize(self, opened.pop_all().close)

    @property
    def filter_cost(self) -> float:
        """Mean time of the depth filters per frame [s]."""
        return self._filters.cost

    def wait(self, seconds: float) -> Any:
        """The next frameset (`rs.composite_frame`); None if none comes within `seconds`.

        Raises:
            RuntimeError: the SDK has lost the device.
        """
        arrived, frames = self._take(round(1000 * max(seconds, 0.0)))
        return frames.as_frameset() if arrived else None

    def frame(self, frames: Any, accepted: Accepted, imu_since: float = -math.inf) -> RGBDFrame:
        """Make a frame of a frameset.

        IMU samples that are not younger than `imu_since` are dropped [s, as the frames' stamps].

        Raises:
            RuntimeError: its images are not of the size that the calibration says.
        """
        rgb, depth = self._images(frames)
        imu = self._samples(accepted, imu_since)
        return RGBDFrame(accepted.stamp, rgb, depth, self.intrinsics, imu)

    def close(self) -> None:
        """Stop the streams; twice is fine."""
        self._release()

    def _images(self, frames: Any) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
        filtered = self._filters.process(frames)
        aligned = filtered if self._align is None else self._align.process(filtered)
        # The SDK's buffers return to a small pool: copy them.
        size = self.intrinsics.height, self.intrinsics.width
        color = np.asanyarray(aligned.get_color_frame().get_data())
        rgb = to_rgb(color, self._color_format, *size)
        raw = np.asanyarray(aligned.get_depth_frame().get_data())
        if rgb.shape != (*size, 3) or raw.shape != size:
            raise RuntimeError("its images are of another size than its calibration says")
        return rgb, without_saturated(raw).astype(np.float32) * self._depth_scale

    def _samples(self, accepted: Accepted, since: float) -> ImuSamples:
        if self._imu is None:
            return ImuSamples.none()
        if accepted.jumped:  # samples of both clocks are mixed: these are on neither
            self._imu.forget()
        return self._imu.take(accepted.stamp, since, accepted.offset)


def frame_stamps(frames: Any) -> tuple[float, float] | None:
    """Stamps of colour and depth of a frameset [s]; None unless both have one."""
    color, depth = frames.get_color_frame(), frames.get_depth_frame()
    if not color or not depth:
        return None
    stamps = color.get_timestamp() / 1000.0, depth.get_timestamp() / 1000.0
    return stamps if all(map(is_stamp, stamps)) else None


def stamp_domain(frames: Any) -> str:
    """The SDK's name for the clock of the colour image's stamp."""
    return str(frames.get_color_frame().get_frame_timestamp_domain().name)


def _quietly(end: Callable[[], None]) -> None:
    """Call `end`, ignoring that the device may be gone."""
    try:
        end()
    except RuntimeError as error:
        log.debug("not stopped: %s", error)


def _pinhole(profile: Any) -> Intrinsics:
    lens = profile.get_intrinsics()
    return Intrinsics(lens.width, lens.height, lens.fx, lens.fy, lens.ppx, lens.ppy)


def _require_calibration(lens: Intrinsics, depth_unit: float) -> None:
    """Check that a camera may have these values; a damaged recording has others.

    Raises:
        RuntimeError: it may not.
    """
    try:
        require_camera(lens)
        require_depth_scale(1.0 / depth_unit if depth_unit else math.inf)
    except ValueError as error:
        raise RuntimeError(f"no camera has its calibration: {error}") from error


def _coincide(depth: Any, color: Any) -> bool:
    """Whether depth is already registered, as in a recording of aligned or simulated images.

    The SDK's alignment rounds such an image to one with rows of holes.
    """
    between = depth.get_extrinsics_to(color)
    apart = any(between.translation) or between.rotation != np.eye(3).ravel().tolist()
    return not apart and _pinhole(depth) == _pinhole(color)


_CONVERSIONS = {
    "bgr8": cv2.COLOR_BGR2RGB,
    "rgba8": cv2.COLOR_RGBA2RGB,
    "bgra8": cv2.COLOR_BGRA2RGB,
    "yuyv": cv2.COLOR_YUV2RGB_YUYV,
    "uyvy": cv2.COLOR_YUV2RGB_UYVY,
    "y8": cv2.COLOR_GRAY2RGB,
    "y16": cv2.COLOR_GRAY2RGB,
}
"""By the SDK's name of the format (`rs.format`)."""


def require_format(name: str) -> None:
    """Check that images of a format, by the SDK's name, can be converted.

    Raises:
        RuntimeError: they cannot.
    """
    if name != "rgb8" and name not in _CONVERSIONS:
        raise RuntimeError(f"its colour is {name}, which is not one of {', '.join(_CONVERSIONS)}")


def to_rgb(pixels: NDArray[np.generic], name: str, height: int, width: int) -> NDArray[np.uint8]:
    """A copy (H, W, 3) of the SDK's buffer, whose pixels have the format `name`.

    Raises:
        RuntimeError: it is of another size.
    """
    raw = np.ascontiguousarray(pixels).view(np.uint8).ravel()
    if raw.size == 0 or raw.size % (height * width):
        raise RuntimeError("its images are of another size than its calibration says")
    image = raw.reshape(height, width, -1)
    if name == "rgb8":
        return image.copy()
    # Of 16 bits the higher ones are the second byte.
    kept = image[..., 1:].copy() if name == "y16" else image
    return np.asarray(cv2.cvtColor(kept, _CONVERSIONS[name]), np.uint8)


_FARTHEST = 16.0
"""Of the SDK's threshold filter [m]."""


class DepthFilters:
    """The configured filters, in order; without any, frames pass unchanged."""

    def __init__(self, config: DepthFilterConfig) -> None:
        """Build a chain for one run of the streams: temporal filters have state."""
        self._chain: list[Any] = []
        self._seconds = 0.0
        self._frames = 0
        if config.nearest is not None or config.farthest is not None:
            farthest = _FARTHEST if config.farthest is None else config.farthest
            nearest = min(config.nearest or 0.0, _FARTHEST)
            self._chain.append(rs.threshold_filter(nearest, min(farthest, _FARTHEST)))
        smoothing = []
        if config.spatial is not None:
            smoothing.append(_spatial(config.spatial))
        if config.temporal is not None:
            smoothing.append(_temporal(config.temporal))
        if smoothing:
            to_disparity, to_depth = rs.disparity_transform(True), rs.disparity_transform(False)
            self._chain += [to_disparity, *smoothing, to_depth]

    @property
    def cost(self) -> float:
        """Mean time per frame on this machine so far [s]; 0 without filters."""
        return self._seconds / self._frames if self._frames else 0.0

    def process(self, frames: Any) -> Any:
        """The frameset with its depth filtered."""
        if not self._chain:
            return frames
        began = time.perf_counter()
        for stage in self._chain:
            frames = stage.process(frames)
        self._seconds += time.perf_counter() - began
        self._frames += 1
        return frames.as_frameset()


def _spatial(config: SpatialFilterConfig) -> Any:
    stage = rs.spatial_filter()
    stage.set_option(rs.option.filter_magnitude, config.passes)
    stage.set_option(rs.option.filter_smooth_alpha, config.alpha)
    stage.set_option(rs.option.filter_smooth_delta, config.delta)
    return stage


def _temporal(config: TemporalFilterConfig) -> Any:
    stage = rs.temporal_filter()
    stage.set_option(rs.option.filter_smooth_alpha, config.alpha)
    stage.set_option(rs.option.filter_smooth_delta, config.delta)
    stage.set_option(rs.option.holes_fill, config.persistence)
    return stage
