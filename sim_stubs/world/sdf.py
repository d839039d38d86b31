"""Gazebo's worlds (SDF: `.world`, `.sdf`).

What the visuals of models show is there. A model is an instance of what its name ends with
(`ChairA_01_002` is a chair), with all in it; everything else is structure, and the model
`floor_NAME` is the floor of that room. Where the world holds a `state`, as Gazebo saves it, its
poses of links count. A plane becomes a floor below everything else, a mesh is shown whole, and
material scripts are grey. Models are looked for where Gazebo does, and in the folders around the
world and their folders `models`.

Source: SDFormat specification, http://sdformat.org/spec.
"""

from __future__ import annotations

import logging
import os
import re
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from sim_stubs.homes.furniture import cache
from sim_stubs.homes.furniture.conversion import converted
from sim_stubs.homes.furniture.mesh_file import read_mesh
from sim_stubs.homes.furniture.wavefront import Material
from sim_stubs.homes.geometry.extent import require_home_sized
from sim_stubs.homes.geometry.house import House, Room
from sim_stubs.homes.geometry.occupancy_slice import CELL, grid_around, occupied
from sim_stubs.homes.geometry.solids import Part, by_material, flat_panel, moved_part, triangles
from sim_stubs.homes.sweet_home.home import widest_start
from sim_stubs.homes.sweet_home.shell import room_name
from sim_stubs.world.mjcf import instance_of, lamps_in, walls_around
from sim_stubs.world.mjcf_things import GeomAppearance, Thing, primitive, read_labels, require_named
from vizbot.core.errors import ConfigError
from vizbot.core.files import read_regular
from vizbot.core.geometry import yaw_of
from vizbot.core.home_vocabulary import SYNONYMS, THINGS
from vizbot.core.types import SE3

_LARGEST = 32 * 1024 * 1024
"""Size of an SDF file that is read [bytes]."""
_PATHS = ("GZ_SIM_RESOURCE_PATH", "IGN_GAZEBO_RESOURCE_PATH", "GAZEBO_MODEL_PATH")
"""Gazebo's variables with folders of models."""
_AROUND = 4
"""Number of folders around a world that are looked into."""
_MAX_TRIANGLES, _MAX_TEXTURE = 20_000, 512
_GREY = (0.7, 0.7, 0.7, 1.0)
_NAMES = {"headboard": "bed", "kitchen table": "dining table"}  # beds as AWS's worlds call them
_NAMES |= {name: label for label in THINGS for name in (label, *SYNONYMS.get(label, ()))}
_LABELS = {name.replace(" ", ""): label for name, label in _NAMES.items() if label != "box"}

_log = logging.getLogger(__name__)


def read_sdf(
    path: Path, labels: Path | None = None, start: tuple[float, float, float] | None = None
) -> House:
    """The world in an SDF file.

    Args:
        path: The file.
        labels: File with labels of models by their names in the world.
        start: x, y [m], yaw [rad] of the robot; as a default it is where the rooms, or else all
            free floor, are widest.

    Raises:
        ConfigError: The file or what it names cannot be read or is not found, it is too large, it
            has no free floor, or what a label is for is not in it.
    """
    world = _parsed(path, path).find("world")
    if world is None:
        raise ConfigError(f"world {path} has no <world>; give the file that Gazebo opens")
    try:
        house = _house(path, world, {} if labels is None else read_labels(labels))
    except ValueError as error:
        raise ConfigError(f"world {path}: {error}; correct it") from error
    begin = start or widest_start(house)
    if begin is None:
        raise ConfigError(f"world {path} has no free floor at z = 0; add one to it there")
    return replace(house, start=begin)


