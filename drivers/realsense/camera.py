"""An Intel RealSense depth camera with colour (D435i and similar ones) as a `Camera`.

`recovery` decides what to do about a camera without frames, `timestamps` which framesets make a
frame, and `imu` reads gyroscope and accelerometer beside them.

Framesets come through a queue of one, not from the pipeline's own wait, which would try for 15 s to
reach a camera that was unplugged, and restart it without our settings.

The camera is read in the process that maps. The reflexes of the base, which must not wait for it,
run in another process, which stops the wheels should the SDK hang or end this one. While a software
camera is read at 30 frames a second, a thread due every millisecond is late by 0.4 ms at the 99th
percentile, as without a camera (`vizbot bench faults` measures it); while streams start it is late
by 12 ms, with the robot at rest.

Never tried on hardware: presets, exposure limits and the projector, USB 2, a cable that is pulled
out, the hardware reset, and stamps that are not in global time. Their tests use the SDK's software
device and its error texts.
"""

from __future__ import annotations

import logging
import math
from typing import Any

from drivers.realsense.config import RealSenseConfig
from drivers.realsense.discovery import CONNECT, cameras_by_serial, find_camera, frame_rate
from drivers.realsense.recovery import RecoveryStep, StreamRecovery
from drivers.realsense.sdk import rs
from drivers.realsense.sensor_options import apply_options
from drivers.realsense.streams import RealSenseStreams, frame_stamps, stamp_domain
from drivers.realsense.timestamps import FrameStamps, SharedClock
from vizbot.core.closeable import Closeable
from vizbot.core.errors import DeviceError, DeviceTimeoutError
from vizbot.core.interfaces import Clock
from vizbot.core.types import Intrinsics, RGBDFrame

log = logging.getLogger(__name__)

_LATE = 1.0
"""An IMU sample that is older than the frame before by more than this [s] is on another clock: a
camera's first stamps are on its own, until the SDK has compared it with the host's."""
_CHECK = "check its USB 3 cable and port"


