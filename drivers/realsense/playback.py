"""A RealSense recording as a `Camera`, through the same SDK as the camera itself."""

from __future__ import annotations

import math
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Self

from drivers.realsense.config import RealSenseConfig
from drivers.realsense.recording_check import check_recording
from drivers.realsense.sdk import rs
from drivers.realsense.streams import RealSenseStreams, frame_stamps
from drivers.realsense.timestamps import FrameStamps
from vizbot.core.errors import ConfigError, DeviceError, DeviceTimeoutError
from vizbot.core.types import Intrinsics, RGBDFrame

_SLICE = 0.02
"""Time without a frame after which the end of the recording is checked for [s]."""
_LAST_FRAME = 0.25
"""Time after the end for which the SDK may still bring a frame [s]."""


class RealSenseRecording:
    """Plays a `.db3` or `.bag` frame by frame as it is read, not in real time.

    Depth is registered to colour, IMU samples are rotated into the axes of `cam`, and stamps are
    those of the recording [s]. Depth is filtered only if the settings ask for it.
    """

    def __init__(self, config: RealSenseConfig, path: Path) -> None:
        """Open the recording at `path`.

        Raises:
            ConfigError: the recording is missing or incomplete, or has no colour (RGB8) and depth
                (Z16).
        """
        check_recording(path)
        self._name = f"recording {path}"
        self._stamps = FrameStamps(self._name)
        self._ended = False
        self._closed = False
        self._first_frame_timeout = config.first_frame_timeout
        pipeline = rs.pipeline(rs.context())
        wanted = rs.config()
        wanted.enable_device_from_file(str(path), repeat_playback=False)
        wanted.enable_stream(rs.stream.depth, 0, 0, rs.format.z16, 0)
        wanted.enable_stream(rs.stream.color, 0, 0, rs.format.rgb8, 0)
        try:
            # Paused while it starts: otherwise the first frames are gone before a reader is there.
            resolved = wanted.resolve(rs.pipeline_wrapper(pipeline))
            self._playback = resolved.get_device().as_playback()
            self._playback.set_real_time(False)
            self._playback.pause()
            with ExitStack() as opened:
                self._streams = RealSenseStreams(pipeline, wanted, config, self._name)
                opened.callback(self._streams.close)
                self._playback.resume()
                opened.pop_all()
        except RuntimeError as error:
            reason = " ".join(str(error).split())
            raise ConfigError(
                f"{self._name}: cannot be played ({reason}); record RGB8 and Z16 again"
            ) from error

    @property
    def intrinsics(self) -> Intrinsics:
        """Of the colour image, to which depth is registered."""
        return self._streams.intrinsics

    def read(self, timeout: float = 1.0) -> RGBDFrame | None:
        """Return the next frame, newer than any before; None at the end.

        IMU samples that were recorded after a younger frame come with the next one.

        Args:
            timeout: How long to wait [s]; the first frame gets `first_frame_timeout` at least.

        Raises:
            DeviceTimeoutError: the SDK gives no frame within `timeout`.
            DeviceError: the recording is closed, or the SDK cannot read on.
        """
        if self._closed:
            raise DeviceError(f"{self._name}: already closed; open it again")
        if math.isinf(self._stamps.last):
            timeout = max(timeout, self._first_frame_timeout)
        try:
            while (frames := self._wait(timeout)) is not None:
                taken = frame_stamps(frames)
                accepted = taken and self._stamps.judge(*taken, self._streams.period)
                if accepted:
                    return self._streams.frame(frames, accepted)
        except RuntimeError as error:
            reason = " ".join(str(error).split())
            raise DeviceError(f"{self._name}: cannot be read ({reason}); copy it again") from error
        return None

    def close(self) -> None:
        """Stop playing; twice is fine."""
        self._closed = True
        self._streams.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exc: object) -> None:
        self.close()

    def _wait(self, timeout: float) -> Any:
        """The next frameset; None at the end."""
        for _ in range(max(1, round(timeout / _SLICE))):
            # Asked before waiting: the last frame may arrive between the two.
            self._ended |= self._playback.current_status() == rs.playback_status.stopped
            frames = self._streams.wait(_LAST_FRAME if self._ended else _SLICE)
            if frames is not None or self._ended:
                return frames
        raise DeviceTimeoutError(
            f"{self._name}: no frame within {timeout:g} s; give this machine less to do"
        )
