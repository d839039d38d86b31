"""The terminal of a driver: keys as they come, and one line that is rewritten in place."""

from __future__ import annotations

import os
import select
import termios
from contextlib import suppress

from vizbot.core.closeable import Closeable
from vizbot.core.errors import ConfigError

ASK = b"\x1b[?u"
"""The question which flags are in force: terminals with kitty's keyboard protocol answer it."""

_ENTER = b"\x1b[>27u\x1b[?1004h"
"""Report repeats and releases (2) of all keys (8), unambiguously (1), with text (16), and focus."""
_LEAVE = b"\x1b[?1004l\x1b[<u"
_CLEAR_REST = b"\x1b[K"
_INPUT, _LOCAL, _CHARACTERS = 0, 3, 6
_DISABLED = b"\0"


def require_terminal(descriptor: int) -> None:
    """Require a terminal to read keys from.

    Raises:
        ConfigError: the file descriptor is not that of a terminal.
    """
    if not os.isatty(descriptor):
        raise ConfigError(
            "standard input is no terminal, so no keys can be read; run it in one (over ssh with"
            " `ssh -t`)"
        )


class Terminal(Closeable):
    """A terminal whose keys are read one by one; closing it restores its settings.

    Writing never waits: what a stuck terminal does not take is lost.
    """

    def __init__(self, descriptor: int) -> None:
        """Open the terminal that a file descriptor belongs to, and take its keys.

        Ctrl-C still interrupts the program; Ctrl-S, Ctrl-Z and the like do nothing, since they
        would stop the program while the robot drives.

        Raises:
            ConfigError: it is no terminal, or cannot be opened.
        """
        require_terminal(descriptor)
        # A descriptor of its own: not to wait is no business of those who share the other one.
        path = _path(descriptor)
        try:
            self._descriptor = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        except OSError as error:
            raise ConfigError(
                f"terminal {path}: {error.strerror}; run it in a terminal of your own"
            ) from error
        try:
            self._before = termios.tcgetattr(self._descriptor)
            self._closed = False
            self._take_keys()
        except BaseException:
            os.close(self._descriptor)
            raise

    def read(self, timeout: float) -> bytes | None:
        """Wait up to `timeout` [s] for keys.

        Returns:
            The bytes that came in, perhaps none; None when the terminal is gone.
        """
        if not select.select([self._descriptor], [], [], max(0.0, timeout))[0]:
            return b""
        try:
            return os.read(self._descriptor, 4096) or None
        except BlockingIOError:
            return b""
        except OSError:  # hung up
            return None

    def write(self, sent: bytes) -> None:
        """Send what the terminal takes at once."""
        with suppress(OSError):  # stuck, or gone, which `read` reports
            os.write(self._descriptor, sent)

    def show(self, line: str) -> None:
        """Rewrite the live line, cut to the terminal's width."""
        columns = 80
        with suppress(OSError):
            columns = os.get_terminal_size(self._descriptor).columns or 80
        # Always, for others may have written there; cleared behind it, for it would flicker.
        self.write(b"\r" + line[: columns - 1].encode() + _CLEAR_REST)

    def close(self) -> None:
        """Restore the terminal."""
        if self._closed:
            return
        self._closed = True
        try:
            self.write(_LEAVE + b"\n")
            # Now: a terminal that is stuck never takes what was written before.
            with suppress(termios.error):
                termios.tcsetattr(self._descriptor, termios.TCSANOW, self._before)
                termios.tcflush(self._descriptor, termios.TCIFLUSH)
        finally:
            os.close(self._descriptor)

    def _take_keys(self) -> None:
        modes = termios.tcgetattr(self._descriptor)
        modes[_INPUT] &= ~(termios.IXON | termios.ICRNL | termios.INLCR | termios.IGNCR)
        modes[_LOCAL] &= ~(termios.ECHO | termios.ICANON | termios.IEXTEN)
        characters = list(modes[_CHARACTERS])
        for each in (termios.VQUIT, termios.VSUSP):
            characters[each] = _DISABLED
        characters[termios.VMIN], characters[termios.VTIME] = 1, 0
        modes[_CHARACTERS] = characters
        try:
            termios.tcsetattr(self._descriptor, termios.TCSANOW, modes)
            termios.tcflush(self._descriptor, termios.TCIFLUSH)  # typed before anybody drove
            self.write(_ENTER + ASK)
        except BaseException:
            termios.tcsetattr(self._descriptor, termios.TCSANOW, self._before)
            raise


def _path(descriptor: int) -> str:
    try:
        return os.ttyname(descriptor)
    except OSError:  # its device is not in this container
        return "/dev/tty"
