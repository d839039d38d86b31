"""Latency of the robot's computer: how long embeddings and decisions take in an episode."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from pydantic import TypeAdapter

from vizbot.config import Config
from vizbot.core.closeable import Closeable
from vizbot.core.interfaces import Base, Devices
from vizbot.core.simulated_clock import SimulatedClock
from vizbot.core.types import STOP, BaseState, Feedback, Twist

MEASURED = Path(__file__).with_name("latency.json")
"""The kept measurement, made by `python -m benchmarks.loop_latency`."""


@dataclass(frozen=True, slots=True)
class Latencies:
    """Durations that were measured on a machine.

    Attributes:
        commit: The commit of the measured sources.
        hardware: The machine in a few words.
        load: Mean number of other running programs in the minute before.
        embedding: Durations of the embedding of one frame [s].
        decision: Durations from frame and base state to the command that they lead to [s].
    """

    commit: str
    hardware: str
    load: float
    embedding: tuple[float, ...]
    decision: tuple[float, ...]

    @staticmethod
    def kept() -> Latencies:
        """The kept measurement."""
        return TypeAdapter(Latencies).validate_json(MEASURED.read_bytes())


def slow_devices(devices: Devices, latencies: Latencies, config: Config, seed: int) -> Devices:
    """Let embeddings and decisions take simulated time, each a measured duration drawn anew.

    An `embedding_latency` over 0 in the robot's settings is replaced.
    """
    clock, base = devices.clock, devices.base
    assert isinstance(clock, SimulatedClock) and base is not None
    embedding = _drawn_from(latencies.embedding, np.random.default_rng((seed, 6)))
    decision = _drawn_from(latencies.decision, np.random.default_rng((seed, 7)))
    configured = config.perception.embedding_latency
    clock.slow_down(lambda: embedding() / configured)
    return replace(devices, base=DecidedBase(base, lambda: clock.sleep(decision())))


def _drawn_from(values: Sequence[float], rng: np.random.Generator) -> Callable[[], float]:
    return lambda: float(rng.choice(values))


class DecidedBase(Closeable):
    """A base that tells when the program begins to decide, and when it has decided.

    Meanwhile it goes on as last commanded. On a robot, whose camera is faster than the simulated
    one, the base hears after every decision and stops only if one takes longer than its timeout.
    """

    def __init__(
        self, base: Base, decided: Callable[[], None], began: Callable[[], None] = lambda: None
    ) -> None:
        """Wrap a base.

        Args:
            base: The base.
            decided: Called before the first command after a `read`.
            began: Called after each `read`.
        """
        self._base = base
        self._decided, self._began = decided, began
        self._deciding = False
        self._twist = STOP

    def drive(self, twist: Twist) -> None:
        """Drive, once `decided` has returned if the program was deciding."""
        if self._deciding:
            self._deciding = False
            self._base.drive(self._twist)
            self._decided()
        self._base.drive(twist)
        self._twist = twist

    def read(self) -> BaseState:
        """The newest state, with which a decision begins."""
        state = self._base.read()
        self._deciding = True
        self._began()
        return state

    def resume(self) -> None:
        """Ask the base to obey again."""
        self._twist = STOP
        self._base.resume()

    def dock(self) -> None:
        """Make the base look for its dock."""
        self._twist = STOP
        self._base.dock()

    def show(self, feedback: Feedback) -> None:
        """Show feedback on the base."""
        self._base.show(feedback)

    def close(self) -> None:
        """Close the base."""
        self._base.close()
