"""Protocols that real and simulated devices and clocks satisfy, and the devices of a run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, Self, TypeVar

from vizbot.core.types import SE3, BaseState, Feedback, Intrinsics, RGBDFrame, Twist

T = TypeVar("T")
T_co = TypeVar("T_co", covariant=True)


class Device(Protocol):
    """Open once constructed; closed after `close()` or on leaving a `with` block.

    A constructor that fails leaves nothing open. Closing twice is fine.
    """

    def close(self) -> None:
        """Release the device."""
        ...

    def __enter__(self) -> Self: ...

    def __exit__(self, *exc: object) -> None: ...


class Camera(Device, Protocol):
    """A calibrated RGB-D camera, or a recording of one."""

    @property
    def intrinsics(self) -> Intrinsics:
        """Intrinsics of the colour image, to which depth is registered."""
        ...

    def read(self, timeout: float = 1.0) -> RGBDFrame | None:
        """Return the next frame, newer than any before; None at the end of a recording.

        Raises:
            DeviceTimeoutError: no frame came within `timeout` [s].
            DeviceError: the camera is gone or closed.
        """
        ...


class Base(Device, Protocol):
    """A differential-drive base."""

    def drive(self, twist: Twist) -> None:
        """Hold `twist`, limited to what the base can do, until the next call.

        The base stops by itself when no call follows within its command timeout, after `close()`,
        and on a cliff.

        Raises:
            DeviceError: the base is gone or closed.
        """
        ...

    def resume(self) -> None:
        """Ask a base that has stopped obeying, at an edge or to dock, to obey again.

        Its wheels are stopped first. `read().mode` shows whether it obeys.

        Raises:
            DeviceError: the base is gone or closed.
        """
        ...

    def dock(self) -> None:
        """Make the base look for its dock by itself; it obeys no `drive` until `resume`.

        It looks only while `drive` goes on being called, with whatever twist: else it is stopped,
        as a base that drives is. `read().docked` shows when it is there.

        Raises:
            DeviceError: the base is gone or closed.
        """
        ...

    def show(self, feedback: Feedback) -> None:
        """Show feedback to people by light and sound.

        Raises:
            DeviceError: the base is gone or closed.
        """
        ...

    def read(self) -> BaseState:
        """Return the newest odometry and contacts.

        Raises:
            DeviceTimeoutError: the base has been silent for too long.
            DeviceError: the base is gone or closed.
        """
        ...


class Pending(Protocol[T_co]):
    """Work that runs beside the caller."""

    def ready(self) -> bool:
        """Whether `result()` returns at once."""
        ...

    def result(self) -> T_co:
        """What the work returned; its exception is raised here."""
        ...


class Clock(Protocol):
    """Time, and whatever runs beside the caller as time passes.

    On the wall clock that means threads. In lockstep simulation it means that the world calls it
    between two of its steps, so that a seed gives the same run twice.
    """

    @property
    def simulated(self) -> bool:
        """Whether time passes only while somebody sleeps, in lockstep."""
        ...

    def now(self) -> float:
        """Seconds since an arbitrary start; never goes back."""
        ...

    def sleep(self, seconds: float) -> None:
        """Let `seconds` pass."""
        ...

    def repeat(self, step: Callable[[], None]) -> Callable[[], None]:
        """Run `step` over and over beside the caller; return a function that ends it.

        On the wall clock a thread calls it without pause (it blocks on its device for up to a few
        hundredths of a second). In lockstep it is called once for every sensor period.
        """
        ...

    def start(self, work: Callable[[], T], latency: float) -> Pending[T]:
        """Begin `work` beside the caller.

        On the wall clock it takes as long as it takes and `latency` is ignored; in lockstep the
        result is ready `latency` seconds from now, however slow this machine is.
        """
        ...


@dataclass(frozen=True, slots=True)
class Devices:
    """Camera, base and clock of a run, real or simulated.

    Attributes:
        clock: The clock of the whole run.
        camera: A camera or a recording of one.
        base: The base to drive; None without one.
        T_base_cam: Where the camera sits on the base; None where that is not known.
        recorded: Whether the camera is a recording, which ends by itself.
    """

    clock: Clock
    camera: Camera
    base: Base | None
    T_base_cam: SE3 | None
    recorded: bool
