"""The service of the base in a small process of its own, under a watchdog in another one.

Other Python work holds the interpreter lock for long. The service does not wait for it, and
outlives it: when the process that drives is killed, the service stops the wheels and ends. When the
service dies or hangs, its watchdog stops the wheels in its stead and replaces it. When the watchdog
dies, the service stops the wheels and ends, and the process that drives stops them once more. When
the watchdog hangs, alone or with the service, the process that drives kills both, stops the wheels
and starts another pair.
"""

from __future__ import annotations

import logging
import multiprocessing
import os
import signal
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress

from drivers.roomba.config import RoombaConfig
from drivers.roomba.reflex_process.channel import Channel, Outbox, open_channel
from drivers.roomba.reflex_process.watchdog import (
    MOST_ENDS,
    OPENING,
    PERIOD,
    SILENCE,
    WITHIN,
    Heartbeat,
    OverdueLooks,
    SharedBytes,
    Watchdog,
)
from drivers.roomba.serial_port import SerialPort
from drivers.roomba.service import Order, Report, RoombaService, Trouble, stop_and_release
from vizbot.core.errors import DeviceError

logger = logging.getLogger(__name__)

_START_TIMEOUT = 20.0
"""Time for the process to start, which takes a second on an idle machine [s]."""
_END_TIMEOUT = 2.0
"""Time for the process to end [s]."""
_AGAIN = 0.005
"""Time between two tries to open the port [s]."""
_ORDERS = 20
"""Number of orders carried out between two steps at most."""
_NAP = 0.1
"""Shortest suspension of the machine after which the wheels are stopped [s]."""


class ProcessLink:
    """A service in another process.

    Attributes:
        name: Of the port.
        pid: Of the watchdog, whose child the service is.
    """

    def __init__(self, open_port: Callable[[], SerialPort], config: RoombaConfig) -> None:
        """Start the process and wait until it has opened the port.

        `open_port` is called in that process, so it must be picklable.

        Raises:
            DeviceError: the port cannot be opened.
        """
        self._open_port, self._config = open_port, config
        self._ended = self._closing = False
        self.name = "the base"
        self._context = multiprocessing.get_context("spawn")
        self._memory = Heartbeat.shared_memory(self._context)
        self._heartbeat = Heartbeat(self._memory)
        self._replaced: deque[float] = deque(maxlen=MOST_ENDS)
        self._reports: list[Report] = []
        self._lock = threading.Lock()
        self._closed = threading.Event()
        self._start()
        try:
            if not self._channel.poll(_START_TIMEOUT):
                raise DeviceError(f"the process of the base did not start in {_START_TIMEOUT} s")
            opened = self._channel.recv()
            if not isinstance(opened, str):
                raise DeviceError(opened.message if isinstance(opened, Trouble) else str(opened))
        except EOFError:
            self.close()
            raise DeviceError("the process of the base ended while it started") from None
        except BaseException:
            self.close()
            raise
        self.name = opened
        threading.Thread(target=self._watch, name="watch of the watchdog", daemon=True).start()

    def send(self, order: Order) -> None:
        """Send an order, carried out within 20 ms; lost once the process has ended (`receive`)."""
        try:
            with self._lock:
                self._channel.send(order)
        except OSError as error:
            logger.debug("%s: %s", self.name, error)

    def receive(self) -> Sequence[Report]:
        """Reports since the last call; log records of the process are logged here."""
        with self._lock:
            reports, self._reports = self._reports, []
            if self._ended:
                return [*reports, self._end()]
            try:
                while self._channel.poll():
                    received = self._channel.recv()
                    if isinstance(received, logging.LogRecord):
                        logging.getLogger(received.name).handle(received)
                    elif isinstance(received, Report):
                        reports.append(received)
            except (EOFError, OSError):
                self._stop_from_here()
                self._ended = True
                reports.append(self._end())
        return reports

    def close(self) -> None:
        """Close the connection, upon which the service stops the wheels and ends."""
        with self._lock:
            self._closing = True
            unborn = self._heartbeat.watchdog_deadline - time.monotonic() > OPENING
            if self._replaced and unborn and not self._ended:
                self._replace()  # another pair that has not begun yet: there is nothing to end
        end = time.monotonic() + _END_TIMEOUT
        self._channel.finish(_END_TIMEOUT)
        self._process.join(max(0.2, end - time.monotonic()))
        with self._lock:
            self._closed.set()
        if self._process.is_alive():
            logger.error(
                "%s: the wheels could not be stopped yet; plug the base's cable in again: within"
                " %.0f s of its loss they are stopped then, after Ctrl-C too",
                self.name,
                self._config.reconnect_timeout,
            )
        elif self._process.exitcode != 0 and not self._ended:
            self._stop_from_here()
        self._ended = True

    def _start(self) -> None:
        """Start a watchdog with its service; they go on from the last checkpoint."""
        self._heartbeat.beat_as_watchdog(_START_TIMEOUT)
        self._channel, theirs = open_channel()
        level = logger.getEffectiveLevel()
        self._process = self._context.Process(
            target=_guard,
            args=(self._open_port, self._config, theirs, self._memory, level),
            daemon=True,
        )
        self._process.start()
        theirs.close()
        assert self._process.pid is not None
        self.pid = self._process.pid

    def _watch(self) -> None:
        """Watch the watchdog until the link is closed."""
        looks = OverdueLooks()
        while not self._closed.wait(PERIOD):
            if not looks.hangs(self._heartbeat.watchdog_deadline):
                continue
            with self._lock:
                if self._closed.is_set() or self._ended:
                    return
                if self._process.exitcode == 0:  # it has ended as it should
                    return
                looks = OverdueLooks()
                self._replace()

    def _replace(self) -> None:
        """Kill watchdog and service, stop the wheels, and start another pair unless that is often.

        A watchdog that is dead is not replaced.
        """
        dead = self._process.exitcode is not None
        if not dead:
            self._process.kill()
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(self.pid, signal.SIGKILL)  # the service is in its group
        self._stop_from_here(patience=_END_TIMEOUT)  # it holds the port until it is gone
        self._process.join(_END_TIMEOUT)
        self._channel.close()
        self._replaced.append(time.monotonic())
        often = len(self._replaced) == MOST_ENDS and self._replaced[-1] - self._replaced[0] < WITHIN
        if dead or often or self._closing:
            self._ended = True
            return
        hung = f"{self.name}: the processes of the base gave no sign of life for {SILENCE} s"
        logger.warning("%s: stopped the wheels", hung)
        self._reports.append(Trouble(f"{hung}; they are replaced"))
        self._start()

    def _end(self) -> Trouble:
        return Trouble(f"{self.name}: the process of the base ended", final=True)

    def _stop_from_here(self, patience: float = 0.0) -> None:
        """Stop the wheels from here within `patience` [s]: the other process does not."""
        end = time.monotonic() + patience
        last = self._heartbeat.checkpoint()
        state = None if last is None else last.state
        while True:
            try:
                port = self._open_port()
            except DeviceError as error:
                if time.monotonic() < end:
                    time.sleep(_AGAIN)
                    continue
                logger.error("the wheels may still turn: %s", error)
                return
            stop_and_release(port, on_charger=state is not None and state.on_charger)
            return


