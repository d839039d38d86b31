"""Procedural stairs: flights, spirals and stairwells that fit a place for stairs."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import atan2, cos, floor, hypot, pi, sin

import numpy as np

from sim_stubs.homes.floor_plan.stairs import Stairs
from sim_stubs.homes.geometry.house import Instance
from sim_stubs.homes.geometry.solids import (
    Part,
    Piece,
    Surface,
    box,
    by_material,
    cylinder,
    flat_panel,
    moved_part,
    triangles,
)
from sim_stubs.homes.textures.surfaces import any_finish
from vizbot.core.geometry import planar

Random = np.random.Generator

RAIL_HEIGHT = 0.9
"""Height of a handrail above the steps or the floor [m]."""


@dataclass(frozen=True, slots=True)
class _Look:
    """Materials of stairs.

    Attributes:
        tread: Surface of what one steps on.
        body: Surface of risers and sides.
        rail: Surface of handrail and posts.
        solid: Whether a flight is a block down to the floor, else open below.
        parapet: Whether a railing is a low wall.
    """

    tread: Surface
    body: Surface
    rail: Surface
    solid: bool
    parapet: bool


def staircase(stairs: Stairs, height: float, rng: Random, held_out: bool) -> Instance:
    """Procedural stairs in their place; those upwards rise to the ceiling, at `height` [m]."""
    look = _look(rng, held_out)
    if stairs.kind == "down":
        return placed(stairs, _piece(_stairwell(stairs, look)))
    shapes = {"straight": _straight, "quarter-turn": _quarter_turn, "spiral": _spiral}
    return placed(stairs, _piece(shapes[stairs.shape](stairs, height, look, rng)))


def placed(stairs: Stairs, piece: Piece) -> Instance:
    """A piece, the catalogue's for instance, in a place for stairs.

    Stairs downwards stand on the floor below.
    """
    elevation = -_drop(stairs) if stairs.kind == "down" else 0.0
    return Instance("stairs#1", piece, stairs.x, stairs.y, stairs.yaw, elevation)


def _look(rng: Random, held_out: bool) -> _Look:
    weights = {"stair wood": 0.6, "stair stone": 0.4}
    tread = any_finish(weights, rng, held_out).surface
    body = tread if rng.random() < 0.4 else any_finish({"paint": 1.0}, rng, held_out).surface
    rail = any_finish({"stair wood": 0.5, "stair metal": 0.5}, rng, held_out).surface
    solid, parapet = rng.random(2) < (0.6, 0.3)
    return _Look(tread, body, rail, bool(solid), bool(parapet))


def _piece(parts: list[Part]) -> Piece:
    merged = by_material(parts)
    corners = triangles(merged).reshape(-1, 3)
    low, high = corners.min(axis=0), corners.max(axis=0)
    x, y = (low + high)[:2] / 2
    centred = planar(-x, -y, 0.0)
    return Piece("stairs", "stairs", high - low, tuple(moved_part(p, centred) for p in merged), "")


def _straight(stairs: Stairs, height: float, look: _Look, rng: Random) -> list[Part]:
    w, d = stairs.width, stairs.depth
    count = round(height / 0.19)
    parts = _flight((0.0, -d / 2), (w, d), (0.0, height), count, look)
    for side in stairs.open_sides:
        if side != "back":
            x = (w / 2 - 0.03) * (-1 if side == "left" else 1)
            parts += _sloping_rail((x, -d / 2, 0.0), (x, d / 2, height), look)
    return parts


def _quarter_turn(stairs: Stairs, height: float, look: _Look, rng: Random) -> list[Part]:
    """Up along one side, over a landing, then along the back."""
    w, d, flight = stairs.width, stairs.depth, 0.88
    first, second = floor((d - flight) / 0.23), floor((w - flight) / 0.23)
    riser = height / (first + second + 1)
    landing = (first + 1) * riser
    x = (flight - w) / 2
    along = _flight((x, -d / 2), (flight, d - flight), (0.0, first * riser), first, look)
    corner = box((x, (d - flight) / 2, 0), (flight, flight, landing - 0.03), look.body)
    top = box((x, (d - flight) / 2, landing - 0.03), (flight, flight, 0.03), look.tread)
    across = _flight((0, 0), (flight, w - flight), (landing, height), second, look, solid=True)
    turn = planar(flight - w / 2, (d - flight) / 2, -pi / 2)
    parts = [*along, corner, top, *(moved_part(part, turn) for part in across)]
    parts += _sloping_rail(
        (x + flight / 2 - 0.03, -d / 2, 0.0),
        (x + flight / 2 - 0.03, d / 2 - flight, first * riser),
        look,
    )
    if rng.random() < 0.5:
        return [_mirrored(part) for part in parts]
    return parts


def _spiral(stairs: Stairs, height: float, look: _Look, rng: Random) -> list[Part]:
    """Treads around a pole, each with a post that carries the handrail."""
    radius = min(stairs.width, stairs.depth) / 2
    count = round(height / 0.2)
    turn = rng.choice([-1, 1]) * 2 * pi * 1.1 / count
    inner = 0.05
    depth = 0.8 * radius * abs(turn) * 1.3
    parts = [cylinder((0, 0, 0), inner, height, look.rail)]
    tips = []
    for step in range(count):
        angle, z = -pi / 2 + turn * step, height * (step + 1) / count
        tread = box((radius / 2, 0, 0), (radius - 0.02, depth, 0.045), look.tread)
        T = planar(0.0, 0.0, angle)
        T[2, 3] = z - 0.045
        parts.append(moved_part(tread, T))
        at = (radius - 0.03) * np.array([cos(angle), sin(angle)])
        parts.append(cylinder((*at, z), 0.012, RAIL_HEIGHT, look.rail, segments=6))
        tips.append((float(at[0]), float(at[1]), z + RAIL_HEIGHT))
    for start, end in pairwise(tips):
        parts.append(_bar(start, end, 0.045, look.rail))
    return parts


def _stairwell(stairs: Stairs, look: _Look) -> list[Part]:
    """A shaft with steps down to the storey below, at whose floor z is 0."""
    w, d, drop = stairs.width, stairs.depth, _drop(stairs)
    count = _step_count(stairs)
    going, riser = d / count, drop / count
    parts: list[Part] = [flat_panel((-w / 2, -d / 2, 0), (w, 0, 0), (0, d, 0), look.tread)]
    for step in range(count):
        y, z = -d / 2 + step * going, drop - (step + 1) * riser
        parts.append(flat_panel((w / 2, y, z), (-w, 0, 0), (0, 0, riser), look.body))
        parts.append(flat_panel((-w / 2, y, z), (w, 0, 0), (0, going, 0), look.tread))
    up = (0, 0, drop)
    parts.append(flat_panel((-w / 2, -d / 2, 0), (0, d, 0), up, look.body))
    parts.append(flat_panel((w / 2, d / 2, 0), (0, -d, 0), up, look.body))
    parts.append(flat_panel((-w / 2, d / 2, 0), (w, 0, 0), up, look.body))
    inset = 0.03
    ends = {
        "left": ((inset - w / 2, -d / 2 + inset), (inset - w / 2, d / 2)),
        "right": ((w / 2 - inset, -d / 2 + inset), (w / 2 - inset, d / 2)),
        "back": ((-w / 2, d / 2 - inset), (w / 2, d / 2 - inset)),
    }
    for side in stairs.open_sides:
        start, end = ends[side]
        parts += _level_rail((*start, drop), (*end, drop), look)
    return parts


def _step_count(stairs: Stairs) -> int:
    return floor(stairs.depth / 0.25)


def _drop(stairs: Stairs) -> float:
    """Height that stairs lead down [m]."""
    return 0.19 * _step_count(stairs)


def _flight(
    start: tuple[float, float],
    size: tuple[float, float],
    heights: tuple[float, float],
    count: int,
    look: _Look,
    *,
    solid: bool | None = None,
) -> list[Part]:
    """Steps of a width and run that climb along y from the middle of their front edge."""
    (x, y), (width, run), (low, high) = start, size, heights
    going, riser = run / count, (high - low) / count
    parts = []
    block = look.solid if solid is None else solid
    for step in range(count):
        middle, top = y + (step + 0.5) * going, low + (step + 1) * riser
        if block:
            parts.append(box((x, middle, 0), (width, going, top - 0.03), look.body))
        tread = (width, going + (0.0 if block else 0.03), 0.03 if block else 0.045)
        parts.append(box((x, middle, top - tread[2]), tread, look.tread))
    if not block:
        for side in (-1, 1):
            at = x + side * (width / 2 - 0.02)
            parts.append(
                _bar((at, y, low + 0.1), (at, y + run, high - 0.1), 0.04, look.body, tall=0.2)
            )
    return parts


def _sloping_rail(
    start: tuple[float, float, float], end: tuple[float, float, float], look: _Look
) -> list[Part]:
    """Handrail and posts beside a flight along y."""
    (x, y0, z0), (_, y1, z1) = start, end
    size = (0.04, 0.04, RAIL_HEIGHT)
    posts = [
        box((x, y0 + share * (y1 - y0), z0 + share * (z1 - z0)), size, look.rail)
        for share in np.linspace(0.03, 0.97, 6)
    ]
    return [*posts, _bar((x, y0, z0 + RAIL_HEIGHT), (x, y1, z1 + RAIL_HEIGHT), 0.05, look.rail)]


def _level_rail(
    start: tuple[float, float, float], end: tuple[float, float, float], look: _Look
) -> list[Part]:
    """A railing at the edge of a stairwell: a low wall, or balusters between two bars."""
    a, b = np.array(start), np.array(end)
    (x, y, z), span = (a + b) / 2, np.abs(b - a)[:2]
    if look.parapet:
        return [box((x, y, z), (*np.maximum(span, 0.06), RAIL_HEIGHT), look.body)]
    parts = []
    for above, thick in ((0.05, 0.04), (RAIL_HEIGHT - 0.05, 0.05)):
        size = (*np.maximum(span, thick), thick)
        parts.append(box((x, y, z + above), size, look.rail))
    count = max(2, round(float(span.max()) / 0.13))
    for share in np.linspace(0.0, 1.0, count + 1):
        at = a + share * (b - a)
        parts.append(box(at, (0.03, 0.03, RAIL_HEIGHT - 0.02), look.rail))
    return parts


def _bar(
    start: tuple[float, float, float],
    end: tuple[float, float, float],
    thick: float,
    surface: Surface,
    tall: float | None = None,
) -> Part:
    """A straight bar between two points, its upper and lower faces sloping along with it."""
    dx, dy, dz = np.subtract(end, start)
    level = hypot(dx, dy)
    length, slope = hypot(level, dz), atan2(dz, level)
    height = thick if tall is None else tall
    bar = box((length / 2, 0, -height / 2), (length, thick, height), surface)
    T = planar(*start[:2], atan2(dy, dx))
    T[2, 3] = start[2]
    tilt = np.eye(4)
    tilt[0, 0] = tilt[2, 2] = cos(slope)
    tilt[2, 0], tilt[0, 2] = sin(slope), -sin(slope)
    return moved_part(bar, T @ tilt)


def _mirrored(part: Part) -> Part:
    """The part with left and right exchanged."""
    flip = np.array([-1, 1, 1], np.float32)
    return Part(
        part.vertices * flip, part.normals * flip, part.texcoords, part.faces[:, ::-1].copy(),
        part.rgba, part.texture,
    )  # fmt: skip
