"""The texts of the classes of photographs, which take neither PyTorch nor the weights."""

from __future__ import annotations

from collections.abc import Sequence
from hashlib import sha256

import numpy as np
from numpy.typing import NDArray

from mapping.clip.photos.fit import photo_fit
from mapping.clip.photos.names import CLASSES, TABLE, distribution, read_name
from mapping.clip.photos.weights import SHA256
from mapping.clip.reading import Reading

_LIKE_NOTHING: NDArray[np.float32] = (
    np.where(np.arange(CLASSES) % 2, -1.0, 1.0).astype(np.float32) / CLASSES**0.5
)
"""Embedding of a text without a name: half of the classes speak against the others. Were it alike
to all classes instead, the background phrases without a name would hide what those with one say."""

NOTICE = "photos names things by the thousand classes of a classifier: no colours, no sentences"


class PhotoTexts:
    """A `TextEncoder`: a text is the square root of the probabilities of what it names.

    The cosine with a picture would be the Bhattacharyya coefficient of the two distributions, which
    is high for every picture of no particular class where a name has many ("dog" has 118). So what
    the text has in common with even probabilities is taken from it.
    """

    dimension = CLASSES
    notice: str | None = NOTICE

    def __init__(self) -> None:
        fit = photo_fit()
        self.model_id = model_id()
        self.threshold = fit.threshold
        self.log_odds: tuple[float, float] | None = (fit.scale, fit.bias)

    def embed_texts(self, texts: Sequence[str]) -> NDArray[np.float32]:
        """Embeddings (N, 1000), unit rows; a text without a name is like no picture."""
        return np.array([_embedded(text) for text in texts], np.float32).reshape(-1, CLASSES)

    def reading(self, text: str) -> Reading:
        """The name that a text ends with.

        Raises:
            ConfigError: it has none.
        """
        return read_name(text)


def _embedded(text: str) -> NDArray[np.float32]:
    classes = distribution(text)
    if classes is None:
        return _LIKE_NOTHING
    roots, even = np.sqrt(classes), np.float32(CLASSES**-0.5)
    above = roots - roots.sum() * even * even
    return np.asarray(above / np.linalg.norm(above), np.float32)


def model_id() -> str:
    """Names all that decides what embeddings say: weights, temperature and names."""
    found = sha256(f"{SHA256} {photo_fit().temperature}".encode())
    found.update(TABLE.read_bytes())
    return f"photos-{found.hexdigest()[:8]}"