def _guard(
    open_port: Callable[[], SerialPort],
    config: RoombaConfig,
    channel: Channel,
    memory: SharedBytes,
    level: int,
) -> None:
    """Keep a service running until the other end of the channel is gone."""
    os.setsid()  # signals of the terminal are for the process that drives
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    outbox = Outbox(channel)
    logging.basicConfig(level=level, handlers=[outbox], force=True)

    def serve(heartbeat: Heartbeat) -> None:
        logging.basicConfig(level=level, handlers=[Outbox(channel)], force=True)
        _serve(open_port, config, channel, heartbeat)

    def stop(heartbeat: Heartbeat, reason: str) -> None:
        last = heartbeat.checkpoint()
        name = "the base" if last is None else last.name
        logger.warning("%s: the process of the base %s: stopping the wheels", name, reason)
        try:
            state = None if last is None else last.state
            stop_and_release(open_port(), on_charger=state is not None and state.on_charger)
        except DeviceError as error:
            logger.error("the wheels may still turn: %s", error)
        outbox.send([Trouble(f"{name}: the process of the base {reason}; it is replaced")])

    sys.exit(Watchdog(serve, stop, Heartbeat(memory)).run())


def _serve(
    open_port: Callable[[], SerialPort],
    config: RoombaConfig,
    channel: Channel,
    heartbeat: Heartbeat,
) -> None:
    """Run until the other end of the channel or the watchdog is gone."""
    outbox = logging.getLogger().handlers[0]
    assert isinstance(outbox, Outbox)
    parent = os.getppid()
    heartbeat.beat(OPENING)
    last = heartbeat.checkpoint()
    try:
        service = RoombaService(open_port, time.monotonic, config, last)
    except DeviceError as error:
        channel.send(Trouble(str(error), final=True))
        return
    try:
        if last is None:
            channel.send(service.name)
        slept = _slept()
        while os.getppid() == parent:
            heartbeat.beat(OPENING if service.is_reconnecting else SILENCE)
            if _slept() > slept + _NAP:  # no timeout has passed, but the wheels may have turned on
                slept = _slept()
                service.wake()
            has_port = service.step()
            for _ in range(_ORDERS):  # no flood of them keeps it from the port
                if not channel.poll():
                    break
                order = channel.recv()
                assert isinstance(order, Order)
                service.execute(order)
            reports = service.reports()
            if reports:
                heartbeat.remember(service.checkpoint())
            outbox.send(reports)
            if not has_port:
                time.sleep(0.02)
    except (EOFError, OSError):
        pass  # nobody is left to drive
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        heartbeat.beat(OPENING)
        while service.is_reconnecting:  # stopping is the first thing once the cable is back
            service.step()
            time.sleep(0.02)
            heartbeat.beat(OPENING)
        heartbeat.beat(SILENCE)
        service.close()


def _slept() -> float:
    """Time for which the machine has been suspended since it started [s], which stops `monotonic`.

    A pause between the two readings makes it less, never more.
    """
    return time.clock_gettime(time.CLOCK_BOOTTIME) - time.monotonic()
