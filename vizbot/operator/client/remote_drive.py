"""Drives a running robot by hand over its API."""

from __future__ import annotations

import json
import threading
import time
from contextlib import ExitStack, suppress
from types import TracebackType
from typing import Self
from urllib.parse import urlencode

from websockets.exceptions import ConnectionClosed, InvalidHandshake, InvalidStatus, InvalidURI

from vizbot.core.errors import DeviceError, DeviceTimeoutError
from vizbot.core.types import BaseState, Twist
from vizbot.operator.client.base_json import base_state_of
from vizbot.operator.client.robot_client import RobotClient

_STATE_EVERY = 0.2
_CLOSES_WITHIN = 2.0
_SILENT = 1.0
"""Age from which a state of the base counts as none [s]."""


class RemoteDrive:
    """Holds the drive lease of a running robot until it is closed.

    A `with` that ends without an error gives the lease back, and the robot's task goes on. After an
    error, or where the link is lost, the robot rests until somebody asks it to go on.
    """

    def __init__(self, client: RobotClient, who: str, *, over: bool = False) -> None:
        """Take the drive lease as `who`, with `over` from whoever holds it.

        Raises:
            VizbotError: the robot does not answer. Where somebody else is driving, `drive` says so.
        """
        self._client = client
        self._lock = threading.Lock()
        self._robot_time: float | None = None
        self._sequence = 0
        self._refused = ""
        self._state: tuple[float, BaseState | None] | None = None
        self._closed = threading.Event()
        query = urlencode({"who": who, "over": "true" if over else "false"})
        self._link = ExitStack()
        try:
            self._socket = self._link.enter_context(client.open_websocket(f"/drive?{query}"))
        except (OSError, InvalidURI, InvalidHandshake) as error:
            status = error.response.status_code if isinstance(error, InvalidStatus) else 0
            reason = f"{error}{client.hint(status)}"
            raise DeviceError(f"the robot at {client.url} cannot be driven: {reason}") from error
        self._listener = threading.Thread(target=self._listen, daemon=True)
        self._poller = threading.Thread(target=self._poll_state, daemon=True)
        self._listener.start()
        self._poller.start()

    def drive(self, twist: Twist) -> None:
        """Have the robot hold `twist` until the next call, for 0.3 s at most.

        Raises:
            DeviceError: somebody else is driving, or the link is lost.
        """
        if self._refused:
            raise DeviceError(self._refused)
        with self._lock:
            heard = self._robot_time
        if heard is None:
            return  # the robot has not sent its time yet
        motion = {
            "sequence": self._sequence,
            "heard": heard,
            "linear": twist.linear,
            "angular": twist.angular,
        }
        self._sequence += 1
        try:
            self._socket.send(json.dumps(motion))
        except (ConnectionClosed, OSError) as error:
            self._listener.join(_CLOSES_WITHIN)  # the robot's last message may say why
            lost = f"the link to {self._client.url} is lost and the robot stands; start again"
            raise DeviceError(self._refused or lost) from error

    def read(self) -> BaseState:
        """The newest state of the base, as the robot reports it.

        Raises:
            DeviceTimeoutError: the robot, or its base, has been silent for a while.
        """
        newest = self._state
        if newest is None or time.monotonic() - newest[0] > _SILENT:
            raise DeviceTimeoutError(f"the robot at {self._client.url} is silent; waiting for it")
        if newest[1] is None:
            raise DeviceTimeoutError("the robot has not heard of its base yet; waiting for it")
        return newest[1]

    def resume(self) -> None:
        """Ask the base to obey again.

        Raises:
            DeviceError: the robot does not answer, or its base is gone.
        """
        self._client.resume()

    def give_back(self) -> None:
        """Give the lease back, so that the robot goes on with its task."""
        with suppress(ConnectionClosed, OSError):
            self._socket.send(json.dumps({"done": True}))

    def close(self) -> None:
        """End the link; twice is fine."""
        self._closed.set()
        self._link.close()
        for thread in (self._listener, self._poller):
            thread.join(timeout=_CLOSES_WITHIN)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if error is None:
            self.give_back()
        self.close()

    def _listen(self) -> None:
        """Keep the newest of the robot's times."""
        try:
            for message in self._socket:
                said = json.loads(message)
                if not isinstance(said, dict):
                    raise ValueError(said)
                if "refused" in said:
                    self._refused = _refusal(said["refused"])
                with self._lock:
                    self._robot_time = said.get("time", self._robot_time)
        except (ConnectionClosed, OSError, ValueError, RecursionError):
            return  # the next drive() raises

    def _poll_state(self) -> None:
        """Keep the newest state of the base."""
        while not self._closed.wait(_STATE_EVERY):
            try:
                base = self._client.state()["base"]
                now = time.monotonic()
                self._state = (now, None if base is None else base_state_of(base, now))
            except (DeviceError, KeyError):
                continue  # the next read() raises


def _refusal(holder: str | None) -> str:
    """Why the robot refuses to be driven; `holder` is None where somebody has stopped it."""
    if holder is None:
        return "the robot was stopped, and nobody drives it any more; start again to drive it"
    return f"{holder} drives; try --over"
