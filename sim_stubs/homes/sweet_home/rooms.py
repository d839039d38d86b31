"""Rooms of a Sweet Home 3D home: their names, floors and ceilings."""

from __future__ import annotations

import re
from collections.abc import Collection
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import Delaunay

from sim_stubs.homes.geometry.house import Room
from sim_stubs.homes.geometry.solids import WHITE, Part
from sim_stubs.homes.sweet_home.plan import plain_name
from sim_stubs.homes.sweet_home.walls import WallFinish
from vizbot.core.home_vocabulary import class_of

OUTDOORS = re.compile(r".*(terrace|balcony|garden|patio|porch|veranda|roof|garage).*")
"""Names of places with a floor that are no part of the home."""

_NAMES = (
    (r"bedr.*|.*bedroom", "bedroom"),
    (r"bath.*|.*bathroom|wc|toilets?|shower.*", "bathroom"),
    (r"living.*|lounge", "living room"),
    (r"kitchen.*", "kitchen"),
    (r"corridor|hall|entrance.*|entry|landing", "hallway"),
    (r"laundry", "laundry room"),
    (r"kids?('s)?( room)?|child.*", "kid's room"),
)
_BY_FURNITURE = (
    (("toilet", "bathtub", "shower"), "bathroom"),
    (("bed", "single bed", "bunk bed"), "bedroom"),
    (("oven", "refrigerator", "kitchen cabinet"), "kitchen"),
    (("sofa", "tv"), "living room"),
    (("washing machine",), "laundry room"),
    (("desk",), "study"),
)
"""Labels that identify a room without a name; the first match counts."""
CELL = 0.5
"""About the longest edge of a floor's triangles [m]; light is computed at their corners."""


def room_name(name: str, furniture: Collection[str]) -> str:
    """Our name for a room, from its owner's name, else from the labels of its furniture.

    It is the truth for scoring, and never reaches the robot.
    """
    plain = plain_name(name)
    for pattern, ours in _NAMES:
        if re.fullmatch(pattern, plain):
            return ours
    if plain:
        return class_of(plain) or plain
    return next((ours for labels, ours in _BY_FURNITURE if set(labels) & set(furniture)), "room")


def level_face(room: Room, finish: WallFinish, z: float, *, upwards: bool) -> Part | None:
    """Floor or ceiling of a room at height z [m]; None where its polygon has no area."""
    points = samples(room)
    corners = Delaunay(points).simplices if len(points) > 3 else np.zeros((0, 3), np.int32)
    ahead, aside = np.moveaxis(points[corners[:, 1:]] - points[corners[:, :1]], 1, 0)
    area = ahead[:, 0] * aside[:, 1] - ahead[:, 1] * aside[:, 0]
    centres = points[corners].mean(axis=1)
    inside = np.array([room.contains(x, y) for x, y in centres], np.bool_)
    turned = np.where(((area > 0) == upwards)[:, None], corners, corners[:, ::-1])
    faces = turned[inside & (np.abs(area) > 1e-6)]
    if len(faces) == 0:
        return None
    surface = finish.surface
    return Part(
        vertices=np.column_stack([points, np.full(len(points), z)]).astype(np.float32),
        normals=np.tile(np.array([0, 0, 1 if upwards else -1], np.float32), (len(points), 1)),
        texcoords=(points / (finish.width, -finish.height)).astype(np.float32),
        faces=faces.astype(np.int32),
        rgba=np.array([*(WHITE if isinstance(surface, Path) else surface), 1.0], np.float32),
        texture=surface if isinstance(surface, Path) else None,
    )


def samples(room: Room) -> NDArray[np.float64]:
    """Points (N, 2) along the outline of a room, and a grid inside it [m]."""
    outline = []
    for start, end in zip(room.polygon, np.roll(room.polygon, -1, axis=0), strict=True):
        steps = max(1, round(float(np.linalg.norm(end - start)) / CELL * 2))
        outline.append(np.linspace(start, end, steps, endpoint=False))
    low, high = room.polygon.min(axis=0), room.polygon.max(axis=0)
    x, y = np.meshgrid(*(np.arange(a + CELL / 2, b, CELL) for a, b in zip(low, high, strict=True)))
    grid = np.column_stack([x.ravel(), y.ravel()])
    inside = np.array([room.contains(*at) for at in grid], np.bool_)
    return np.unique(np.round(np.concatenate([*outline, grid[inside]]), 4), axis=0)