def _house(path: Path, world: Element, given: Mapping[str, str]) -> House:
    """Everything but the start; `given` has labels by the names of models."""
    models = _Models(path)
    shown = [model for model in models.placed(world) if model[2]]
    for name in given:
        require_named(name, [model[0] for model in shown], f"world {path}", "model")
    everything = triangles([part for _, _, parts in shown for part in parts])
    require_home_sized(everything.reshape(-1, 3))
    if not len(everything):
        raise ConfigError(f"world {path} shows nothing; give one with visuals")
    low, high = everything.min(axis=(0, 1)), everything.max(axis=(0, 1))
    along, up = (high[0] - low[0], 0.0, 0.0), (0.0, high[1] - low[1], 0.0)
    structure = [flat_panel((*low[:2], z), along, up, rgb) for z, rgb in models.planes]
    instances, rooms, count = [], [], Counter[str]()
    for name, T, parts in shown:
        if label := given.get(name) or label_of(name):
            count[label] += 1
            thing = Thing(f"{label}#{count[label]}", label)
            instances.append(instance_of(thing, yaw_of(T), parts, f"{name} of {path.name}"))
            continue
        structure += parts
        if name.startswith("floor_"):
            rooms.append(_room(room_name(name[6:].replace("_", " "), ()), parts))
    lights = [light for light in world.findall("light") if light.get("type") != "directional"]
    lamps = [_pose(light)[:3, 3] for light in lights]
    return House(
        rooms=tuple(rooms),
        structure=by_material([*structure, *walls_around(triangles(structure))]),
        instances=tuple(instances),
        lights=np.array(lamps) if lamps else lamps_in(everything),
        start=(0.0, 0.0, 0.0),
    )


def label_of(name: str) -> str | None:
    """The class of a model by the last words of its name that name one; None without one.

    "HomeOfficeDeskChairs_Oaed1cbd04270_lod0" is an office chair: what has digits in it is no word.
    """
    pieces = (re.fullmatch(r"([a-zA-Z]+)\d*", piece) for piece in re.split(r"[\W_]+", name))
    plain = " ".join(piece[1] for piece in pieces if piece)
    words = [word.lower() for word in re.findall("[A-Z]+(?![a-z])|[A-Z]?[a-z]+", plain)]
    for length in range(len(words), 0, -1):
        for first in range(len(words) - length, -1, -1):
            said = "".join(words[first : first + length])
            for form in (said, said.removesuffix("s"), said.removesuffix("es")):
                if form in _LABELS:
                    return _LABELS[form]
    return None


@dataclass
class _Models:
    """The models of a world and the files that they come from.

    Attributes:
        world: The file of the world.
        planes: Height [m] and colour of every plane.
    """

    world: Path
    planes: list[tuple[float, tuple[float, ...]]] = field(default_factory=list)
    _meshes: dict[object, tuple[Part, ...]] = field(default_factory=dict)

    def placed(self, world: Element) -> Iterator[tuple[str, SE3, list[Part]]]:
        """Every model of the world: its name, its pose, and its parts in the world."""
        state = {model.get("name", ""): model for model in world.findall("state/model")}
        for element in (*world.findall("model"), *world.findall("include")):
            model, folder, T = self._opened(element, self.world.parent)
            names = element.findtext("name"), element.get("name"), model.get("name")
            name = next((each for each in names if each), "")
            links = state[name].iter("link") if name in state else ()
            moved = {link.get("name", "").split("::")[-1]: _pose(link) for link in links}
            yield name, T, list(self._parts(model, folder, T, moved))

    def _opened(self, element: Element, folder: Path) -> tuple[Element, Path, SE3]:
        """A model or what an include names, the folder of its file, and its pose."""
        if element.tag == "model":
            return element, folder, _pose(element)
        found = self._found(element, folder)
        if found.is_dir():
            config = found / "model.config"
            files = _parsed(config, self.world).findall("sdf") if config.is_file() else []
            found /= (files[-1].text or "").strip() if files else "model.sdf"
        model = _parsed(found, self.world).find("model")
        if model is None:
            raise ConfigError(f"world {self.world}: {found} has no <model>; correct it")
        return model, found.parent, _pose(model if element.find("pose") is None else element)

    def _parts(
        self, model: Element, folder: Path, T: SE3, moved: Mapping[str, SE3]
    ) -> Iterator[Part]:
        """What a model at a pose shows, in the world; `moved` has poses of its links there."""
        for link in model.findall("link"):
            T_link = moved.get(link.get("name", ""), T @ _pose(link))
            for visual in link.findall("visual"):
                for shape in visual.findall("geometry/*"):
                    T_shape = T_link @ _pose(visual)
                    rgba = _numbers(visual, "material/diffuse", "")
                    if shape.tag == "plane":
                        self.planes.append((T_shape[2, 3], (rgba or _GREY)[:3]))
                    elif float(visual.findtext("transparency", "0")) < 1.0:
                        parts = self._shape(shape, folder, rgba)
                        yield from (moved_part(part, T_shape) for part in parts)
        for nested in (*model.findall("model"), *model.findall("include")):
            inner, place, T_inner = self._opened(nested, folder)
            yield from self._parts(inner, place, T @ T_inner, moved)

    def _shape(self, shape: Element, folder: Path, rgba: tuple[float, ...]) -> tuple[Part, ...]:
        """A geometry in its own frame; without a colour a mesh has those of its own."""
        if shape.tag == "mesh":
            return self._mesh(self._found(shape, folder), _numbers(shape, "scale", "1 1 1"), rgba)
        size = np.array(_numbers(shape, "size", "0 0 0")) / 2
        if shape.tag in ("cylinder", "sphere", "capsule"):
            (radius,), (length,) = _numbers(shape, "radius"), _numbers(shape, "length", "0")
            size = np.array([radius, length / 2, 0.0])
        require_home_sized(np.stack([-size, size]))
        part = primitive(shape.tag, size, GeomAppearance(np.array(rgba or _GREY)))
        if part is None:
            _log.warning("<%s> of a visual is not shown", shape.tag)
        return () if part is None else (part,)

    def _mesh(
        self, file: Path, scale: tuple[float, ...], rgba: tuple[float, ...]
    ) -> tuple[Part, ...]:
        asked = file, scale, rgba
        if asked in self._meshes:
            return self._meshes[asked]
        surfaces = [replace(it, corners=it.corners * scale) for it in read_mesh(file)]
        if rgba:
            red, green, blue, alpha = rgba
            own = Material((red, green, blue, alpha))
            surfaces = [replace(surface, material=own) for surface in surfaces]
        looks = [surface.material for surface in surfaces]
        pictures = [file.parent / look.texture for look in looks if look.texture]
        files = [(it, it.stat().st_mtime_ns) for it in (file, *pictures) if it.exists()]
        key = repr(("sdf", scale, looks, files))
        parts = cache.load_parts(key)
        if parts is None:
            made = converted(surfaces, file.parent, file.name, _MAX_TRIANGLES, _MAX_TEXTURE)
            parts = cache.store_parts(key, made)
        self._meshes[asked] = parts
        return parts

    def _found(self, element: Element, folder: Path) -> Path:
        """The file or folder that the URI in an element names; a plain path is from `folder`."""
        uri = element.findtext("uri", "").strip()
        scheme, _, rest = uri.rpartition("://")
        named = ":".join(os.environ.get(name, "") for name in _PATHS).split(":")
        around = self.world.resolve().parents[:_AROUND]
        folders = [Path(each) for each in named if each]
        folders += [each / models for each in around for models in ("", "models")]
        for each in folders if scheme in ("model", "file") else [folder]:
            if rest and (each / rest).exists():
                return each / rest
        raise ConfigError(
            f"world {self.world}: {uri!r} of <{element.tag}> is not found; add the folder of its"
            " models to GZ_SIM_RESOURCE_PATH"
        )


