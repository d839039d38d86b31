"""Any MJCF file as a world.

The floor is the lowest plane that faces upwards, else z = 0. A body named `label#n` is an instance
of that label, with all below it but other instances; so is a body, or else a geom, that is given a
label by its name. Everything else is structure. The robot is put at the site named `start`, heading
along its x axis. A site of type box named `room:NAME`, or `room:NAME#n` where there are several, is
the floor of that room. Lamps are the file's own that have a place; without any, or beside a sun,
others hang every 4 m. Geoms of group 3 and above are left out, as MuJoCo's viewer does: they are
there to collide. So are wholly transparent geoms, height fields, skins and flexes. Joints stay as
they are at first, and an infinite plane ends a bit beyond the other geoms. A texture for cubes is
shown by its mean colour. Around the rectangle of all the floor stands a plain wall: beyond it a
camera would measure nothing.
"""

from __future__ import annotations

import logging
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sim_stubs.homes.geometry.extent import require_home_sized
from sim_stubs.homes.geometry.house import House, Instance, Room
from sim_stubs.homes.geometry.occupancy_slice import FLOOR
from sim_stubs.homes.geometry.solids import Part, Piece, box, by_material, moved_part, triangles
from sim_stubs.homes.textures import canvas
from sim_stubs.world.mjcf_things import (
    GeomAppearance,
    Thing,
    Things,
    dressed,
    heading,
    named_things,
    owner,
    primitive,
    read_labels,
)
from vizbot.core.errors import ConfigError
from vizbot.core.geometry import invert, planar, transform, yaw_of
from vizbot.core.types import SE3

# isort: split
import sim_stubs.world.renderer  # noqa: F401  chooses the renderer, which MuJoCo takes on import

# isort: split
import mujoco

VISIBLE = 3
"""Groups below this are shown."""
MARGIN = 2.0
"""Distance that an infinite plane reaches beyond everything else [m]."""
LAMP_HEIGHT = 2.3
"""Height of the lamps in a file without lamps [m]."""
LAMP_SPACING = 4.0
"""Distance of these lamps [m], as in homes, which have one in each room."""
WALL = (0.1, 2.4)
"""Thickness and height of the wall around the floor [m]."""
_PLAIN = (0.75, 0.75, 0.72)
_UNSET = np.array([0.5, 0.5, 0.5, 1.0], np.float32)
"""Colour of a geom that was given none: its material's holds."""
_PRIMITIVES: Mapping[int, str] = {
    int(kind): str(kind.name).removeprefix("mjGEOM_").lower()
    for kind in (
        mujoco.mjtGeom.mjGEOM_PLANE,
        mujoco.mjtGeom.mjGEOM_SPHERE,
        mujoco.mjtGeom.mjGEOM_CAPSULE,
        mujoco.mjtGeom.mjGEOM_ELLIPSOID,
        mujoco.mjtGeom.mjGEOM_CYLINDER,
        mujoco.mjtGeom.mjGEOM_BOX,
    )
}

_log = logging.getLogger(__name__)


