"""Time stamps of RealSense framesets: which framesets make a frame, and whose clock they use."""

from __future__ import annotations

import logging
import math
from dataclasses import dataclass

log = logging.getLogger(__name__)

_JUMP = 1.0
"""Error of a stamp from which the camera's clock counts as reset [s]."""
_WRAP = 2**32 / 1e6
"""Time after which a camera's clock, 32 bits of microseconds, begins again [s]."""
_BURST = 5.0
"""Time within which consecutive bad framesets share a line in the log [s]."""
_GLOBAL = "global_time"
"""The SDK's name for stamps that are mapped to the host's clock."""
_FIRST = 5.0
"""Time for which a camera's stamps may be on another clock, until the SDK has compared both [s]."""


@dataclass(frozen=True, slots=True)
class Accepted:
    """A frameset that makes a frame.

    Attributes:
        stamp: Of the frame [s]; later than any before.
        offset: Added to the camera's stamp to get `stamp` [s].
        jumped: Whether the camera's clock was reset since the frame before.
    """

    stamp: float
    offset: float
    jumped: bool


class FrameStamps:
    """Drops framesets that repeat an image, are late, or pair images of different times.

    The SDK repeats an image whose partner came alone. A camera's clock may be reset, with the
    camera or because its stamps follow the host's clock: its stamps are then shifted so that those
    of the frames continue with the host's time since the start.
    """

    def __init__(self, name: str) -> None:
        """`name` of the camera, in the log."""
        self._name = name
        self._raw = -math.inf
        self._stamp = -math.inf
        self._offset = 0.0
        self._lead = -math.inf
        self._back = False
        self._bad = 0
        self._bad_at = -math.inf
        self._fault = ""

    @property
    def last(self) -> float:
        """Stamp of the last frame [s]; minus infinity before the first."""
        return self._stamp

    @property
    def fault(self) -> str:
        """Fault of the framesets since the last frame; empty if there is none."""
        return self._fault

    def reopened(self) -> None:
        """Note that the streams were reopened: the camera's clock may have been reset as well."""
        self._back = True

    def judge(
        self, color: float, depth: float, period: float, now: float | None = None
    ) -> Accepted | None:
        """The stamp of the next frame; None if the frameset is dropped.

        Args:
            color: The colour image's stamp on the camera's clock [s].
            depth: The depth image's.
            period: From one frame to the next [s].
            now: Time of reception [s]; None for a recording, where a gap may be one of its own and
                only a clock that goes back was reset.
        """
        if color == self._raw:
            self._fault = "colour stands still"  # or comes more slowly than depth, in the dark
            return None
        if abs(color - depth) > period / 2:
            apart = 1000.0 * abs(color - depth)
            self._leave_out(f"colour and depth are {apart:.0f} ms apart", now)
            return None
        stamp, jumped = color + self._offset, False
        if math.isfinite(self._stamp) and (shift := self._shift(stamp, period, now)):
            stamp, jumped = stamp + shift, True
            self._offset += shift
        if stamp <= self._stamp:
            self._leave_out("frames come out of order", now)
            return None
        self._raw, self._stamp, self._fault = color, stamp, ""
        if now is not None:
            self._lead = max(self._lead, stamp - now)
        return Accepted(stamp, self._offset, jumped)

    def _shift(self, stamp: float, period: float, now: float | None) -> float:
        """What to add to a stamp since the camera's clock was reset [s]; 0 where it was not."""
        follows = self._stamp + period
        if abs(follows - stamp - _WRAP) < _JUMP:
            log.warning("%s: its 32-bit clock began again", self._name)
            return _WRAP
        # A frame may have waited for its reader, but none comes early.
        expected = follows if now is None else max(now + self._lead, follows)
        early = 0.0 if now is None else stamp - now - self._lead
        # A single frameset from long before was delayed somewhere.
        was_back, self._back = self._back, stamp < self._stamp - _JUMP
        if not (self._back and was_back) and early <= _JUMP:
            return 0.0
        log.warning("%s: its clock jumped by %+.1f s", self._name, stamp - expected)
        return expected - stamp

    def _leave_out(self, fault: str, now: float | None) -> None:
        at = self._stamp if now is None else now
        if not self._bad or at - self._bad_at > _BURST:
            log.warning(
                "%s: %s; such frames are left out (%d so far)", self._name, fault, self._bad
            )
        self._bad, self._bad_at, self._fault = self._bad + 1, at, fault


class SharedClock:
    """Warns once when frames stay on another clock than the one shared with the IMU."""

    def __init__(self, name: str) -> None:
        """`name` of the camera, in the log."""
        self._name = name
        self._apart_since: float | None = None
        self._warned = False

    def note(self, domain: str, now: float) -> None:
        """Check a frame by the SDK's name for its clock; it was received at `now` [s]."""
        if domain == _GLOBAL:
            self._apart_since = None
        elif self._apart_since is None:
            self._apart_since = now
        elif now - self._apart_since > _FIRST and not self._warned:
            self._warned = True
            log.warning(
                "%s: its frames are stamped in %s, not in global time: images, IMU and wheels fit "
                "together less well; update its firmware, and let the kernel pass frame metadata "
                "on (librealsense2-dkms)",
                self._name,
                domain,
            )
