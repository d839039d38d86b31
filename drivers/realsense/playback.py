"""A RealSense recording as a `Camera`, read by the SDK in a process of its own.

The SDK trusts recordings: one that is damaged or made to harm ends the process that reads it, makes
it hang, or fills the memory. That process is not this one, its memory is bounded, and it ends
itself when it takes too long.
"""

from __future__ import annotations

import logging
import signal
import socket
import subprocess
from multiprocessing.connection import Connection
from pathlib import Path

from drivers.realsense.config import RealSenseConfig
from drivers.realsense.recording_check import check_header
from vizbot.core.closeable import Closeable
from vizbot.core.errors import ConfigError, DeviceError, VizbotError
from vizbot.core.program.interpreter import interpreter_command
from vizbot.core.types import Intrinsics, RGBDFrame


class RealSenseRecording(Closeable):
    """Plays a `.db3` or `.bag` frame by frame as it is read, not in real time.

    Depth is registered to colour, IMU samples are rotated into the axes of `cam`, and stamps are
    those of the recording [s]. Depth is filtered only if the settings ask for it.
    """

    def __init__(self, config: RealSenseConfig, path: Path) -> None:
        """Open the recording at `path`.

        Raises:
            ConfigError: the recording is missing, incomplete or damaged, or has no colour
                and depth (Z16).
        """
        check_header(path)
        self._name = f"recording {path}"
        self._closed = False
        ours, theirs = socket.socketpair()
        with theirs:
            self._process = subprocess.Popen(
                interpreter_command("drivers.realsense.recording_reader", str(theirs.fileno())),
                pass_fds=[theirs.fileno()],
                stdin=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,  # what the C++ runtime writes while it ends the process
                start_new_session=True,  # signals of the terminal are for the process that maps
            )
        self._reader = Connection(ours.detach())
        try:
            opened = self._asked((config, path, logging.getLogger().getEffectiveLevel()))
        except EOFError:
            self.close()
            raise ConfigError(
                f"{self._name}: cannot be played ({self._end()}); record colour and Z16 again"
            ) from None
        except BaseException:
            self.close()
            raise
        assert isinstance(opened, Intrinsics)
        self._intrinsics = opened

    @property
    def intrinsics(self) -> Intrinsics:
        """Of the colour image, to which depth is registered."""
        return self._intrinsics

    def read(self, timeout: float = 1.0) -> RGBDFrame | None:
        """Return the next frame, newer than any before; None at the end.

        IMU samples that were recorded after a younger frame come with the next one.

        The first frame gets `first_frame_timeout` at least, in place of `timeout` [s].

        Raises:
            DeviceTimeoutError: the SDK gives no frame within `timeout`.
            DeviceError: the recording is closed, or the SDK cannot read on.
        """
        if self._closed:
            raise DeviceError(f"{self._name}: already closed; open it again")
        try:
            frame = self._asked(timeout)
        except EOFError:
            raise DeviceError(
                f"{self._name}: cannot be read ({self._end()}); copy it again"
            ) from None
        assert frame is None or isinstance(frame, RGBDFrame)
        return frame

    def close(self) -> None:
        """Stop playing; twice is fine."""
        self._closed = True
        self._reader.close()
        self._process.kill()
        self._process.wait()

    def _asked(self, question: object) -> object:
        """The answer of the process; what it logged meanwhile is logged here.

        Raises:
            EOFError: it has ended.
            VizbotError: it raised this.
        """
        try:
            self._reader.send(question)
            records, answer = self._reader.recv()
        except OSError as error:
            raise EOFError from error
        for record in records:
            logging.getLogger(record.name).handle(record)
        if isinstance(answer, VizbotError):
            raise answer
        return answer

    def _end(self) -> str:
        """Why the process has ended, in words."""
        code = self._process.wait()
        return "it takes too long" if code == -signal.SIGALRM else "it ends the SDK"