def read_mjcf(
    path: Path, labels: Path | None = None, start: tuple[float, float, float] | None = None
) -> House:
    """The world in an MJCF file.

    Args:
        path: The file.
        labels: File with labels of bodies and geoms by their names.
        start: x, y [m], yaw [rad] of the robot in the file's frame; as a default its site `start`.

    Raises:
        ConfigError: MuJoCo cannot load it, it shows nothing, it is too large, it does not say where
            the robot is, or what a label is for is not in it or shows nothing.
    """
    try:
        model = mujoco.MjModel.from_xml_path(str(path))
    except (ValueError, mujoco.FatalError) as error:
        reason = " ".join(str(error).split())
        raise ConfigError(f"world {path} cannot be loaded ({reason}); correct the file") from error
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    lift = _lift(model, data)
    for places in (data.xpos, data.geom_xpos, data.site_xpos, data.light_xpos):
        places[:, 2] += lift
    sites = {model.site(i).name: model.site(i) for i in range(model.nsite)}
    rooms = tuple(
        _room(match[1], _pose(data.site(name)), site.size)
        for name, site in sites.items()
        if (match := re.fullmatch(r"room:([^#]+)(#.*)?", name))
    )
    places = [np.pad(room.polygon, ((0, 0), (0, 1))) for room in rooms]
    if start is None:
        if "start" not in sites:
            raise ConfigError(
                f"world {path} does not say where the robot is; give --start X,Y,YAW_DEGREES, or"
                " add a site named start"
            )
        T = _pose(data.site("start"))
        start = float(T[0, 3]), float(T[1, 3]), yaw_of(T)
        places.append(T[None, :3, 3])
    given = {} if labels is None else read_labels(labels)
    things = named_things(model, given, f"world {path}")
    shown = _shown(model)
    try:
        require_home_sized(np.concatenate([*places, _bounds(model, data, shown)]))
    except ValueError as error:
        raise ConfigError(f"world {path}: {error}") from error
    parts = _parts(model, data, things, shown)
    for thing in (*things.bodies.values(), *things.geoms.values()):
        if thing not in parts and thing.name in given:
            raise ConfigError(
                f"{thing.name!r} of labels {labels} shows nothing in world {path}; take a part of"
                " it that does"
            )
    everything = triangles([part for shapes in parts.values() for part in shapes])
    if len(everything) == 0:
        raise ConfigError(f"world {path} shows nothing; add geoms of groups below {VISIBLE}")
    return House(
        rooms=rooms,
        structure=by_material([*parts.get(None, []), *walls_around(everything)]),
        instances=tuple(
            instance_of(thing, heading(model, data, thing), shapes)
            for thing, shapes in parts.items()
            if thing is not None
        ),
        lights=_lights(model, data, everything),
        start=start,
    )


def walls_around(everything: NDArray[np.float64]) -> list[Part]:
    """Walls on the four sides of the floor among triangles (N, 3, 3)."""
    heights = everything[..., 2]
    floor = everything[((heights > FLOOR[0]) & (heights < FLOOR[1])).all(axis=1)]
    if not len(floor):
        return []
    (x0, y0), (x1, y1) = floor[..., :2].min(axis=(0, 1)), floor[..., :2].max(axis=(0, 1))
    x, y, thick = (x0 + x1) / 2, (y0 + y1) / 2, WALL[0]
    across, along = (x1 - x0 + 2 * thick, *WALL), (thick, y1 - y0, WALL[1])
    return [
        box((x, y0 - thick / 2, 0.0), across, _PLAIN),
        box((x, y1 + thick / 2, 0.0), across, _PLAIN),
        box((x0 - thick / 2, y, 0.0), along, _PLAIN),
        box((x1 + thick / 2, y, 0.0), along, _PLAIN),
    ]


def _lift(model: mujoco.MjModel, data: mujoco.MjData) -> float:
    """Height that brings the floor to z = 0 [m]."""
    planes = np.flatnonzero(model.geom_type == mujoco.mjtGeom.mjGEOM_PLANE)
    upwards = [geom for geom in planes if data.geom_xmat[geom, 8] > 0.999]
    return -min((float(data.geom_xpos[geom, 2]) for geom in upwards), default=0.0)


def _shown(model: mujoco.MjModel) -> list[int]:
    """Geoms that are shown, infinite planes last."""
    geoms = [
        geom
        for geom in range(model.ngeom)
        if model.geom_group[geom] < VISIBLE and _rgba(model, geom)[3] > 0.0
    ]
    return sorted(geoms, key=lambda geom: _is_infinite(model, geom))


