"""What is an instance in an MJCF file: bodies and geoms, by their own names or by given labels.

Source of the primitive geoms' meshes: MuJoCo documentation, "XML reference", body/geom (`type`,
`size`) and asset/material (`texrepeat`, `texuniform`).
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sim_stubs.homes.geometry.solids import (
    WHITE,
    Part,
    Surface,
    box,
    cushion,
    cylinder,
    flat_panel,
    joined,
)
from vizbot.core.errors import ConfigError
from vizbot.core.files import read_regular
from vizbot.core.geometry import yaw_of

if TYPE_CHECKING:
    import mujoco  # which OpenGL it takes is chosen by `renderer`, on import

STEPS = 12
"""Number of faces of a round geom between its poles."""
_LABELLED = re.compile(r"(.+)#\w+")
_LARGEST = 1024 * 1024
"""Size of a file of labels that is read [bytes]."""


@dataclass(frozen=True, slots=True, eq=False)
class GeomAppearance:
    """Appearance of a geom.

    Attributes:
        rgba: (4,) in [0, 1].
        texture: PNG file, or None.
        repeat: (2,) copies of the texture, over each face or over a metre.
        uniform: Whether `repeat` counts copies over a metre.
    """

    rgba: NDArray[np.float64]
    texture: Path | None = None
    repeat: tuple[float, float] = (1.0, 1.0)
    uniform: bool = False


def dressed(part: Part, look: GeomAppearance) -> Part:
    """The part in these colours."""
    texcoords = part.texcoords * np.asarray(look.repeat, np.float32)
    rgba = look.rgba.astype(np.float32)
    return replace(part, rgba=rgba, texture=look.texture, texcoords=texcoords)


def primitive(kind: str, size: NDArray[np.float64], look: GeomAppearance) -> Part | None:
    """A geom around its origin; None for a kind that is no primitive.

    Args:
        kind: "plane", "sphere", "capsule", "ellipsoid", "cylinder" or "box".
        size: (3,) as MuJoCo has it: half extents or radius and half length [m].
        look: Appearance of the geom.
    """
    shape = _shape(kind, size, WHITE, 1.0 if look.uniform else 0.0)
    return None if shape is None else dressed(shape, look)


def _shape(kind: str, size: NDArray[np.float64], white: Surface, tile: float) -> Part | None:
    a, b, c = (float(value) for value in size)
    match kind:
        case "plane":
            return flat_panel((-a, -b, 0.0), (2 * a, 0, 0), (0, 2 * b, 0), white, tile)
        case "box":
            return box((0.0, 0.0, -c), (2 * a, 2 * b, 2 * c), white, tile)
        case "cylinder":
            return cylinder((0.0, 0.0, -b), a, 2 * b, white, segments=2 * STEPS)
        case "sphere":
            return _ellipsoid(a, a, a, 0.0)
        case "ellipsoid":
            return _ellipsoid(a, b, c, 0.0)
        case "capsule":
            middle = cylinder((0.0, 0.0, -b), a, 2 * b, white, segments=2 * STEPS)
            return joined([middle, _ellipsoid(a, a, a, -b), _ellipsoid(a, a, a, b)])
    return None


def _ellipsoid(a: float, b: float, c: float, z: float) -> Part:
    """Half axes; z of its centre [m]."""
    return cushion((0.0, 0.0, z - c), (2 * a, 2 * b, 2 * c), WHITE, 1.0, STEPS)


def read_labels(path: Path) -> dict[str, str]:
    """The labels in a file by the name of the body or geom, in lower case with single spaces.

    Raises:
        ConfigError: it cannot be read, or a label is empty or no text.
    """
    try:
        table = tomllib.loads(read_regular(path, _LARGEST).decode("utf-8-sig"))
    except (OSError, ValueError, RecursionError) as error:
        reason = " ".join(str(error).split())
        raise ConfigError(
            f'labels {path} cannot be read ({reason}); give lines like kettle = "yellow kettle"'
        ) from error
    labels = {}
    for name, label in table.items():
        words = label.casefold().split() if isinstance(label, str) else []
        if not words:
            raise ConfigError(
                f'labels {path}: the label {label!r} of {name!r} is no text; give "yellow kettle"'
            )
        labels[name] = " ".join(words)
    return labels


@dataclass(frozen=True, slots=True)
class Thing:
    """A body or geom that is an instance."""

    name: str
    label: str


@dataclass(frozen=True, slots=True)
class Things:
    """The instances of a file, by the numbers of their bodies and geoms."""

    bodies: Mapping[int, Thing]
    geoms: Mapping[int, Thing]


def named_things(model: mujoco.MjModel, labels: Mapping[str, str], world: str) -> Things:
    """What is an instance: bodies named `label#n`, and what `labels` names, bodies before geoms.

    Raises:
        ConfigError: no body or geom has one of the names.
    """
    bodies = {model.body(i).name: i for i in range(1, model.nbody)}
    geoms = {model.geom(i).name: i for i in range(model.ngeom)}
    names = sorted({*bodies, *geoms} - {""})
    of_bodies = {
        body: Thing(name, match[1])
        for name, body in bodies.items()
        if (match := _LABELLED.fullmatch(name))
    }
    of_geoms = {}
    for name, label in labels.items():
        require_named(name, names, world, "body or geom")
        if name in bodies:
            of_bodies[bodies[name]] = Thing(name, label)
        else:
            of_geoms[geoms[name]] = Thing(name, label)
    return Things(of_bodies, of_geoms)


def require_named(name: str, names: Sequence[str], world: str, kind: str) -> None:
    """Refuse a label for what a world has not.

    Raises:
        ConfigError: None of its `names` is this one.
    """
    if name not in names:
        near = get_close_matches(name, names) or names[:10]
        raise ConfigError(
            f"{world} has no {kind} {name!r}; take one that it has, as "
            + (", ".join(near) or "it has no names at all")
        )


def owner(model: mujoco.MjModel, geom: int, things: Things) -> Thing | None:
    """The instance that a geom belongs to: itself, or the nearest body upwards; None if none is."""
    if geom in things.geoms:
        return things.geoms[geom]
    body = int(model.geom_bodyid[geom])
    while body > 0 and body not in things.bodies:
        body = int(model.body_parentid[body])
    return things.bodies.get(body)


def heading(model: mujoco.MjModel, data: mujoco.MjData, thing: Thing) -> float:
    """Yaw of a body, or of the body of a geom [rad]."""
    import mujoco

    body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, thing.name)
    if body < 0:
        body = int(model.geom(thing.name).bodyid[0])
    return yaw_of(data.xmat[body].reshape(3, 3))
