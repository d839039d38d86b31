"""Models of a Sweet Home 3D home as the home shows them: recoloured, mirrored, doors standing open.

Sweet Home 3D knows parts of a model by the names of their groups (developer's guide, "Creating 3D
models"): panes of glass, and leaves that turn on hinges or slide on rails.
"""

from __future__ import annotations

import io
import logging
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from importlib.resources.abc import Traversable
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from sim_stubs.homes.furniture import cache as piece_cache
from sim_stubs.homes.furniture.conversion import convert
from sim_stubs.homes.furniture.wavefront import Material, read_mtl
from sim_stubs.homes.geometry.solids import Part, Piece, box, flat_panel, moved_part, triangles
from sim_stubs.homes.sweet_home.materials import DEFAULT_MATERIALS
from sim_stubs.homes.sweet_home.plan import HomeFile, ListedPiece, SurfaceStyle
from sim_stubs.homes.textures.surfaces import finish
from vizbot.core.errors import ConfigError

MAX_TRIANGLES = 3000
MAX_TEXTURE = 256
GLASS = 0.5
"""Opacity of panes."""
STAND_IN = (0.70, 0.68, 0.65)
"""Colour of the box in the place of a model that cannot be read."""
Opening = Literal["window", "closed door", "open door"]
_LEAF, _PANE = "sweethome3d_opening_on_", "sweethome3d_window_pane"
_HIDDEN = Material((1.0, 1.0, 1.0, 0.0))
_log = logging.getLogger(__name__)


def triangulated(corners: NDArray[np.float64]) -> list[tuple[int, int, int]]:
    """Triangles of a polygon without holes, as indices of its corners, in its winding.

    Ears are cut off one after another (Meisters, "Polygons have ears", 1975). What is left of a
    polygon that crosses itself becomes a fan.

    Args:
        corners: (N, 3) in order, about in one plane.
    """
    flat = _flattened(corners)
    left = list(range(len(corners)))
    triangles = []
    while len(left) > 3:
        ear = next((i for i in range(len(left)) if _is_ear(flat, left, i)), None)
        if ear is None:
            break
        triangles.append((left[ear - 1], left[ear], left[(ear + 1) % len(left)]))
        del left[ear]
    return triangles + [(left[0], b, c) for b, c in pairwise(left[1:])]


def _flattened(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N, 2) the polygon in its plane, counter-clockwise."""
    # Newell's normal also holds for a polygon that is not quite flat.
    normal = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)
    away = int(np.argmax(np.abs(normal)))
    kept = [(1, 2), (2, 0), (0, 1)][away]
    flat = corners[:, kept]
    return flat if normal[away] >= 0 else flat * (1.0, -1.0)


def _is_ear(flat: NDArray[np.float64], left: list[int], i: int) -> bool:
    """Whether the corner juts out and its triangle holds no other one."""
    a, b, c = flat[left[i - 1]], flat[left[i]], flat[left[(i + 1) % len(left)]]
    if _twice_area(a, b, c) <= 0.0:
        return False
    others = flat[[k for k in left if k not in (left[i - 1], left[i], left[(i + 1) % len(left)])]]
    inside = (
        (_twice_area(a, b, others) >= 0.0)
        & (_twice_area(b, c, others) >= 0.0)
        & (_twice_area(c, a, others) >= 0.0)
    )
    # A polygon with a slit comes to the same corner twice.
    at_corner = (others[:, None] == np.stack([a, b, c])).all(axis=2).any(axis=1)
    return not bool((inside & ~at_corner).any())


def _twice_area(
    a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Twice the area of the triangle a, b, c (..., 2); positive if it is counter-clockwise."""
    return np.asarray(
        (b[..., 0] - a[..., 0]) * (c[..., 1] - a[..., 1])
        - (b[..., 1] - a[..., 1]) * (c[..., 0] - a[..., 0])
    )


def load_listed(
    home: HomeFile, item: ListedPiece, label: str, licence: str, opening: Opening | None = None
) -> Piece:
    """The piece that `item` lists, in its own frame.

    Args:
        home: The file with its model.
        item: The piece to load.
        label: Class given to the piece.
        licence: Licence of the home.
        opening: For doors and windows. An open door is its frame alone, nothing where the model
            does not tell the leaf from the frame; a window shows outdoors instead of its panes.

    Returns:
        A box of its size and colour, and a warning, where the model cannot be read.
    """
    try:
        parts = _converted(home, item, opening)
    except (ConfigError, KeyError, OSError) as error:
        _log.warning("model of %r becomes a box: %s", item.name, error)
        colour = item.look.rgb if item.look is not None and item.look.rgb else STAND_IN
        parts = () if opening == "open door" else (box((0.0, 0.0, 0.0), item.size, colour),)
    if item.mirrored:
        parts = tuple(_mirrored(part) for part in parts)
    if opening == "window":
        parts = (*parts, *_view(item))
    parts = _tilted(parts, item.tilt)
    corners = triangles(parts).reshape(-1, 3)
    size = np.ptp(corners, axis=0) if len(corners) else np.array(item.size)
    author = f"{item.name} ({item.catalogue_id}) by {item.creator}, {licence}"
    return Piece(label, item.name, size, parts, author)


def _converted(home: HomeFile, item: ListedPiece, opening: Opening | None) -> tuple[Part, ...]:
    model = home.archive.getinfo(item.model)
    has_leaf = _LEAF.encode() in home.archive.read(model)
    # A window down to the floor has a bar there that no robot gets over.
    if opening == "open door" and ("window" in item.catalogue_name or not has_leaf):
        return ()
    looks = (item.look, item.materials, opening)
    key = repr(("sweet home 1", model.filename, model.CRC, item.size, item.rotation, looks))
    parts = piece_cache.load_parts(key)
    if parts is None:
        rotation = np.array(item.rotation).reshape(3, 3)
        size = np.array(item.size)
        folder = _dressed(home, item, opening)
        converted = convert(folder, "model.obj", rotation, size, MAX_TRIANGLES, MAX_TEXTURE)
        parts = piece_cache.store_parts(key, converted)
    return parts


