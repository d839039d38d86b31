"""What is true in a house, wherever one looks from: what its pieces are, and how they stand."""

from __future__ import annotations

from dataclasses import dataclass

from sim_stubs.house import House


@dataclass(frozen=True, slots=True, eq=False)
class HouseFacts:
    """The facts that captions tell."""

    house: House

    @staticmethod
    def of(house: House) -> HouseFacts:
        """Work out the facts."""
        return HouseFacts(house)
