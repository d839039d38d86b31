"""Spatial relations of pieces of furniture: on, next to, in front of, above."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from sim_stubs.homes.geometry.house import House
from vizbot.core.home_vocabulary import kinds

Relation = Literal["on", "next to", "in front of", "above"]

BESIDE = 0.5
"""Gap below which things stand next to each other [m]."""
AROUND = 1.2
"""Gap below which it is disputable whether things stand next to each other [m]."""
TUCKED = -0.35
"""Negative gap of a chair that is pushed under its table [m]."""
BEFORE = 1.0
"""Largest distance of a thing in front of another [m]."""
HANGING = 1.8
"""Largest distance of a thing that hangs above another [m]."""
TOUCHING = 0.08
"""Largest gap below a thing that stands on another [m]."""


def related(house: House) -> Iterator[tuple[int, int, Relation, bool]]:
    """Pairs i, j of instances, the relation of i to j, and whether it is certain or disputable."""
    if not house.instances:
        return
    plan = _Plan.from_house(house)
    names = {it.name: i for i, it in enumerate(house.instances)}
    stands_on = {(i, names[it.on]) for i, it in enumerate(house.instances) if it.on in names}
    near = (plan.gap < BEFORE + AROUND) & plan.same_room & ~np.eye(len(names), dtype=bool)
    for i, j in np.argwhere(near):
        a, b = int(i), int(j)
        gap, rise = float(plan.gap[a, b]), float(plan.low[a] - plan.high[b])
        x, y = plan.local[a, b]
        w, d = plan.half[b]
        over = abs(x) < w and abs(y) < d
        if plan.flat[b]:
            if gap < 0 and plan.low[a] < 0.1 and not plan.flat[a]:
                yield a, b, "on", bool(over)
        elif (a, b) in stands_on or (over and abs(rise) < TOUCHING and plan.low[a] > TOUCHING):
            yield a, b, "on", True
            continue
        level = min(plan.high[a], plan.high[b]) - max(plan.low[a], plan.low[b]) > 0.05
        if (
            not (plan.flat[a] or plan.flat[b])
            and a < b
            and gap < AROUND
            and (b, a) not in stands_on
        ):
            yield a, b, "next to", bool(level and TUCKED < gap < BESIDE)
        if rise > TOUCHING and gap < 0.8:
            yield a, b, "above", bool(gap < 0.15 and abs(x) < w + 0.2 and rise < HANGING)
        elif not plan.flat[b] and gap < BEFORE + 0.5:
            yield (
                a,
                b,
                "in front of",
                bool(y < -d and abs(x) < w and gap < BEFORE and level | plan.flat[a]),
            )


@dataclass(frozen=True, slots=True, eq=False)
class _Plan:
    """Positions and sizes of N pieces.

    Attributes:
        low: (N,) heights of their undersides [m].
        high: (N,) heights of their tops [m].
        half: (N, 2) half of their width and depth [m].
        local: (N, N, 2) middle of i as j sees it: x to its left, -y before its front [m].
        gap: (N, N) between two footprints [m]; below 0 they overlap by that much.
        flat: (N,) whether it is a carpet.
        same_room: (N, N) whether no wall is between them.
    """

    low: NDArray[np.float64]
    high: NDArray[np.float64]
    half: NDArray[np.float64]
    local: NDArray[np.float64]
    gap: NDArray[np.float64]
    flat: NDArray[np.bool_]
    same_room: NDArray[np.bool_]

    @staticmethod
    def from_house(house: House) -> _Plan:
        pieces = house.instances
        low = np.array([it.elevation for it in pieces])
        yaw = np.array([it.yaw for it in pieces])
        centre = np.array([(it.x, it.y) for it in pieces])
        half = np.array([it.piece.size[:2] for it in pieces]) / 2
        feet = np.array([it.footprint for it in pieces])
        axes = np.stack([np.stack([np.cos(yaw), np.sin(yaw)], -1),
                         np.stack([-np.sin(yaw), np.cos(yaw)], -1)], 1)  # fmt: skip
        # Corners of i along the axes of j: i, corner, j, axis.
        along = np.einsum("icx,jax->icja", feet, axes) - np.einsum("jx,jax->ja", centre, axes)
        apart = np.maximum(along.min(1) - half, -half - along.max(1))
        gap = np.where((apart > 0).all(-1), np.hypot(apart[..., 0], apart[..., 1]), apart.max(-1))
        rooms = [house.room_at(it.x, it.y) for it in pieces]
        number = np.array([-1 if room is None else house.rooms.index(room) for room in rooms])
        return _Plan(
            low=low,
            high=low + np.array([it.piece.size[2] for it in pieces]),
            half=half,
            local=np.einsum("ijx,jax->ija", centre[:, None] - centre, axes),
            gap=np.maximum(gap, gap.T),
            flat=np.array(["carpet" in kinds(it.label) for it in pieces]),
            same_room=(number[:, None] == number) | (number[:, None] < 0) | (number < 0),
        )
