"""Placement relative to other furniture: beside, before, around and on top of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sim_stubs.homes.furnishing.placement import GAP, RoomLayout
from sim_stubs.homes.geometry.bounding_block import (
    OPPOSITE,
    Block,
    at_wall,
    beyond,
    centred,
    facing_of,
)
from sim_stubs.homes.geometry.house import Instance
from sim_stubs.homes.geometry.solids import Piece, triangles


def at_same_wall(
    layout: RoomLayout, neighbour: Instance, piece: Piece, shift: float, elevation: float = 0.0
) -> Instance | None:
    """A piece at the wall where `neighbour` stands, its middle `shift` [m] from the neighbour's."""
    facing, (x, y) = facing_of(neighbour), Block.around(neighbour).centre
    return layout.at_wall(piece, facing, (x if facing in "NS" else y) + shift, elevation)


def beside(layout: RoomLayout, neighbour: Instance, piece: Piece) -> Instance | None:
    """A piece at the wall of `neighbour`, right next to it on either side."""
    reach = float(neighbour.piece.size[0] + piece.size[0]) / 2 + 0.04
    for side in layout.rng.permutation([-1.0, 1.0]):
        if placed := at_same_wall(layout, neighbour, piece, float(side) * reach):
            return placed
    return None


def opposite(
    layout: RoomLayout, neighbour: Instance, piece: Piece, front: float = 0.0
) -> Instance | None:
    """A piece at the opposite wall, facing `neighbour` as straight as possible."""
    facing = OPPOSITE[facing_of(neighbour)]
    x, y = Block.around(neighbour).centre
    straight = x if facing in "NS" else y
    for shift in sorted(np.arange(-0.8, 0.81, 0.1), key=abs):
        block = at_wall(layout.room, facing, straight + float(shift), piece.size, GAP, 0.0)
        if layout.fits([block], facing, front):
            return layout.put(piece, block, facing, front)
    return None


def ahead(
    layout: RoomLayout, neighbour: Instance, piece: Piece, gap: float, *, turned: bool = False
) -> Instance | None:
    """A piece in front of `neighbour`, `gap` [m] away; with `turned`, facing it."""
    facing = facing_of(neighbour)
    before = Block.around(neighbour)
    for shift in (0.0, 0.15, -0.15, 0.3, -0.3):
        block = beyond(before, facing, piece.size, gap, shift)
        if layout.fits([block], facing, 0.0, kept=False):
            return layout.put(piece, block, OPPOSITE[facing] if turned else facing)
    return None


def around(layout: RoomLayout, table: Instance, chair: Piece, count: int) -> list[Instance]:
    """Chairs drawn up to a table, `count` at most: first at its long sides."""
    block = Block.around(table)
    long = "NS" if block.x1 - block.x0 >= block.y1 - block.y0 else "EW"
    seats: list[tuple[str, float]] = []
    for side in (*long, *("EW" if long == "NS" else "NS")):
        length = block.x1 - block.x0 if side in "NS" else block.y1 - block.y0
        seats_here = max(1, int(length / (chair.size[0] + 0.12))) if length > 0.6 else 1
        seats_here = min(seats_here, 3) if side in long else 1
        offsets = (np.arange(seats_here) + 0.5) / seats_here * length - length / 2
        seats += [(side, float(offset)) for offset in offsets]
    placed: list[Instance] = []
    for side, offset in seats:
        if len(placed) == count:
            break
        at = beyond(block, side, chair.size, 0.02, offset)
        if layout.fits([at], side, 0.0):
            placed.append(layout.put(chair, at, OPPOSITE[side]))
    return placed


def on_top(
    layout: RoomLayout, support: Instance, piece: Piece, *, spot: str = "any", uneven: float = 0.015
) -> Instance | None:
    """A piece on an even spot of `support`, "any" or the "middle", facing as it does.

    The surface below may rise and fall by `uneven` [m] at most.
    """
    facing, under = facing_of(support), Block.around(support)
    shape = centred(0.0, 0.0, piece.size, facing)
    slack = np.array([under.x1 - under.x0, under.y1 - under.y0]) / 2 - (shape.x1, shape.y1)
    if (slack < -0.02).any():
        return None
    surface = triangles(support.parts())
    for k in range(20):
        spread = 0.0 if spot == "middle" and k == 0 else 1.0
        shift = layout.rng.uniform(-1, 1, 2) * slack.clip(0.0) * 0.95 * spread
        x, y = np.array(under.centre) + shift
        block = centred(float(x), float(y), piece.size, facing)
        heights = tops(surface, block)
        if not np.isfinite(heights).all() or np.ptp(heights) > uneven:
            continue
        z = float(heights.max()) - (0.6 * float(np.ptp(heights)) if uneven > 0.05 else 0.0)
        block = replace(block, z0=z, z1=z + float(piece.size[2]))
        others = [it for it in layout.instances if it is not support]
        if any(block.overlaps(Block.around(it)) for it in others):
            continue
        return layout.put(piece, block, facing, on=support.name)
    return None


def tops(surface: NDArray[np.float64], block: Block) -> NDArray[np.float64]:
    """Height of the highest surface below 9 points spread over a block; -inf beside it.

    Args:
        surface: (T, 3, 3) triangles [m].
        block: Block of the piece to place.
    """
    xs = np.linspace(block.x0, block.x1, 5)[1:-1]
    ys = np.linspace(block.y0, block.y1, 5)[1:-1]
    points = np.stack(np.meshgrid(xs, ys), axis=-1).reshape(-1, 1, 2)
    a, b, c = (surface[:, k, :2] for k in range(3))
    twice = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    level = np.abs(twice) > 1e-9
    a, b, c, twice, z = a[level], b[level], c[level], twice[level], surface[level, :, 2]

    def share(p: NDArray[np.float64], q: NDArray[np.float64]) -> NDArray[np.float64]:
        to_p, to_q = p - points, q - points
        return np.asarray((to_p[..., 0] * to_q[..., 1] - to_p[..., 1] * to_q[..., 0]) / twice)

    shares = np.stack([share(b, c), share(c, a), share(a, b)], axis=-1)
    hit = (shares >= -1e-6).all(axis=-1)
    return np.asarray(
        np.where(hit, (shares * z).sum(axis=-1), -np.inf).max(axis=1, initial=-np.inf)
    )
