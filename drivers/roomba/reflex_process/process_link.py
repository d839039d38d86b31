"""The service of the base in a small process of its own, under a watchdog in another one.

Other Python work holds the interpreter lock for long. The service does not wait for it, and
outlives it: when the process that drives is killed, the service stops the wheels and ends. When the
service dies or hangs, its watchdog stops the wheels in its stead and replaces it. When the watchdog
dies, the service stops the wheels and ends, and the process that drives stops them once more.
"""

from __future__ import annotations

import logging
import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Callable, Sequence

from drivers.roomba.config import RoombaConfig
from drivers.roomba.reflex_process.channel import Channel, Outbox, open_channel
from drivers.roomba.reflex_process.watchdog import OPENING, SILENCE, Heartbeat, Watchdog
from drivers.roomba.serial_port import SerialPort
from drivers.roomba.service import Order, Report, RoombaService, Trouble, stop_and_release
from vizbot.core.errors import DeviceError

logger = logging.getLogger(__name__)

_START_TIMEOUT = 20.0
"""Time for the process to start, which takes a second on an idle machine [s]."""
_END_TIMEOUT = 2.0
"""Time for the process to end [s]."""
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

        Args:
            open_port: Called in that process, so it must be picklable.
            config: Of the base.

        Raises:
            DeviceError: the port cannot be opened.
        """
        self._open_port, self._reconnect_timeout = open_port, config.reconnect_timeout
        self._ended, self.name = False, "the base"
        context = multiprocessing.get_context("spawn")
        self._channel, theirs = open_channel()
        self._process = context.Process(
            target=_guard, args=(open_port, config, theirs, logger.getEffectiveLevel()), daemon=True
        )
        self._process.start()
        theirs.close()
        assert self._process.pid is not None
        self.pid = self._process.pid
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

    def send(self, order: Order) -> None:
        """Send an order, carried out within 20 ms; lost once the process has ended (`receive`)."""
        try:
            self._channel.send(order)
        except OSError as error:
            logger.debug("%s: %s", self.name, error)

    def receive(self) -> Sequence[Report]:
        """Reports since the last call; log records of the process are logged here."""
        reports: list[Report] = []
        try:
            while self._channel.poll():
                received = self._channel.recv()
                if isinstance(received, logging.LogRecord):
                    logging.getLogger(received.name).handle(received)
                elif isinstance(received, Report):
                    reports.append(received)
        except (EOFError, OSError):
            self._stop_from_here()
            reports.append(Trouble(f"{self.name}: the process of the base ended", final=True))
        return reports

    def close(self) -> None:
        """Close the connection, upon which the service stops the wheels and ends."""
        end = time.monotonic() + _END_TIMEOUT
        self._channel.finish(_END_TIMEOUT)
        self._process.join(max(0.2, end - time.monotonic()))
        if self._process.is_alive():
            logger.error(
                "%s: the wheels could not be stopped yet; plug the base's cable in again: within"
                " %.0f s of its loss they are stopped then, after Ctrl-C too",
                self.name,
                self._reconnect_timeout,
            )
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


def _guard(
    open_port: Callable[[], SerialPort], config: RoombaConfig, channel: Channel, level: int
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

    sys.exit(Watchdog(serve, stop).run())


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
