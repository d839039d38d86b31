"""A token bucket: limits a rate, and allows bursts."""

from __future__ import annotations


class TokenBucket:
    """Fills at a rate up to a burst; what is done takes from it."""

    def __init__(self, rate: float, burst: float, now: float) -> None:
        """Create a full one of `burst`, refilled by `rate` a second from `now` [s] on."""
        self._rate, self._burst = rate, burst
        self._left, self._at = burst, now

    def has(self, now: float, amount: float = 1.0) -> bool:
        """Whether so much may be taken."""
        self._left = min(self._burst, self._left + (now - self._at) * self._rate)
        self._at = now
        return self._left >= amount

    def take(self, now: float, amount: float = 1.0) -> bool:
        """Take so much, where it may be taken; whether it was."""
        may = self.has(now, amount)
        if may:
            self._left -= amount
        return may