class RealSense(Closeable):
    """A live camera.

    Depth is registered to colour with the factory calibration. Stamps are the SDK's, in seconds,
    mapped to the host's clock ("global time"), which images and IMU share; they increase steadily
    even when either clock is reset. IMU samples are rotated into the axes of `cam` where the
    extrinsics are known; a camera without an IMU gives none, and a gap in the frames has none.
    """

    def __init__(self, config: RealSenseConfig, clock: Clock, context: Any = None) -> None:
        """Open the camera; `context` is the SDK's, None for that of the connected cameras.

        Raises:
            DeviceError: there is no such camera, or it cannot stream as configured.
        """
        self._config = config
        self._clock = clock
        self._context = context if context is not None else rs.context()
        self._serial = find_camera(self._context, config.serial)
        self._name = f"RealSense {self._serial}"
        self._stamps = FrameStamps(self._name)
        self._shared_clock = SharedClock(self._name)
        self._reopened = False
        self._streams: RealSenseStreams | None = None
        self._recovery: StreamRecovery | None = None
        self._over = ""
        try:
            self._open()
        except RuntimeError as error:
            mode = f"{config.width}x{config.height} at {config.fps}/s"
            raise DeviceError(
                f"{self._name}: cannot stream colour and depth of {mode} ({_line(error)}); "
                f"close other programs that use it, choose a mode it has, or {CONNECT}"
            ) from error

    @property
    def intrinsics(self) -> Intrinsics:
        """Of the colour image, to which depth is registered."""
        return self._intrinsics

    @property
    def filter_cost(self) -> float:
        """Mean time of the depth filters per frame [s]; 0 without filters."""
        return 0.0 if self._streams is None else self._streams.filter_cost

    def read(self, timeout: float = 1.0) -> RGBDFrame:
        """Return the next frame, newer than any before.

        IMU samples that arrive after a younger frame come with the next one. Further calls recover
        a camera without frames, one step in each.

        The first frame gets `first_frame_timeout` at least, in place of `timeout` [s].

        Raises:
            DeviceTimeoutError: no frame came within `timeout`; recovery has started.
            DeviceError: no frame came for `reconnect_timeout`, or the camera is closed.
        """
        if self._over:
            raise DeviceError(self._over)
        if self._recovery is not None:
            self._recover(self._recovery)
        elif math.isinf(self._stamps.last):
            timeout = max(timeout, self._config.first_frame_timeout)
        began = self._clock.now()
        try:
            frame = self._next(timeout)
        except RuntimeError as error:
            self._close_streams()
            self._recovery_since(began).lose(self._clock.now())
            message = f"{self._name}: lost ({_line(error)})"
            raise DeviceTimeoutError(f"{message}; it is opened anew, {_CHECK}") from error
        if frame is None:
            self._recovery_since(began)
            raise DeviceTimeoutError(self._silence(timeout))
        if (recovery := self._recovery) is not None:
            by = f" by {recovery.last_step.value}" if recovery.last_step else ""
            silence = self._clock.now() - recovery.since
            log.warning("%s: frames again after %.1f s%s", self._name, silence, by)
            self._recovery = None
        return frame

    def close(self) -> None:
        """Stop the streams; twice is fine."""
        self._over = f"{self._name}: already closed; open the camera again"
        self._close_streams()

    def _open(self) -> None:
        """Start the streams of a connected camera.

        Starting those of another one would block the interpreter for 15 s.

        Raises:
            RuntimeError: the camera is not connected, or the SDK fails.
        """
        config, pipeline, wanted = self._config, rs.pipeline(self._context), rs.config()
        device = cameras_by_serial(self._context).get(self._serial)
        if device is None:
            raise RuntimeError("not listed")
        rate = frame_rate(device, config, self._name)
        wanted.enable_device(self._serial)
        size = config.width, config.height
        wanted.enable_stream(rs.stream.depth, *size, rs.format.z16, rate)
        wanted.enable_stream(rs.stream.color, *size, rs.format.rgb8, rate)
        # On the very device that will stream: it keeps some of its options in the SDK.
        resolved = wanted.resolve(rs.pipeline_wrapper(pipeline)).get_device()
        apply_options(resolved, config, self._name)
        self._streams = RealSenseStreams(pipeline, wanted, config, self._name, rs.frame_queue(1))
        self._intrinsics = self._streams.intrinsics

    def _next(self, timeout: float) -> RGBDFrame | None:
        """The next frame; None if none comes in time."""
        if self._streams is None:
            self._clock.sleep(timeout)
            return None
        end = self._clock.now() + timeout
        while (frames := self._streams.wait(end - self._clock.now())) is not None:
            taken, now, last = frame_stamps(frames), self._clock.now(), self._stamps.last
            accepted = taken and self._stamps.judge(*taken, self._streams.period, now)
            if accepted:
                self._shared_clock.note(stamp_domain(frames), now)
                before = accepted.stamp if math.isinf(last) else last
                # Samples of reopened streams cannot be late: they are younger than the gap.
                since = last if self._reopened else before - _LATE
                self._reopened = False
                return self._streams.frame(frames, accepted, since)
            if now >= end:
                break
        return None

    def _recovery_since(self, began: float) -> StreamRecovery:
        """The recovery under way; if there is none, one that started at `began` [s].

        It does not start at the last frame, since a reader may have been busy otherwise.
        """
        if self._recovery is None:
            limit, patience = self._config.reconnect_timeout, self._config.first_frame_timeout
            self._recovery = StreamRecovery(began, limit, patience, self._clock.now())
        return self._recovery

    def _recover(self, recovery: StreamRecovery) -> None:
        """Do the next step of recovery, if one is due.

        Raises:
            DeviceError: recovery has failed for good.
        """
        now = self._clock.now()
        step = recovery.next(now, self._streams is not None, self._listed() is not None)
        if step is RecoveryStep.WAIT:
            return
        self._close_streams()
        if step is RecoveryStep.GIVE_UP:
            silent = f"{self._name}: no frame for {now - recovery.since:.0f} s"
            self._over = f"{silent}; {_CHECK}, then launch again"
            raise DeviceError(self._over)
        log.warning("%s: no frame for %.1f s: %s", self._name, now - recovery.since, step.value)
        try:
            if step is RecoveryStep.RESET and (device := self._listed()) is not None:
                device.hardware_reset()
            elif step is RecoveryStep.OPEN:
                self._open()
                self._stamps.reopened()
                self._reopened = True
        except RuntimeError as error:
            log.warning("%s: %s failed (%s)", self._name, step.value, _line(error))
            if step is RecoveryStep.OPEN:
                recovery.fail(now)

    def _close_streams(self) -> None:
        if self._streams is not None:
            self._streams.close()
            self._streams = None

    def _listed(self) -> Any:
        """The camera on the bus (`rs.device`); None if it is not connected."""
        try:
            return cameras_by_serial(self._context).get(self._serial)
        except RuntimeError as error:
            log.debug("%s: cameras cannot be listed (%s)", self._name, _line(error))
            return None

    def _silence(self, timeout: float) -> str:
        if self._listed() is None:
            return f"{self._name}: unplugged; {_CHECK}, and connect it again"
        if self._streams is None:
            return f"{self._name}: not open; it is opened anew, {_CHECK}"
        fault = f" ({self._stamps.fault})" if self._stamps.fault else ""
        return f"{self._name}: no frame within {timeout:g} s{fault}; {_CHECK}"


def _line(error: Exception) -> str:
    return " ".join(str(error).split())