def _room(name: str, parts: list[Part]) -> Room:
    corners = triangles(parts)
    grid = grid_around(corners, CELL)
    floor = occupied(corners, -np.inf, np.inf, grid).astype(np.uint8)
    outlines, _ = cv2.findContours(floor, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    outline = cv2.approxPolyDP(max(outlines, key=cv2.contourArea), 1.0, True)
    return Room(name, grid.pixels_to_xy(outline[:, 0].astype(np.float64)))


def _parsed(file: Path, world: Path) -> Element:
    try:
        return ElementTree.fromstring(read_regular(file, _LARGEST))
    except (OSError, ElementTree.ParseError) as error:
        raise ConfigError(f"world {world}: {file} cannot be read ({error}); correct it") from error


def _pose(element: Element) -> SE3:
    """The pose of an element in the one around it."""
    pose = element.find("pose")
    T = np.eye(4)
    if pose is None or not (pose.text or "").strip():
        return T
    if frame := pose.get("relative_to") or pose.get("frame"):
        raise ValueError(f"the pose of a {element.tag} is in a frame of its own, {frame!r}")
    place = _numbers(element, "pose")
    if len(place) != 6:
        name = f"{element.tag} {element.get('name', '')!r}"
        raise ValueError(f"the pose of {name} has {len(place)} numbers, not 6")
    in_degrees = pose.get("degrees") == "true"
    T[:3, :3] = Rotation.from_euler("xyz", place[3:], degrees=in_degrees).as_matrix()
    T[:3, 3] = place[:3]
    return T


def _numbers(element: Element, tag: str, default: str | None = None) -> tuple[float, ...]:
    text = element.findtext(tag, default)
    if text is None:
        raise ValueError(f"a {element.tag} has no {tag}")
    return tuple(float(number) for number in text.split())
