"""Intel RealSense depth cameras with colour (D435i and its kin), live or from a recording.

Both go through the same `rs.pipeline`; `realsense_imu` reads gyro and accelerometer beside it.
"""

from __future__ import annotations

import logging
import math
import weakref
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Self

import numpy as np
from pydantic import BaseModel, Field

from drivers.librealsense import rs
from drivers.realsense_imu import RealSenseImu
from drivers.recording import check_recording
from vizbot.core.errors import ConfigError, DeviceError, DeviceTimeoutError
from vizbot.core.settings import SETTINGS
from vizbot.core.types import ImuSamples, Intrinsics, RGBDFrame

log = logging.getLogger(__name__)

_CONNECT = (
    "connect it to a USB 3 port with a USB 3 cable, and on Linux install the udev rules of "
    "librealsense (99-realsense-libusb.rules)"
)
_RECONNECT = "check its USB 3 cable and port, and connect it again"
_PLAYBACK_SLICE_MS = 20
_LAST_FRAME_MS = 250


class RealSenseConfig(BaseModel):
    """Which camera, and what it streams. A recording streams what was recorded."""

    model_config = SETTINGS

    serial: str | None = None
    """Serial number printed on the camera; without one the first camera found."""
    width: int = Field(640, gt=0)
    """Of the colour and the depth image [px]."""
    height: int = Field(480, gt=0)
    """Of the colour and the depth image [px]."""
    fps: int = Field(30, gt=0)
    """Images per second."""
    imu: bool = True
    """Read gyro and accelerometer where the camera has them."""
    gyro_rate: int = Field(200, gt=0)
    """Gyro samples per second; the nearest rate of the camera is taken."""
    accel_rate: int = Field(100, gt=0)
    """Accelerometer samples per second; the nearest rate of the camera is taken."""
    first_frame_timeout: float = Field(5.0, gt=0)
    """The least time to wait for the first frame [s]: a camera takes a while to start."""


class RealSense:
    """A `Camera` over the RealSense SDK.

    Depth is registered to colour with the factory calibration. Stamps are the SDK's, in seconds;
    a live camera's are mapped to the host's clock ("global time"), which images and IMU share.
    IMU samples are rotated into the axes of `cam` where the extrinsics are known; a camera without
    an IMU gives none. A recording is played frame by frame as it is read, not in real time.

    Args:
        config: Which camera, and what it streams.
        recording: A `.db3` or `.bag` to play instead of a live camera.
        context: Where cameras are looked for; the SDK's software devices have their own.

    Raises:
        DeviceError: no such camera, or it cannot stream what is asked for.
        ConfigError: the recording is missing, torn, or has no colour (RGB8) and depth.
    """

    def __init__(
        self,
        config: RealSenseConfig,
        recording: Path | None = None,
        context: Any = None,
    ) -> None:
        self._context = context if context is not None else rs.context()
        self._pipeline = rs.pipeline(self._context)
        self._playback: Any = None
        self._ended = False
        self._stamp = -math.inf
        self._first_frame_timeout = config.first_frame_timeout
        self._imu: RealSenseImu | None = None
        if recording is not None:
            self._name = f"recording {recording}"
            streams = _recorded_streams(recording)
        else:
            self._serial = _find_camera(self._context, config.serial)
            self._name = f"RealSense {self._serial}"
            streams = _live_streams(config, self._serial)
        with ExitStack() as opened:
            try:
                if recording is not None:
                    # Paused while it starts: otherwise the first frames are gone before a reader
                    # is there.
                    resolved = streams.resolve(rs.pipeline_wrapper(self._pipeline))
                    self._playback = resolved.get_device().as_playback()
                    self._playback.set_real_time(False)
                    self._playback.pause()
                # The motion sensor is closed after the pipeline has stopped: while a recording's
                # reader waits for the pipeline to take a frame, closing the sensor waits for it.
                imu_opened = opened.enter_context(ExitStack())
                profile = self._pipeline.start(streams)
                opened.callback(self._pipeline.stop)
                device = profile.get_device()
                color = profile.get_stream(rs.stream.color).as_video_stream_profile()
                self._intrinsics = _pinhole(color)
                if any(distortion := color.get_intrinsics().coeffs):
                    log.warning("%s: lens distortion %s is ignored", self._name, distortion)
                self._depth_scale = np.float32(device.first_depth_sensor().get_depth_scale())
                depth = profile.get_stream(rs.stream.depth).as_video_stream_profile()
                self._align = None if _coincide(depth, color) else rs.align(rs.stream.color)
                if recording is None:
                    _use_global_time(device)
                if config.imu:
                    self._imu = RealSenseImu(device, color, config.gyro_rate, config.accel_rate)
                    imu_opened.callback(self._imu.close)
                if self._playback is not None:
                    self._playback.resume()
            except RuntimeError as error:
                raise _refusal(self._name, config, recording, error) from error
            # Also at the interpreter's exit: a callback of the SDK after that ends the process.
            self._release = weakref.finalize(self, opened.pop_all().close)

    @property
    def intrinsics(self) -> Intrinsics:
        """Of the colour image, to which depth is registered."""
        return self._intrinsics

    def read(self, timeout: float = 1.0) -> RGBDFrame | None:
        """Return the next frame, newer than any before; None at the end of a recording.

        IMU samples that arrive after a frame that is younger than they are come with the next one.

        Args:
            timeout: How long to wait [s]; the first frame gets `first_frame_timeout` at least.

        Raises:
            DeviceTimeoutError: no frame came within `timeout`.
            DeviceError: the camera is gone or closed.
        """
        if not self._release.alive:
            raise DeviceError(f"{self._name}: already closed; open the camera again")
        if self._stamp == -math.inf:
            timeout = max(timeout, self._first_frame_timeout)
        try:
            # The pipeline repeats an image whose partner came alone.
            while (frames := self._wait(timeout)) is not None:
                stamp = frames.get_color_frame().get_timestamp() / 1000.0
                if stamp > self._stamp:
                    self._stamp = stamp
                    return self._registered(frames, stamp)
        except RuntimeError as error:
            raise DeviceError(f"{self._name}: lost ({_line(error)}); {_RECONNECT}") from error
        return None

    def close(self) -> None:
        """Stop the streams; twice is fine."""
        self._release()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exc: object) -> None:
        self.close()

    def _wait(self, timeout: float) -> Any:
        """The next frameset, None at the end of a recording."""
        if self._playback is None:
            arrived, frames = self._pipeline.try_wait_for_frames(round(timeout * 1000))
            if not arrived:
                raise self._silence(timeout)
            return frames
        for _ in range(max(1, round(timeout * 1000 / _PLAYBACK_SLICE_MS))):
            # Asked before waiting: the last frame may arrive between the two.
            self._ended |= self._playback.current_status() == rs.playback_status.stopped
            slice_ms = _LAST_FRAME_MS if self._ended else _PLAYBACK_SLICE_MS
            arrived, frames = self._pipeline.try_wait_for_frames(slice_ms)
            if arrived:
                return frames
            if self._ended:
                return None
        raise self._silence(timeout)

    def _silence(self, timeout: float) -> DeviceError:
        if self._playback is None and self._serial not in _serials(self._context):
            return DeviceError(f"{self._name}: unplugged; {_RECONNECT}")
        return DeviceTimeoutError(f"{self._name}: no frame within {timeout:g} s; {_RECONNECT}")

    def _registered(self, frames: Any, stamp: float) -> RGBDFrame:
        aligned = frames if self._align is None else self._align.process(frames)
        # The SDK's buffers go back to a small pool: copy what is kept.
        rgb = np.array(aligned.get_color_frame().get_data(), dtype=np.uint8)
        raw = np.asanyarray(aligned.get_depth_frame().get_data())
        depth = raw.astype(np.float32) * self._depth_scale
        imu = ImuSamples.none() if self._imu is None else self._imu.take(stamp)
        return RGBDFrame(stamp, rgb, depth, self._intrinsics, imu)


