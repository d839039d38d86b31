"""Groups of furniture: a table with chairs, a desk with things on it, ..."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sim_stubs.homes.furnishing.arrangement import ahead, around, at_same_wall, on_top
from sim_stubs.homes.furnishing.placement import RoomLayout
from sim_stubs.homes.furniture.fitting import fitted
from sim_stubs.homes.furniture.sampler import ModelSampler
from sim_stubs.homes.geometry.house import Instance

Random = np.random.Generator

CARPET_HEIGHT = 0.012
"""Height of carpets, which the robot drives over [m]."""
OVER_WORKTOP = 1.45
"""Height of the lower edge of wall cabinets [m]."""


def dress_windows(name: str, layout: RoomLayout, sampler: ModelSampler, rng: Random) -> None:
    """Curtains beside the windows, a radiator below."""
    curtain = sampler("curtain") if rng.random() < 0.6 else None
    radiator = sampler("radiator") if rng.random() < 0.6 else None
    for window, facing in layout.windows:
        across = facing in "NS"
        start, end = (window.x0, window.x1) if across else (window.y0, window.y1)
        if curtain is not None and name != "kitchen":
            bottom = 0.06 if name in ("living room", "bedroom") else window.sill - 0.15
            strip = fitted(curtain, 0.32, 0.08, window.head + 0.12 - bottom, fill=True)
            for along in (start - 0.17, end + 0.17):
                layout.at_wall(strip, facing, along, bottom)
        if radiator is not None:
            below = fitted(radiator, end - start, 0.16, window.sill - 0.2)
            layout.at_wall(below, facing, (start + end) / 2, 0.1)


def over_worktops(layout: RoomLayout, sampler: ModelSampler, row: Sequence[Instance]) -> None:
    """Wall cabinets over the kitchen cabinets, a hood over the oven."""
    upper, hood = sampler("wall cabinet"), sampler("range hood")
    for it in row:
        width = float(it.piece.size[0])
        if it.label == "kitchen cabinet" and upper is not None:
            fit = fitted(upper, width, 0.4, fill=True)
            at_same_wall(layout, it, fit, 0.0, OVER_WORKTOP)
        if it.label == "oven" and hood is not None:
            at_same_wall(layout, it, fitted(hood, width, 0.5), 0.0, 1.55)


def dining_place(layout: RoomLayout, sampler: ModelSampler, rng: Random) -> None:
    """A table with chairs around it, in the open or else at a wall."""
    chair = sampler("chair")
    for _ in range(3):
        table = sampler("dining table")
        if table is None:
            return
        placed = layout.in_the_open(table, 0.75) or layout.against_wall(table, spot="corner")
        if placed is None:
            continue
        if chair is not None:
            around(layout, placed, chair, int(rng.integers(3, 7)))
        if rng.random() < 0.6:
            something_on(layout, sampler, placed, ("vase", "flowers", "plant"), rng)
        return


def desk_place(
    layout: RoomLayout, sampler: ModelSampler, rng: Random, on_it: Sequence[str]
) -> None:
    """A desk with a chair before it and things on it."""
    desk = at_some_wall(layout, sampler, ("desk",), front=0.75)
    if desk is None:
        return
    seat = sampler("office chair") or sampler("chair")
    if seat is not None:
        ahead(layout, desk, seat, 0.02, turned=True)
    for label in on_it[: int(rng.integers(1, 3))]:
        if (small := sampler(label)) is not None:
            on_top(layout, desk, small)


def at_some_wall(
    layout: RoomLayout,
    sampler: ModelSampler,
    labels: Sequence[str],
    *,
    front: float = 0.0,
    spot: str = "any",
) -> Instance | None:
    """A piece at a wall, of the first class that there is and that fits; each is tried twice."""
    for label in (label for label in labels for _ in range(2)):
        piece = sampler(label)
        if piece is not None:
            placed = layout.against_wall(piece, front=front, spot=spot)
            if placed is not None:
                return placed
    return None


def something_on(
    layout: RoomLayout, sampler: ModelSampler, support: Instance, labels: Sequence[str], rng: Random
) -> None:
    """One of these on a piece of furniture."""
    small = sampler(labels[int(rng.integers(len(labels)))])
    if small is not None:
        on_top(layout, support, fitted(small, 1.2, 1.2, 0.7))


def hang(
    layout: RoomLayout, sampler: ModelSampler, label: str, elevation: float, count: int = 1
) -> None:
    """Pieces on the walls, their lower edges at `elevation` [m]."""
    for _ in range(count):
        if (piece := sampler(label)) is not None:
            layout.against_wall(piece, elevation=elevation)


def lay_carpet(layout: RoomLayout, sampler: ModelSampler, rng: Random, width: float) -> None:
    """A carpet about this wide on free floor, smaller ones where there is little [m]."""
    carpet = sampler("carpet")
    if carpet is None:
        return
    for share in (1.0, 0.8, 0.6):
        w = width * share * rng.uniform(0.85, 1.1)
        d = w * float(carpet.size[1] / carpet.size[0])
        w, d = (w, d) if d <= w else (w * w / d, w)
        flat = fitted(carpet, w, d, CARPET_HEIGHT, fill=True)
        if layout.on_floor(flat) is not None:
            return