def _bounds(
    model: mujoco.MjModel, data: mujoco.MjData, geoms: Sequence[int]
) -> NDArray[np.float64]:
    """Corners (N, 3) of the boxes around geoms in the world [m]; infinite planes have none."""
    corners = [np.zeros((0, 3))]
    signs = np.array([*product((-1.0, 1.0), repeat=3)])
    for geom in geoms:
        middle, half = np.split(model.geom_aabb[geom], 2)
        if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_PLANE:
            middle, half = np.zeros(3), model.geom_size[geom] * (1.0, 1.0, 0.0)
        if not _is_infinite(model, geom):
            corners.append(transform(_pose(data.geom(geom)), middle + signs * half))
    return np.concatenate(corners)


def _parts(
    model: mujoco.MjModel, data: mujoco.MjData, things: Things, geoms: Sequence[int]
) -> dict[Thing | None, list[Part]]:
    """Geoms in the world, by the instance that they belong to; None: none."""
    parts: dict[Thing | None, list[Part]] = {}
    corners = np.zeros((1, 3))
    pictures = [_picture(model, texture) for texture in range(model.ntex)]
    for geom in geoms:
        T, look = _pose(data.geom(geom)), _look(model, geom, pictures)
        if _is_infinite(model, geom):
            part: Part | None = _plane_below(transform(invert(T), corners), look)
        else:
            part = _shape(model, geom, look)
        if part is None:
            _log.warning("geom %d is of a kind that is not shown", geom)
            continue
        placed = moved_part(part, T)
        if not _is_infinite(model, geom):
            corners = np.concatenate([corners, placed.vertices])
        parts.setdefault(owner(model, geom, things), []).append(placed)
    return parts


def _is_infinite(model: mujoco.MjModel, geom: int) -> bool:
    is_plane = model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_PLANE
    return bool(is_plane and not model.geom_size[geom, :2].all())


def _plane_below(corners: NDArray[np.float64], look: GeomAppearance) -> Part | None:
    """A plane that reaches a bit beyond corners (N, 3) in its own frame."""
    low, high = corners[:, :2].min(axis=0) - MARGIN, corners[:, :2].max(axis=0) + MARGIN
    plane = primitive("plane", np.array([*(high - low) / 2, 0.0]), replace(look, uniform=True))
    T = np.eye(4)
    T[:2, 3] = (low + high) / 2
    return None if plane is None else moved_part(plane, T)


def _shape(model: mujoco.MjModel, geom: int, look: GeomAppearance) -> Part | None:
    """A geom in its own frame; None for what is not shown."""
    kind, mesh = int(model.geom_type[geom]), int(model.geom_dataid[geom])
    if kind in (mujoco.mjtGeom.mjGEOM_MESH, mujoco.mjtGeom.mjGEOM_SDF) and mesh >= 0:
        return dressed(_mesh(model, mesh), look)
    return primitive(_PRIMITIVES.get(kind, ""), model.geom_size[geom], look)


def instance_of(thing: Thing, yaw: float, parts: list[Part], attribution: str = "") -> Instance:
    """The parts, given in the world, as an instance with this heading [rad]."""
    upright = [moved_part(part, planar(0.0, 0.0, -yaw)) for part in parts]
    corners = triangles(upright).reshape(-1, 3)
    low, high = corners.min(axis=0), corners.max(axis=0)
    T_piece_upright = np.eye(4)
    T_piece_upright[:3, 3] = -(low[0] + high[0]) / 2, -(low[1] + high[1]) / 2, -low[2]
    own = tuple(moved_part(part, T_piece_upright) for part in by_material(upright))
    T = planar(0.0, 0.0, yaw) @ invert(T_piece_upright)
    piece = Piece(thing.label, thing.name, high - low, own, attribution)
    return Instance(thing.name, piece, float(T[0, 3]), float(T[1, 3]), yaw, float(low[2]))