@dataclass(frozen=True, slots=True)
class _Shown:
    """Look of a material: its colour with opacity, and its picture."""

    rgba: tuple[float, float, float, float]
    picture: Traversable | None = None


def _dressed(home: HomeFile, item: ListedPiece, opening: Opening | None) -> zipfile.Path:
    """A folder with `model.obj`, whose materials are those that the piece has in this home."""
    folder = home.content.joinpath(*item.model.split("/")[:-1])
    materials = dict(DEFAULT_MATERIALS)
    lines = ["mtllib model.mtl"]
    used: dict[tuple[str, str], None] = {}
    points: list[tuple[float, float, float]] = []
    group = material = ""
    for line in home.archive.read(item.model).decode("latin-1").splitlines():
        match line.split():
            case ["mtllib", *names]:
                materials |= read_mtl(folder / " ".join(names))
            case ["g" | "o", *names]:
                group = names[0] if names else ""
            case ["usemtl", *names]:
                material = " ".join(names)
            case ["v", x, y, z, *_]:
                points.append((float(x), float(y), float(z)))
                lines.append(line)
            case ["f", *corners]:
                role = next((role for role in (_LEAF, _PANE) if group.startswith(role)), "")
                used[role, material] = None
                lines += [f"usemtl {role}|{material}", *_triangles(corners, points)]
            case _:
                lines.append(line)
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        listing = []
        for number, (role, name) in enumerate(used):
            shown = _shown(home, folder, item, materials, role, name, opening)
            listing.append(f"newmtl {role}|{name}\n")
            listing.append("Kd {} {} {}\nd {}\n".format(*shown.rgba))
            if shown.picture is not None and shown.picture.is_file():
                listing.append(f"map_Kd {number}.png\n")
                archive.writestr(f"{number}.png", shown.picture.read_bytes())
        archive.writestr("model.mtl", "".join(listing).encode("latin-1"))
        archive.writestr("model.obj", "\n".join(lines).encode("latin-1"))
    return zipfile.Path(zipfile.ZipFile(packed))


def _triangles(corners: list[str], points: list[tuple[float, float, float]]) -> list[str]:
    """Lines with the triangles of a face; models of this program have concave ones."""
    if len(corners) < 4:
        return [" ".join(("f", *corners))]
    numbers = [int(corner.split("/")[0]) for corner in corners]
    outline = np.array([points[number - 1 if number > 0 else number] for number in numbers])
    return [" ".join(("f", *(corners[i] for i in three))) for three in triangulated(outline)]


def _shown(
    home: HomeFile,
    folder: Traversable,
    item: ListedPiece,
    materials: Mapping[str, Material],
    role: str,
    name: str,
    opening: Opening | None,
) -> _Shown:
    """Look of a material of the model in a group of that role."""
    if (opening == "open door" and role == _LEAF) or (opening == "window" and role == _PANE):
        return _Shown(_HIDDEN.rgba)  # not left out: it counts for the size of the model
    own = materials.get(name, Material())
    look = dict(item.materials).get(name, item.look)
    if role == _PANE:
        return _Shown((*own.rgba[:3], min(own.rgba[3], GLASS)))
    if look is None:
        return _Shown(own.rgba, None if own.texture is None else folder / own.texture)
    return _changed(home, look, own)


def _changed(home: HomeFile, look: SurfaceStyle, own: Material) -> _Shown:
    if look.rgb is None:
        return _Shown(_HIDDEN.rgba)
    picture = None if look.image is None else home.content.joinpath(*look.image.split("/"))
    return _Shown((*look.rgb, own.rgba[3]), picture)


def _mirrored(part: Part) -> Part:
    """Left and right exchanged."""
    flip = np.array([-1.0, 1.0, 1.0], np.float32)
    return replace(
        part, vertices=part.vertices * flip, normals=part.normals * flip, faces=part.faces[:, ::-1]
    )


def _view(item: ListedPiece) -> tuple[Part, Part]:
    """Outdoors by day in the middle of the wall, to be seen from both sides."""
    w, _, h = item.size
    y = -item.wall_offset
    place = f"{item.x:.2f} {item.y:.2f}"
    rng = np.random.default_rng(zlib.crc32(place.encode()))
    picture = finish("outdoors", rng, held_out=True).surface
    return (
        flat_panel((-w / 2, y, 0), (w, 0, 0), (0, 0, h), picture, tile=0),
        flat_panel((w / 2, y, 0), (-w, 0, 0), (0, 0, h), picture, tile=0),
    )


def _tilted(parts: tuple[Part, ...], tilt: tuple[float, float]) -> tuple[Part, ...]:
    """The parts after pitch, or else roll [rad], with their footprint around the origin again."""
    if tilt == (0.0, 0.0) or not parts:
        return parts
    pitch, roll = tilt
    T = np.eye(4)
    T[:3, :3] = Rotation.from_euler("x" if pitch else "y", -pitch if pitch else roll).as_matrix()
    turned = [moved_part(part, T) for part in parts]
    corners = triangles(turned).reshape(-1, 3)
    low, high = corners.min(axis=0), corners.max(axis=0)
    T = np.eye(4)
    T[:3, 3] = -(low[0] + high[0]) / 2, -(low[1] + high[1]) / 2, -low[2]
    return tuple(moved_part(part, T) for part in turned)
