"""Models of furniture by other makers, which anyone may use, for the rooms of training homes.

`models.tsv` lists them: maker, file in a checkout of the repository that holds it, class, and the
turn about the vertical axis after which the front faces +z [deg]. It was made looking at a picture
of each. Assimp (Debian's package `assimp-utils`) turns them into Wavefront OBJ.
"""

from __future__ import annotations

import csv
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from math import cos, radians, sin
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from sim_stubs.homes.furniture import cache as piece_cache
from sim_stubs.homes.furniture.conversion import ConvertedPart, convert
from sim_stubs.homes.furniture.wavefront import read_obj
from sim_stubs.homes.geometry.solids import Piece
from vizbot.core.errors import ConfigError

TABLE = Path(__file__).with_name("models.tsv")
MAX_TRIANGLES, MAX_TEXTURE = 6000, 256
"""Triangles of a model that are kept, and the longest side of a texture [px]."""


@dataclass(frozen=True, slots=True)
class Maker:
    """A maker of models.

    Attributes:
        licence: What the models may be used under.
        linear: Whether colours in the files are in linear light.
    """

    licence: str
    linear: bool


MAKERS: Mapping[str, Maker] = {
    "Kenney": Maker("Kenney, Furniture Pack 1.0, CC0", linear=False),
    "Pascal": Maker("Copyright (c) 2026 Pascal Group Inc., MIT License", linear=True),
    "Poly Haven": Maker("Poly Haven, CC0", linear=True),
    "Quaternius 2017": Maker("Quaternius, Furniture Pack of October 2017, CC0", linear=True),
    "Quaternius 2019": Maker("Quaternius, Furniture Pack of March 2019, CC0", linear=True),
}


@cache
def read_models(folder: Path) -> Mapping[str, Sequence[Piece]]:
    """All models of the table, by their class, as large as their makers drew them.

    Args:
        folder: Holds a checkout of each repository of the table.

    Raises:
        ConfigError: a file is missing or cannot be converted, or there is no `assimp`.
    """
    found: dict[str, list[Piece]] = {}
    with TABLE.open(newline="", encoding="utf-8") as lines:
        for row in csv.DictReader(lines, delimiter="\t"):
            piece = _piece(folder / row["file"], row["maker"], row["label"], float(row["turn"]))
            found.setdefault(row["label"], []).append(piece)
    return found


def _piece(file: Path, maker: str, label: str, turn: float) -> Piece:
    key = repr(("models 1", maker, file.parts[-3:], turn, MAX_TRIANGLES, MAX_TEXTURE))
    parts = piece_cache.load_parts(key)
    if parts is None:
        parts = piece_cache.store_parts(key, _converted(file, turn, MAKERS[maker].linear))
    size = np.ptp(np.concatenate([part.vertices for part in parts]), axis=0)
    return Piece(label, file.stem, size.astype(np.float64), parts, MAKERS[maker].licence)


def _converted(file: Path, turn: float, linear: bool) -> tuple[ConvertedPart, ...]:
    if not file.is_file():
        raise ConfigError(f"model {file} is missing: check out its repository beside the others")
    sine, cosine = sin(radians(turn)), cos(radians(turn))
    rotation = np.array([[cosine, 0.0, sine], [0.0, 1.0, 0.0], [-sine, 0.0, cosine]])
    with TemporaryDirectory() as made:
        folder = Path(made)
        # Textures are looked for beside the model, by their names alone.
        for picture in (each for end in ("png", "jpg") for each in file.parent.rglob(f"*.{end}")):
            (folder / picture.name).symlink_to(picture.resolve())
        command = ["assimp", "export", str(file.resolve()), str(folder / "converted.obj")]
        try:
            done = subprocess.run(command, capture_output=True, text=True, check=False)
        except FileNotFoundError as error:
            raise ConfigError("models need assimp: apt install assimp-utils") from error
        if not (folder / "converted.obj").is_file():
            raise ConfigError(f"model {file} cannot be converted: {done.stdout.strip()[-200:]}")
        corners = np.concatenate([each.corners for each in read_obj(folder, "converted.obj")])
        size = np.ptp((corners @ rotation.T).reshape(-1, 3), axis=0)[[0, 2, 1]]
        parts = convert(folder, "converted.obj", rotation, size, MAX_TRIANGLES, MAX_TEXTURE)
    return tuple(_shown(part) for part in parts) if linear else parts


def _shown(part: ConvertedPart) -> ConvertedPart:
    """The part with its plain colour as screens show it (IEC 61966-2-1, its power law alone)."""
    rgba = part.rgba.copy()
    rgba[:3] **= 1 / 2.2
    return part if part.png else replace(part, rgba=rgba)
