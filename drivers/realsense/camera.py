"""An Intel RealSense depth camera with colour (D435i and its kin) as a `Camera`.

A camera that gives no frames is looked after by `realsense_recovery`; `realsense_stamps` says which
framesets make a frame, `realsense_imu` reads gyro and accelerometer beside them.

Framesets come through a queue of one, not from the pipeline's own wait: that wait would try for
15 s to reach a camera that was unplugged, and start it again without our settings.

The camera stays in the process that maps. What must not wait for it, the base's reflexes, has a
process of its own, which stops the wheels should the SDK hang or end this one. While a software
camera is read at 30 frames a second a thread that wants to run every millisecond is late by 0.4 ms
at the 99th percentile, as without a camera (`vizbot bench faults` measures it); while streams start
by 12 ms, with the robot at rest.

Never tried on hardware: presets, exposure limits and the projector, USB 2, a cable that is pulled
out, the hardware reset, and stamps that are not in global time. Their tests use the SDK's software
device and its error texts.
"""

from __future__ import annotations

import logging
import math
from typing import Any, Self

from drivers.realsense.config import RealSenseConfig
from drivers.realsense.discovery import CONNECT, find_camera, frame_rate, listed
from drivers.realsense.recovery import RecoveryStep, StreamRecovery
from drivers.realsense.sdk import rs
from drivers.realsense.sensor_options import apply_options
from drivers.realsense.streams import RealSenseStreams, frame_stamps, stamp_domain
from drivers.realsense.timestamps import FrameStamps, SharedClock
from vizbot.core.errors import DeviceError, DeviceTimeoutError
from vizbot.core.interfaces import Clock
from vizbot.core.types import Intrinsics, RGBDFrame

log = logging.getLogger(__name__)

_LATE = 1.0
"""An IMU sample that is older than the frame before by more than this [s] is on another clock: a
camera's first stamps are on its own, until the SDK has compared it with the host's."""
_CHECK = "check its USB 3 cable and port"


class RealSense:
    """A live camera.

    Depth is registered to colour with the factory calibration. Stamps are the SDK's, in seconds,
    mapped to the host's clock ("global time"), which images and IMU share; they go on when either
    clock is set anew. IMU samples are rotated into the axes of `cam` where the extrinsics are
    known; a camera without an IMU gives none, and there are none of a time without frames.
    """

    def __init__(self, config: RealSenseConfig, clock: Clock, context: Any = None) -> None:
        """Open the camera.

        Args:
            config: Which, and what it streams.
            clock: Real time.
            context: Where cameras are looked for; the SDK's software devices have their own.

        Raises:
            DeviceError: no such camera, or it cannot stream what is asked for.
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
        """What the filters of depth take for a frame in the mean [s]; 0 without any."""
        return 0.0 if self._streams is None else self._streams.filter_cost

    def read(self, timeout: float = 1.0) -> RGBDFrame:
        """Return the next frame, newer than any before.

        IMU samples that arrive after a frame that is younger than they are come with the next one.
        A camera without frames is looked after in further calls, one step in each.

        Args:
            timeout: How long to wait [s]; the first frame gets `first_frame_timeout` at least.

        Raises:
            DeviceTimeoutError: no frame came within `timeout`; the camera is looked after.
            DeviceError: it has had none for `reconnect_timeout`, or it is closed.
        """
        if self._over:
            raise DeviceError(self._over)
        if self._recovery is not None:
            self._carry_on(self._recovery)
        elif math.isinf(self._stamps.last):
            timeout = max(timeout, self._config.first_frame_timeout)
        began = self._clock.now()
        try:
            frame = self._next(timeout)
        except RuntimeError as error:
            self._let_go()
            self._notice(began).lose(self._clock.now())
            message = f"{self._name}: lost ({_line(error)})"
            raise DeviceTimeoutError(f"{message}; it is opened anew, {_CHECK}") from error
        if frame is None:
            self._notice(began)
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
        self._let_go()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exc: object) -> None:
        self.close()

    def _open(self) -> None:
        """Start the streams of a camera that is listed.

        Starting one that is not would hold the interpreter for 15 s.

        Raises:
            RuntimeError: it is not there, or the SDK refuses.
        """
        config, pipeline, wanted = self._config, rs.pipeline(self._context), rs.config()
        device = listed(self._context).get(self._serial)
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
        """The next frame, None if none comes in time."""
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
                # Streams that were opened anew cannot be late: theirs are younger than the gap.
                since = last if self._reopened else before - _LATE
                self._reopened = False
                return self._streams.frame(frames, accepted, since)
            if now >= end:
                break
        return None

    def _notice(self, began: float) -> StreamRecovery:
        """The recovery that is under way; begun, if there is none, by a wait since `began` [s].

        Not since the last frame: a reader may have been busy with something else.
        """
        if self._recovery is None:
            limit, patience = self._config.reconnect_timeout, self._config.first_frame_timeout
            self._recovery = StreamRecovery(began, limit, patience, self._clock.now())
        return self._recovery

    def _carry_on(self, recovery: StreamRecovery) -> None:
        """Do the next step, if one is due.

        Raises:
            DeviceError: the camera is given up.
        """
        now = self._clock.now()
        step = recovery.next(now, self._streams is not None, self._listed() is not None)
        if step is RecoveryStep.WAIT:
            return
        self._let_go()
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

    def _let_go(self) -> None:
        if self._streams is not None:
            self._streams.close()
            self._streams = None

    def _listed(self) -> Any:
        """The camera on the bus (`rs.device`); None if it is not there."""
        try:
            return listed(self._context).get(self._serial)
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
