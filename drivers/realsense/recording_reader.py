"""Reads a RealSense recording through the same SDK as the camera itself: a program of its own.

A recording that crashes the SDK ends this process alone; `playback` has the
other end of its connection. It sends `(config, path, level of the log)` and then timeouts, and gets
`(log records, answer)`, where an answer is intrinsics, a frame, None at the end, or an error.
"""

from __future__ import annotations

import logging
import math
import os
import resource
import signal
import threading
from collections.abc import Callable
from contextlib import ExitStack, suppress
from functools import partial
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, TypeVar

from drivers.realsense.config import RealSenseConfig
from drivers.realsense.recording_check import check_topics
from drivers.realsense.sdk import rs
from drivers.realsense.streams import RealSenseStreams, frame_stamps
from drivers.realsense.timestamps import FrameStamps
from vizbot.core.errors import ConfigError, DeviceError, DeviceTimeoutError, VizbotError
from vizbot.core.program.interpreter import end_when_left
from vizbot.core.program.log_records import LogRecords
from vizbot.core.types import Intrinsics, RGBDFrame

_SLICE = 0.02
"""Time without a frame after which the end of the recording is checked for [s]."""
_LAST_FRAME = 0.25
"""Time after the end for which the SDK may still bring a frame [s]."""
_OPENING, _INDEXED = 6.0, 1e8
"""Longest time to open a recording [s], and how much of it prolongs that by a second [bytes]."""
_READING = 2.0
"""Time beyond that for a frame after which the SDK counts as hanging [s]."""
_MOST_MEMORY = 1_500_000_000
"""Most memory of the process [bytes]; a camera's recording takes a tenth of it."""

T = TypeVar("T")


class RecordingReader:
    """Reads a `.db3` or `.bag` frame by frame, not in real time."""

    def __init__(self, config: RealSenseConfig, path: Path) -> None:
        """Open the recording at `path`.

        Raises:
            ConfigError: as `RealSenseRecording` does.
        """
        check_topics(path)
        self._name = f"recording {path}"
        self._stamps = FrameStamps(self._name)
        self._ended = False
        self._first_frame_timeout = config.first_frame_timeout
        pipeline = rs.pipeline(rs.context())
        wanted = rs.config()
        wanted.enable_device_from_file(str(path), repeat_playback=False)
        wanted.enable_stream(rs.stream.depth, 0, 0, rs.format.z16, 0)
        wanted.enable_stream(rs.stream.color, 0, 0, rs.format.any, 0)
        try:
            # Paused while it starts: otherwise the first frames are gone before a reader is there.
            resolved = wanted.resolve(rs.pipeline_wrapper(pipeline))
            self._playback = resolved.get_device().as_playback()
            self._playback.set_real_time(False)
            self._playback.pause()
            with ExitStack() as opened:
                self._streams = RealSenseStreams(pipeline, wanted, config, self._name)
                opened.callback(self._streams.close)
                # Beside the first read: where an image is damaged it waits until frames are taken.
                threading.Thread(target=self._playback.resume, daemon=True).start()
                opened.pop_all()
        except RuntimeError as error:
            reason = " ".join(str(error).split())
            raise ConfigError(
                f"{self._name}: cannot be played ({reason}); record colour and Z16 again"
            ) from error

    @property
    def intrinsics(self) -> Intrinsics:
        """Of the colour image, to which depth is registered."""
        return self._streams.intrinsics

    def read(self, timeout: float) -> RGBDFrame | None:
        """Return the next frame as `RealSenseRecording.read` does."""
        try:
            while (frames := self._wait(self.patience(timeout))) is not None:
                taken = frame_stamps(frames)
                accepted = taken and self._stamps.judge(*taken, self._streams.period)
                if accepted:
                    return self._streams.frame(frames, accepted)
        except RuntimeError as error:
            reason = " ".join(str(error).split())
            raise DeviceError(f"{self._name}: cannot be read ({reason}); copy it again") from error
        return None

    def patience(self, timeout: float) -> float:
        """How long `read` may wait for its frame [s]."""
        first = math.isinf(self._stamps.last)
        return max(timeout, self._first_frame_timeout) if first else timeout

    def _wait(self, timeout: float) -> Any:
        """The next frameset; None at the end."""
        for _ in range(max(1, round(timeout / _SLICE))):
            # Check before waiting: the last frame may arrive in between.
            self._ended |= self._playback.current_status() == rs.playback_status.stopped
            frames = self._streams.wait(_LAST_FRAME if self._ended else _SLICE)
            if frames is not None or self._ended:
                return frames
        raise DeviceTimeoutError(
            f"{self._name}: no frame within {timeout:g} s; give this machine less to do"
        )


def main(descriptor: str) -> None:
    """Answer at the socket of a descriptor until its other end is closed."""
    end_when_left(int(descriptor))
    resource.setrlimit(resource.RLIMIT_DATA, (_MOST_MEMORY, _MOST_MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    # It ends this process from within the SDK, too, which may hold the interpreter lock for ever.
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    try:
        _answer(Connection(int(descriptor)))
    finally:
        os._exit(0)  # without the SDK's own end, which may take ten seconds or for ever


def _answer(connection: Connection) -> None:
    """Answer until the other end is closed."""
    records = LogRecords()
    with suppress(EOFError, ConnectionError):
        config, path, level = connection.recv()
        logging.basicConfig(level=level, handlers=[records], force=True)
        opening = _OPENING + path.stat().st_size / _INDEXED
        reader = _outcome(partial(RecordingReader, config, path), opening)
        answer = reader.intrinsics if isinstance(reader, RecordingReader) else reader
        connection.send((records.take(), answer))
        while isinstance(reader, RecordingReader):
            timeout = connection.recv()
            frame = _outcome(partial(reader.read, timeout), reader.patience(timeout) + _READING)
            connection.send((records.take(), frame))


def _outcome(ask: Callable[[], T], seconds: float) -> T | VizbotError:
    """What a call returns, or the error it raises; the process ends if it takes longer."""
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        return ask()
    except VizbotError as error:
        return error
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
