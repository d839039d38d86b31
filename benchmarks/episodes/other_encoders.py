"""Encoders as others are: the robot's own one, with other cosines for the same pictures and words.

Decisions must not depend on the numbers of one encoder. Here its cosines c become a c + b, so that
they lie where those of OpenAI's ViT-L/14 do, in the same order; and, as one encoder differs from
another, each text gets an offset and each pair of picture and text an error, or scale and bias are
not known.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import sqrt
from typing import TYPE_CHECKING
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from benchmarks.episodes.episode import EncoderScale
from mapping.clip.fitted.encoder import calibration_of, weights_of
from mapping.clip.places.evidence import shipped_weights
from mapping.clip.reading import Reading
from mapping.clip.scores import Background
from mapping.map_bundle import MapBundle

if TYPE_CHECKING:  # its module loads torch
    from mapping.clip.encoder import ClipEncoder

USUAL, THRESHOLD = 0.17, 0.27
"""Cosines of ViT-L/14: of a picture with a phrase that does not name it, and its threshold."""
OWN_USUAL = -0.31
"""The same of the embedded encoder, as measured on patches of training home 916: the mean over the
background phrases but for the tenth that is most similar."""
OFFSET, ERROR = 0.01, 0.01
"""Standard deviations of the offset of a text, and of the error of a pair."""
_AXES = 32
"""Axes that the errors of pairs are spread over."""


class OtherEncoder:
    """A `ClipEncoder` that has the robot's own one's cosines, scaled and shifted.

    Attributes:
        model_id: Of the own one, and what was done to it.
        dimension: Length of the embeddings.
        threshold: Scaled as the cosines are.
        log_odds: Undone: they are those of the own one's cosines; None where they are not known.
        notice: Of the own one.
        calibration: Of the own one.
        belief_weights: Of the own one, where its scale and bias are known.
    """

    def __init__(self, own: ClipEncoder, scale: EncoderScale) -> None:
        """Wrap an encoder."""
        self._own, self._offsets = own, scale == "offset"
        self._slope = (THRESHOLD - USUAL) / (own.threshold - OWN_USUAL)
        self._shift = USUAL - self._slope * OWN_USUAL
        self.model_id = f"{own.model_id}-{scale}"
        self.dimension = own.dimension + 3 + _AXES
        self.threshold = THRESHOLD
        self.log_odds: tuple[float, float] | None = None
        if own.log_odds is not None and scale != "unknown":
            factor = own.log_odds[0] / self._slope
            self.log_odds = factor, own.log_odds[1] - factor * self._shift
        self.notice, self.calibration = own.notice, calibration_of(own)
        known = self.log_odds is not None
        self.belief_weights = weights_of(own) if known else shipped_weights(self.model_id, known)

    def embed_images(self, images: Sequence[NDArray[np.uint8]]) -> NDArray[np.float32]:
        """Embeddings (N, D), unit rows, of pictures."""
        return self.embeddings_of_pictures(self._own.embed_images(images))

    def embeddings_of_pictures(self, rows: NDArray[np.float32]) -> NDArray[np.float32]:
        """Embeddings (N, D) of the pictures that the own encoder embeds as these rows."""
        shift = np.full(len(rows), sqrt(self._shift))
        return self._embeddings(rows, shift, [crc32(row.tobytes()) for row in rows], first=True)

    def map_of(self, bundle: MapBundle) -> MapBundle:
        """A map of the own encoder as it would be if this one had embedded its patches."""
        embeddings = self.embeddings_of_pictures(bundle.elements.embeddings)
        background = Background.embedded_by(self)
        return replace(
            bundle,
            model_id=self.model_id,
            elements=replace(bundle.elements, embeddings=embeddings),
            statistics=background.statistics(embeddings),
            pictures=background.pictures,
        )

    def embed_texts(self, texts: Sequence[str]) -> NDArray[np.float32]:
        """Embeddings (N, D), unit rows, of texts."""
        rows, seeds = self._own.embed_texts(texts), [crc32(text.encode()) for text in texts]
        shifts = np.full(len(rows), self._shift)
        if self._offsets:
            drawn = [np.random.default_rng((seed, 0)).normal(0.0, OFFSET) for seed in seeds]
            shifts += np.array(drawn).reshape(-1)
        shift = shifts / sqrt(self._shift)
        return self._embeddings(rows, shift, seeds, first=False)

    def reading(self, text: str) -> Reading:
        """How the own one takes a text."""
        return self._own.reading(text)

    def _embeddings(
        self,
        rows: NDArray[np.float32],
        shift: NDArray[np.float64],
        seeds: Sequence[int],
        *,
        first: bool,
    ) -> NDArray[np.float32]:
        """Unit rows whose products with those of the other kind are the cosines that are wanted.

        Of two further axes pictures use the `first` and texts the other one, to be of unit length.
        """
        errors = np.zeros((len(rows), _AXES))
        if self._offsets and len(rows):
            drawn = [np.random.default_rng((seed, 1)).normal(size=_AXES) for seed in seeds]
            errors = np.array(drawn) * sqrt(ERROR / sqrt(_AXES))
        used = np.column_stack([sqrt(self._slope) * rows, shift, errors])
        rest = np.sqrt(np.maximum(1.0 - (used**2).sum(axis=1), 0.0))[:, None]
        nothing = np.zeros_like(rest)
        ends = (rest, nothing) if first else (nothing, rest)
        return np.concatenate([used, *ends], axis=1).astype(np.float32)
