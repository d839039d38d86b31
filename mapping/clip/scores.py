"""Scores: how well an element matches a question, in units that no encoder decides.

Encoders differ in the cosines that they give to what matches and to what does not. Two numbers do
not: the cosine in the encoder's own log odds, and how far it lies above what the element has with a
list of background phrases, in standard deviations. Of those phrases the tenth that is most similar
to the element is left out: it names what the patch shows, perhaps with the meaning of the question
("couch" for "sofa"), which says nothing against the question. So the background depends on the
element alone and is known before any question. Another thing in the patch lowers the score hardly
more than the cosine: a table before the lower half of a window about a fifth more. A third number
says how high the question's log odds go on a bank of pictures.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import NDArray

from mapping.clip.background.kept_bank import KnownWeights, OnProgress, kept_bank
from mapping.clip.background.phrases import PHRASES
from mapping.clip.background.pictures import bank
from mapping.clip.places.evidence import Weights, fitted_weights

if TYPE_CHECKING:  # its module loads torch
    from mapping.clip.encoder import TextEncoder

LEFT_OUT = 0.1
"""Share of the phrases, those most similar to an element, that say nothing about it."""
LEAST_SPREAD = np.float32(1e-3)
"""Least standard deviation, by which the distance above the background is divided."""
ABOVE_TO_LOG_ODDS = 1.86, -8.4
"""Slope and offset that make log odds of standard deviations above the background, as they are of
the embedded encoder's patches in training home 916."""
TAIL, USUAL_TAIL = 0.99, 0.1
"""Quantile over the bank that is the upper tail of a question, and what stands in where an encoder
has not embedded the bank: the mean over the paper's goals [log odds]."""
NO_STATISTICS = np.zeros((0, 2), np.float32)
"""Value of `Background.statistics` for no elements."""
NO_PICTURES = np.zeros((0, 1), np.float32)
"""Value that stands for unknown embeddings of the bank."""
_AT_ONCE = 16_384
"""Elements whose similarities to all phrases are in memory at a time."""
_PICTURES_AT_ONCE = 32
"""Pictures of the bank that are embedded in one batch."""


@dataclass(frozen=True, slots=True, eq=False)
class Background:
    """The background phrases and the bank of pictures, as an encoder embeds them.

    Attributes:
        embeddings: (K, D) float32, unit rows, of the phrases.
        pictures: (B, D) of the pictures likewise; `NO_PICTURES` where they are not known.
    """

    embeddings: NDArray[np.float32]
    pictures: NDArray[np.float32] = field(default_factory=lambda: NO_PICTURES)

    @classmethod
    def embedded_by(
        cls, encoder: TextEncoder, on_progress: OnProgress = lambda done, of: None
    ) -> Self:
        """Phrases and bank in the space of an encoder.

        Args:
            encoder: If the hash of its weights is known, the bank is kept for the next run.
            on_progress: Called while a bank is embedded that is not kept yet.
        """
        if isinstance(encoder, KnownWeights):
            pictures = kept_bank(encoder, on_progress)
        else:
            pictures = _pictures_by(encoder)
        return cls(encoder.embed_texts(PHRASES), pictures)

    def statistics(self, embeddings: NDArray[np.float32]) -> NDArray[np.float32]:
        """What each element has in common with the phrases.

        Args:
            embeddings: (N, D), unit rows.

        Returns:
            (N, 2) float32: mean and standard deviation of its similarities to the phrases but for
            the `LEFT_OUT` most similar ones.
        """
        kept = len(self.embeddings) - round(LEFT_OUT * len(self.embeddings))
        found = np.empty((len(embeddings), 2), np.float32)
        for start in range(0, len(embeddings), _AT_ONCE):
            part = slice(start, start + _AT_ONCE)
            similarities = embeddings[part] @ self.embeddings.T
            lower = np.partition(similarities, kept - 1, axis=1)[:, :kept]
            found[part, 0] = lower.mean(axis=1)
            found[part, 1] = np.maximum(lower.std(axis=1), LEAST_SPREAD)
        return found


def _pictures_by(encoder: TextEncoder) -> NDArray[np.float32]:
    """The bank of pictures; none by an encoder that embeds texts alone."""
    embed_images = getattr(encoder, "embed_images", None)
    if embed_images is None:
        return NO_PICTURES
    pictures = bank()
    starts = range(0, len(pictures), _PICTURES_AT_ONCE)
    return np.concatenate([embed_images(pictures[i : i + _PICTURES_AT_ONCE]) for i in starts])


@dataclass(frozen=True, slots=True, eq=False)
class Query:
    """What is looked for, in the space of an encoder.

    Attributes:
        embedding: (D,) float32, unit length.
        log_odds: Scale and bias that make log odds of a cosine, as the encoder was trained; None
            where they are not known. The standard deviations above the background stand in then.
        rivals: (R, D) what a place may be instead (`other_rooms`); none of most questions.
        weights: Of the belief, as they were fitted to the encoder.
    """

    embedding: NDArray[np.float32]
    log_odds: tuple[float, float] | None
    rivals: Sequence[NDArray[np.float32]] = ()
    weights: Weights = field(default_factory=fitted_weights)

    def scores(
        self, embeddings: NDArray[np.float32], statistics: NDArray[np.float32]
    ) -> NDArray[np.float32]:
        """Scores (N, 2) float32: log odds by the encoder, standard deviations above background.

        Args:
            embeddings: (N, D), unit rows.
            statistics: (N, 2) as of `Background.statistics`.
        """
        cosines = embeddings @ self.embedding
        above = (cosines - statistics[:, 0]) / statistics[:, 1]
        if self.log_odds is None:
            log_odds = ABOVE_TO_LOG_ODDS[0] * above + ABOVE_TO_LOG_ODDS[1]
        else:
            log_odds = self.log_odds[0] * cosines + self.log_odds[1]
        return np.stack([log_odds, above], axis=1).astype(np.float32)

    def tail(self, pictures: NDArray[np.float32]) -> float:
        """How high the log odds of this question go on the bank of pictures.

        Without known log odds of the encoder it is not known either.

        Args:
            pictures: (B, D), unit rows, or `NO_PICTURES`.
        """
        if len(pictures) == 0 or self.log_odds is None:
            return USUAL_TAIL
        scale, bias = self.log_odds
        return scale * float(np.quantile(pictures @ self.embedding, TAIL)) + bias
