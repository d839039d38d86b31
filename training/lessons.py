"""Lessons: what the classifier of photographs says of real pictures, to be learned from.

Its names alone can be taught. The pictures are cut into patches as large as the robot's.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

from mapping.clip.embedded.encoder import to_pixels
from mapping.clip.photos.encoder import open_photo_classes
from mapping.clip.photos.names import distribution
from training.views import PATCH_EDGES
from vizbot.core.errors import ConfigError
from vizbot.core.files import write_whole
from vizbot.core.home_vocabulary import THINGS

_EDGE = 480
"""The shorter edge of a picture of the robot's camera [px]."""
NAMES = tuple(name for name in THINGS if distribution(name) is not None)
"""The things that the classifier has names for."""
_PICTURES = (".jpg", ".jpeg", ".png")


@dataclass(frozen=True, slots=True, eq=False)
class Lessons:
    """Patches of photographs, and what is to be said of them.

    Attributes:
        pixels: (N, 96, 96, 3) uint8, RGB.
        beliefs: (N, len(NAMES)) float32, the probability that the teacher gives each name.
    """

    pixels: NDArray[np.uint8]
    beliefs: NDArray[np.float32]


def read_lessons(photographs: Sequence[Path], kept: Path) -> Lessons:
    """Cut out patches of all pictures in some folders and ask the teacher, or read what was kept.

    Raises:
        ConfigError: a folder has no pictures, or the teacher's weights are not here.
    """
    if not kept.exists():
        patches = [patch for folder in photographs for patch in _patches(folder)]
        teacher = open_photo_classes("cpu")
        cosines = teacher.embed_images(patches) @ teacher.embed_texts(NAMES).T
        assert teacher.log_odds is not None
        scale, bias = teacher.log_odds
        content = io.BytesIO()
        np.savez(
            content,
            pixels=to_pixels(patches),
            beliefs=expit(scale * cosines + bias).astype(np.float32),
        )
        write_whole(kept, content.getvalue())
    with np.load(kept, allow_pickle=False) as arrays:
        return Lessons(arrays["pixels"], arrays["beliefs"])


def read_picture(file: Path) -> NDArray[np.uint8]:
    """A picture (H, W, 3), RGB, brought to the shorter edge of those of the robot's camera.

    Raises:
        ConfigError: the file is no picture.
    """
    image = cv2.imread(str(file))
    if image is None:
        raise ConfigError(f"{file} is no picture; delete it")
    factor = _EDGE / min(image.shape[:2])
    image = cv2.resize(image, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
    return np.asarray(image[..., ::-1], np.uint8)


def _patches(folder: Path) -> Iterator[NDArray[np.uint8]]:
    """Square patches (E, E, 3) of every picture, a picture after another."""
    files = sorted(file for file in folder.rglob("*") if file.suffix.lower() in _PICTURES)
    if not files:
        raise ConfigError(f"{folder} holds no pictures ({', '.join(_PICTURES)})")
    for number, file in enumerate(files):
        image = read_picture(file)
        rng = np.random.default_rng((number, 17))
        for low, high in PATCH_EDGES:
            edge = int(rng.integers(low, high))
            v, u = (int(rng.integers(size - edge + 1)) for size in image.shape[:2])
            yield image[v : v + edge, u : u + edge]
