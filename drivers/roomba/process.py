"""The service of the base in a small process of its own.

Other Python work holds the interpreter lock for long. The service does not wait for it, and
outlives it: when the process that drives is killed, the service stops the wheels and ends. When the
service dies, the process that drives opens the port and stops the wheels at its next call.
"""

from __future__ import annotations

import functools
import logging
import logging.handlers
import multiprocessing
import os
import select
import signal
import sys
import time
from collections.abc import Callable, Sequence
from multiprocessing.connection import Connection

from drivers.roomba.config import RoombaConfig
from drivers.roomba.serial_port import SerialPort
from drivers.roomba.service import Order, Report, RoombaService, Trouble, stop_and_release
from drivers.roomba.state import with_contacts
from vizbot.core.errors import DeviceError
from vizbot.core.types import BaseState

logger = logging.getLogger(__name__)

_START_TIMEOUT = 20.0
"""Time for the process to start, which takes a second on an idle machine [s]."""
_END_TIMEOUT = 2.0
"""Time for the process to end [s]."""
_ORDERS = 20
"""Number of orders carried out between two steps at most."""
_UNREAD = 200
"""Number of reports stored at most for a reader that does not read."""
_PRIORITY = 20
"""Real-time priority, where the system allows one."""


class ProcessLink:
    """A service in another process.

    Attributes:
        name: Of the port.
        pid: Of the process.
    """

    def __init__(self, open_port: Callable[[], SerialPort], config: RoombaConfig) -> None:
        """Start the process and wait until it has opened the port.

        Args:
            open_port: Called in that process, so it must be picklable.
            config: Of the base.

        Raises:
            DeviceError: the port cannot be opened.
        """
        self._open_port = open_port
        self._ended = False
        context = multiprocessing.get_context("spawn")
        self._connection, theirs = context.Pipe()
        self._process = context.Process(
            target=_serve, args=(open_port, config, theirs, logger.getEffectiveLevel()), daemon=True
        )
        self._process.start()
        theirs.close()
        assert self._process.pid is not None
        self.pid = self._process.pid
        try:
            if not self._connection.poll(_START_TIMEOUT):
                raise DeviceError(f"the process of the base did not start in {_START_TIMEOUT} s")
            opened = self._connection.recv()
            if isinstance(opened, Trouble):
                raise DeviceError(opened.message)
        except EOFError:
            self.close()
            raise DeviceError("the process of the base ended while it started") from None
        except BaseException:
            self.close()
            raise
        self.name: str = opened

    def send(self, order: Order) -> None:
        """Send an order, carried out within 20 ms; lost once the process has ended (`receive`)."""
        try:
            self._connection.send(order)
        except OSError as error:
            logger.debug("%s: %s", self.name, error)

    def receive(self) -> Sequence[Report]:
        """Reports since the last call; log records of the process are logged here."""
        reports: list[Report] = []
        try:
            while self._connection.poll():
                received = self._connection.recv()
                if isinstance(received, logging.LogRecord):
                    logging.getLogger(received.name).handle(received)
                else:
                    reports.append(received)
        except (EOFError, OSError):
            self._stop_from_here()
            reports.append(Trouble(f"{self.name}: the process of the base ended", final=True))
        return reports

    def close(self) -> None:
        """Close the connection, upon which the other process stops the wheels and ends."""
        self._connection.close()
        self._process.join(_END_TIMEOUT)
        if self._process.is_alive():
            logger.error("the process of the base still tries to stop the wheels")
        elif self._process.exitcode != 0:
            self._stop_from_here()

    def _stop_from_here(self) -> None:
        """Stop the wheels from here: the other process ended without doing so."""
        if self._ended:
            return
        self._ended = True
        try:
            stop_and_release(self._open_port())
        except DeviceError as error:
            logger.error("the wheels may still turn: %s", error)


class Outbox(logging.Handler):
    """Sends reports and log records without ever waiting for the reader."""

    def __init__(self, connection: Connection) -> None:
        super().__init__()
        self._connection = connection
        self._unsent: list[object] = []

    def emit(self, record: logging.LogRecord) -> None:
        """Send a log record, its message formatted."""
        record.msg, record.args, record.exc_info = record.getMessage(), None, None
        self._unsent.append(record)

    def send(self, reports: Sequence[object]) -> None:
        """Send what fits; the rest is shortened such that no trouble and no contact is lost.

        Raises:
            OSError: the reader is gone.
        """
        self._unsent += reports
        while len(self._unsent) > _UNREAD:
            self._shorten()
        # A socket that can be written to takes a message of this size whole.
        while self._unsent and select.select([], [self._connection], [], 0)[1]:
            self._connection.send(self._unsent.pop(0))

    def _shorten(self) -> None:
        """Merge the two oldest states; without two, drop the oldest log record."""
        places = [n for n, kept in enumerate(self._unsent) if isinstance(kept, BaseState)]
        if len(places) < 2:
            others = (n for n, kept in enumerate(self._unsent) if not isinstance(kept, Report))
            del self._unsent[next(others, 0)]
            return
        older, newer = (self._unsent[place] for place in places[:2])
        assert isinstance(older, BaseState) and isinstance(newer, BaseState)
        self._unsent[places[1]] = with_contacts(newer, older)
        del self._unsent[places[0]]


def _serve(
    open_port: Callable[[], SerialPort], config: RoombaConfig, connection: Connection, level: int
) -> None:
    """Run until the other end of the connection is gone."""
    os.setsid()  # signals of the terminal are for the process that drives
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit())
    _raise_priority()
    outbox = Outbox(connection)
    logging.basicConfig(level=level, handlers=[outbox], force=True)
    try:
        service = RoombaService(open_port, time.monotonic, config)
    except DeviceError as error:
        connection.send(Trouble(str(error), final=True))
        return
    parent = os.getppid()
    try:
        connection.send(service.name)
        while os.getppid() == parent:
            has_port = service.step()
            for _ in range(_ORDERS):  # no flood of them keeps it from the port
                if not connection.poll():
                    break
                service.execute(connection.recv())
            outbox.send(service.reports())
            if not has_port:
                time.sleep(0.02)
    except (EOFError, OSError):
        pass  # nobody is left to drive
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        while service.is_reconnecting:  # stopping is the first thing once the cable is back
            service.step()
            time.sleep(0.02)
        service.close()


def _raise_priority() -> None:
    """Ask the system to run this process before others; without the right to it goes on as is."""
    for request in (
        functools.partial(os.sched_setscheduler, 0, os.SCHED_FIFO, os.sched_param(_PRIORITY)),
        functools.partial(os.nice, -10),
    ):
        try:
            request()
        except OSError:
            continue
        return