def _serials(context: Any) -> list[str]:
    devices = list(context.query_devices())
    return [str(device.get_info(rs.camera_info.serial_number)) for device in devices]


def _find_camera(context: Any, wanted: str | None) -> str:
    """Serial number of the camera to open.

    Starting a pipeline without a camera holds the interpreter for 15 s, so the list comes first.
    """
    serials = _serials(context)
    if not serials:
        which = "no RealSense camera" if wanted is None else f"RealSense {wanted}: no camera at all"
        raise DeviceError(f"{which} found; {_CONNECT}")
    if wanted is not None and wanted not in serials:
        found = ", ".join(serials)
        raise DeviceError(f"RealSense {wanted}: not found, only {found}; set serial, or {_CONNECT}")
    return wanted or serials[0]


def _live_streams(config: RealSenseConfig, serial: str) -> Any:
    streams = rs.config()
    streams.enable_device(serial)
    size = config.width, config.height
    streams.enable_stream(rs.stream.depth, *size, rs.format.z16, config.fps)
    streams.enable_stream(rs.stream.color, *size, rs.format.rgb8, config.fps)
    return streams


def _recorded_streams(recording: Path) -> Any:
    check_recording(recording)
    streams = rs.config()
    streams.enable_device_from_file(str(recording), repeat_playback=False)
    streams.enable_stream(rs.stream.depth, 0, 0, rs.format.z16, 0)
    streams.enable_stream(rs.stream.color, 0, 0, rs.format.rgb8, 0)
    return streams


def _refusal(
    name: str, config: RealSenseConfig, recording: Path | None, error: RuntimeError
) -> DeviceError | ConfigError:
    if recording is not None:
        return ConfigError(f"{name}: cannot be played ({_line(error)}); record RGB8 and Z16 again")
    mode = f"{config.width}x{config.height} at {config.fps}/s"
    return DeviceError(
        f"{name}: cannot stream colour and depth of {mode} ({_line(error)}); "
        f"close other programs that use it, choose a mode it has, or {_CONNECT}"
    )


def _line(error: Exception) -> str:
    return " ".join(str(error).split())


def _pinhole(profile: Any) -> Intrinsics:
    lens = profile.get_intrinsics()
    return Intrinsics(lens.width, lens.height, lens.fx, lens.fy, lens.ppx, lens.ppy)


def _coincide(depth: Any, color: Any) -> bool:
    """Whether depth is registered as it comes, as in a recording of aligned or simulated images.

    The SDK's alignment rounds such an image to one with rows of holes.
    """
    between = depth.get_extrinsics_to(color)
    apart = any(between.translation) or between.rotation != np.eye(3).ravel().tolist()
    return not apart and _pinhole(depth) == _pinhole(color)


def _use_global_time(device: Any) -> None:
    for sensor in device.query_sensors():
        if sensor.supports(rs.option.global_time_enabled):
            sensor.set_option(rs.option.global_time_enabled, 1)
