"""A stand-in for CLIP that knows colour words, for rehearsals in simulated homes.

One axis of the embedding stands for each colour, and one for all that no colour word says. A text
is the mean of the axes it names. An image is the square root of its soft colour histogram, in which
vivid pixels count several times over plain ones, so that the cosine with a colour's axis tells how
large a part of the image has that colour: with `VIVID_WEIGHT` 6, the parts 2.5, 4, 10 and 50 % of
yellow on a plain background score 0.29, 0.40, 0.61 and 0.93.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

# Upper ends of the hues [degrees], which run from red through to red again.
_HUES = (
    ("red", 14.0),
    ("orange", 43.0),
    ("yellow", 70.0),
    ("green", 160.0),
    ("cyan", 195.0),
    ("blue", 255.0),
    ("purple", 295.0),
    ("pink", 343.0),
)
_VIVID = tuple(name for name, _ in _HUES)
_COLOURS = (*_VIVID, "brown", "white", "grey", "black")
_SYNONYMS = {
    "gray": "grey",
    "violet": "purple",
    "magenta": "pink",
    "turquoise": "cyan",
    "golden": "yellow",
    "scarlet": "red",
}

_THUMBNAIL = 32
"""Patches are averaged down to this many pixels a side, which takes the sensor's noise away."""
_HUE_BLUR = 2.0
"""Half width of the transition between two hues [degrees]."""
_SPECK = 0.01
"""Parts of an image below this are not seen; the square root would make much of them."""
VIVID_WEIGHT = 6.0
"""How many plain pixels a vivid one counts for."""


class ColourWords:
    """A `ClipEncoder` of colour words: "yellow chair" is found wherever something is yellow."""

    model_id = "embedded"
    dimension = len(_COLOURS) + 1
    threshold = 0.30
    """Reached where vivid pixels of the colour fill 2.5 % of a patch on a plain background."""
    notice: str | None = "rehearsal model: not meant for real pictures"

    def embed_images(self, images: Sequence[NDArray[np.uint8]]) -> NDArray[np.float32]:
        """Embeddings (N, D), unit rows, of N RGB images (h, w, 3) of any sizes."""
        embeddings = np.zeros((len(images), self.dimension), np.float32)
        for row, image in zip(embeddings, images, strict=True):
            row[:-1] = np.sqrt(_seen(_histogram(image)))
        return _unit(embeddings)

    def embed_texts(self, texts: Sequence[str]) -> NDArray[np.float32]:
        """Embeddings (N, D), unit rows; a text without a colour is orthogonal to all images."""
        embeddings = np.zeros((len(texts), self.dimension), np.float32)
        for row, text in zip(embeddings, texts, strict=True):
            words = [_SYNONYMS.get(word, word) for word in re.findall(r"[a-z]+", text.lower())]
            row[[i for i, colour in enumerate(_COLOURS) if colour in words] or [-1]] = 1.0
        return _unit(embeddings)


def _histogram(image: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Parts (colours,) of an RGB image (h, w, 3) that have each colour; they sum to 1.

    Hue and saturation do not change with exposure, which scales the channels alike.
    """
    small = cv2.resize(image, (_THUMBNAIL, _THUMBNAIL), interpolation=cv2.INTER_AREA)
    hsv = cv2.cvtColor(small.astype(np.float32) / 255.0, cv2.COLOR_RGB2HSV)
    hue, saturation, value = (hsv[..., channel].ravel() for channel in range(3))
    # Wood, beige and warm light on white walls stay below; hue means nothing in the dark.
    vivid = _step(saturation, 0.58, 0.72) * _step(value, 0.12, 0.25)

    parts = np.empty((len(_COLOURS), hue.size), np.float32)
    ends = np.array([end for _, end in _HUES], np.float32)[:, None]
    below = np.clip((ends + _HUE_BLUR - hue) / (2 * _HUE_BLUR), 0.0, 1.0)
    parts[: len(_VIVID)] = vivid * np.diff(below, axis=0, prepend=np.zeros((1, hue.size)))
    parts[0] += vivid * (1.0 - below[-1])
    # Dark orange is brown, and so is the pale orange of wood.
    orange = _COLOURS.index("orange")
    bright = _step(saturation, 0.80, 0.90) * _step(value, 0.60, 0.70)
    brown = (1.0 - bright) * parts[orange]
    parts[orange] -= brown
    plain = 1.0 - vivid
    pale = plain * _step(saturation, 0.30, 0.40) * _step(value, 0.15, 0.25)
    pale *= np.clip((55.0 - hue) / 10.0, 0.0, 1.0)
    plain -= pale
    white, black = _step(value, 0.70, 0.85), 1.0 - _step(value, 0.12, 0.25)
    parts[-4:] = brown + pale, plain * white, plain * (1.0 - white - black), plain * black
    return np.asarray(parts.mean(axis=1))


def _seen(parts: NDArray[np.float32]) -> NDArray[np.float32]:
    """Weight (colours,) of each colour of a histogram in the eye of the encoder."""
    seen = np.asarray(np.maximum(parts - _SPECK, 0.0))
    seen[: len(_VIVID)] *= VIVID_WEIGHT
    return seen


def _step(x: NDArray[np.float32], low: float, high: float) -> NDArray[np.float32]:
    """0 below `low`, 1 above `high`, a straight line between."""
    return np.asarray(np.clip((x - low) / (high - low), 0.0, 1.0))


def _unit(embeddings: NDArray[np.float32]) -> NDArray[np.float32]:
    return np.asarray(embeddings / np.linalg.norm(embeddings, axis=1, keepdims=True), np.float32)