def _mesh(model: mujoco.MjModel, mesh: int) -> Part:
    """A mesh in the frame of its geoms; points, normals and texture have indices of their own."""
    first, count = model.mesh_faceadr[mesh], model.mesh_facenum[mesh]
    faces = slice(first, first + count)
    points = model.mesh_vert[model.mesh_vertadr[mesh] + model.mesh_face[faces]]
    normals = model.mesh_normal[model.mesh_normaladr[mesh] + model.mesh_facenormal[faces]]
    texcoords = np.zeros((count, 3, 2), np.float32)
    if model.mesh_texcoordadr[mesh] >= 0:
        texcoords = model.mesh_texcoord[
            model.mesh_texcoordadr[mesh] + model.mesh_facetexcoord[faces]
        ]
    rows = np.concatenate([points, normals, texcoords], axis=2).reshape(-1, 8)
    unique, inverse = np.unique(rows, axis=0, return_inverse=True)
    return Part(
        vertices=unique[:, :3],
        normals=unique[:, 3:6],
        texcoords=unique[:, 6:],
        faces=inverse.reshape(-1, 3).astype(np.int32),
        rgba=_UNSET,
        texture=None,
    )


def _look(model: mujoco.MjModel, geom: int, pictures: list[Path | None]) -> GeomAppearance:
    material = int(model.geom_matid[geom])
    rgba = _rgba(model, geom)
    if material < 0:
        return GeomAppearance(rgba)
    texture = int(model.mat_texid[material, mujoco.mjtTextureRole.mjTEXROLE_RGB])
    picture = None if texture < 0 else pictures[texture]
    if texture >= 0 and picture is None:
        rgba = rgba * np.array([*_pixels(model, texture).mean(axis=(0, 1)) / 255.0, 1.0])
    return GeomAppearance(
        rgba=rgba,
        texture=picture,
        repeat=tuple(model.mat_texrepeat[material]),
        uniform=bool(model.mat_texuniform[material]),
    )


def _rgba(model: mujoco.MjModel, geom: int) -> NDArray[np.float64]:
    """(4,) colour of a geom, or else of its material."""
    own, material = model.geom_rgba[geom], int(model.geom_matid[geom])
    unset = material >= 0 and np.array_equal(own, _UNSET)
    return np.asarray(model.mat_rgba[material] if unset else own)


def _picture(model: mujoco.MjModel, texture: int) -> Path | None:
    """A flat texture as a PNG file; None for those of cubes and skies."""
    if model.tex_type[texture] != mujoco.mjtTexture.mjTEXTURE_2D:
        return None
    return canvas.saved(_pixels(model, texture) / 255.0)


def _pixels(model: mujoco.MjModel, texture: int) -> NDArray[np.uint8]:
    """Pixels (H, W, 3) of a texture; the faces of a cube are below one another."""
    height, width = int(model.tex_height[texture]), int(model.tex_width[texture])
    channels, first = int(model.tex_nchannel[texture]), int(model.tex_adr[texture])
    pixels = model.tex_data[first : first + height * width * channels]
    image = pixels.reshape(height, width, channels)[..., :3]
    return np.broadcast_to(image, (height, width, 3))


def _pose(placed: Any) -> SE3:
    """Pose of a geom, a body or a site in the world."""
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = placed.xmat.reshape(3, 3), placed.xpos
    return T


def _room(name: str, T_world_site: SE3, size: NDArray[np.float64]) -> Room:
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) * size
    return Room(name, transform(T_world_site, corners)[:, :2])


def _lights(
    model: mujoco.MjModel, data: mujoco.MjData, everything: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(N, 3) lamps with a place; those of the sun's kind have none, and many stand for them."""
    placed = model.light_type != mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
    lamps = np.array(data.light_xpos[placed])
    if len(lamps) and placed.all():
        return lamps
    return np.concatenate([lamps, lamps_in(everything)])


def lamps_in(everything: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N, 3) lamps all over triangles (N, 3, 3)."""
    low, high = everything.min(axis=(0, 1))[:2], everything.max(axis=(0, 1))[:2]
    counts = np.maximum(np.round((high - low) / LAMP_SPACING), 1).astype(int)
    x, y = (low[i] + (high - low)[i] * (np.arange(n) + 0.5) / n for i, n in enumerate(counts))
    return np.array([(at_x, at_y, LAMP_HEIGHT) for at_x in x for at_y in y])
