"""Colour, depth and IMU of one RealSense device while they stream."""

from __future__ import annotations

import logging
import math
import weakref
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivers.depth import without_saturated
from drivers.realsense.colour import require_format, to_rgb
from drivers.realsense.config import RealSenseConfig
from drivers.realsense.depth_filters import DepthFilters
from drivers.realsense.imu import RealSenseImu
from drivers.realsense.sdk import rs
from drivers.realsense.timestamps import Accepted
from vizbot.core.camera_limits import is_stamp, require_camera, require_depth_scale
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

        Args:
            pipeline: `rs.pipeline` that is stopped.
            wanted: `rs.config` of a device with colour and depth (Z16).
            config: Settings of filters and IMU.
            name: Of the device, in the log.
            queue: `rs.frame_queue` for the framesets; None leaves them to the pipeline.

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

        Args:
            frames: `rs.composite_frame` with colour and depth.
            accepted: Its checked stamps.
            imu_since: IMU samples that are not younger are dropped [s, as the frames' stamps].

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
