"""An encoder of your own: it knows colours and nothing else.

    cd examples
    ../.venv/bin/vizbot dry-run "yellow chair" --clip colour_encoder:ColourEncoder --method paper

What it goes to is yellow and mostly no chair, so the scorer of the simulation calls it wrong. The
paper's method compares cosines alone; probabilities need an encoder that knows background phrases.

The class is made without arguments and has to fit `mapping.clip.encoder.ClipEncoder`; a test can
ask that, too: `mapping.clip.own_encoder.broken_promise(ColourEncoder()) is None`.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from vizbot import Reading

COLOURS = {
    "red": (200, 30, 30),
    "yellow": (220, 200, 40),
    "green": (40, 150, 60),
    "blue": (40, 70, 190),
    "white": (235, 235, 235),
}
PALETTE = np.array(list(COLOURS.values()), np.float32)
SHARPNESS = 40.0


class ColourEncoder:
    """A picture is how much of it is near each colour; a text is the colours that it names."""

    model_id = "colour_encoder:ColourEncoder"
    dimension = len(COLOURS)
    threshold = 0.8
    log_odds = (12.0, -12.0 * threshold)
    notice = "this encoder knows colours and nothing else"

    def embed_texts(self, texts: Sequence[str]) -> NDArray[np.float32]:
        """Unit rows (N, 5) of the colours that N texts name; all of them where there is none."""
        named = [[colour in text.lower() for colour in COLOURS] for text in texts]
        rows = np.array(named, np.float32).reshape(len(texts), self.dimension)
        rows[~rows.any(axis=1)] = 1.0
        return rows / np.linalg.norm(rows, axis=1, keepdims=True)

    def embed_images(self, images: Sequence[NDArray[np.uint8]]) -> NDArray[np.float32]:
        """Unit rows (N, 5) of the shares of colours in N pictures (h, w, 3) RGB."""
        rows = np.zeros((len(images), self.dimension), np.float32)
        for row, image in zip(rows, images, strict=True):
            pixels = image[::4, ::4].reshape(-1, 1, 3).astype(np.float32)
            away = np.linalg.norm(pixels - PALETTE, axis=2)
            near = np.exp(-away / SHARPNESS)
            row[:] = (near / near.sum(axis=1, keepdims=True)).mean(axis=0)
        return rows / np.linalg.norm(rows, axis=1, keepdims=True)

    def reading(self, text: str) -> Reading:
        """The text as it is."""
        return Reading(text)
