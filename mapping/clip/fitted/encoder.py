"""Encoders whose numbers of the belief were fitted to them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from mapping.clip.fitted.calibration import (
    EncoderCalibration,
    encoder_hash,
    kept_calibration,
    read_calibration,
    require_same_encoder,
)
from mapping.clip.fitted.phrasings import BARE, embed_phrased
from mapping.clip.places.evidence import Weights, shipped_weights
from mapping.clip.reading import Reading

if TYPE_CHECKING:  # its module loads torch
    from mapping.clip.encoder import ClipEncoder, TextEncoder


@runtime_checkable
class Calibrated(Protocol):
    """An encoder that knows the numbers that were fitted to it."""

    @property
    def calibration(self) -> EncoderCalibration | None:
        """Those numbers; None where none were."""
        ...


@runtime_checkable
class Weighted(Protocol):
    """An encoder that names the weights of the belief that it is asked by."""

    @property
    def belief_weights(self) -> Weights:
        """Those weights."""
        ...


class CalibratedTexts:
    """A `TextEncoder` with the numbers that were fitted to it.

    Attributes:
        calibration: Those numbers.
        source: Where they were found, in words.
    """

    def __init__(self, encoder: TextEncoder, calibration: EncoderCalibration, source: str) -> None:
        """Wrap an encoder."""
        self.source = source
        self.calibration: EncoderCalibration | None = calibration
        self.model_id, self.dimension = encoder.model_id, encoder.dimension
        self.threshold, self.notice = calibration.threshold, encoder.notice
        self.log_odds: tuple[float, float] | None = calibration.log_odds
        self._encoder = encoder

    def embed_texts(self, texts: Sequence[str]) -> NDArray[np.float32]:
        """See `TextEncoder.embed_texts`."""
        return self._encoder.embed_texts(texts)

    def reading(self, text: str) -> Reading:
        """See `TextEncoder.reading`."""
        return self._encoder.reading(text)


class CalibratedEncoder(CalibratedTexts):
    """A `ClipEncoder` with the numbers that were fitted to it; else as `CalibratedTexts`."""

    def __init__(self, encoder: ClipEncoder, calibration: EncoderCalibration, source: str) -> None:
        """Wrap an encoder."""
        super().__init__(encoder, calibration, source)
        self._images, self._hash = encoder, calibration.encoder_hash

    def embed_images(self, images: Sequence[NDArray[np.uint8]]) -> NDArray[np.float32]:
        """See `ClipEncoder.embed_images`."""
        return self._images.embed_images(images)

    def weights_hash(self) -> str:
        """Hash of the weights, which is known already."""
        return self._hash


def calibration_of(encoder: TextEncoder) -> EncoderCalibration | None:
    """The numbers that were fitted to an encoder; None where it has those that come along."""
    return encoder.calibration if isinstance(encoder, Calibrated) else None


def weights_of(encoder: TextEncoder) -> Weights:
    """The weights of the belief for an encoder."""
    fitted = calibration_of(encoder)
    if fitted is not None:
        return fitted.weights
    if isinstance(encoder, Weighted):
        return encoder.belief_weights
    return shipped_weights(encoder.model_id, encoder.log_odds is not None)


def embed_asked(encoder: TextEncoder, texts: Sequence[str]) -> NDArray[np.float32]:
    """Embeddings (N, D), unit rows, of texts as the belief asks by them."""
    fitted = calibration_of(encoder)
    return embed_phrased(encoder, texts, BARE if fitted is None else fitted.phrasings)


def calibrated(encoder: ClipEncoder, file: Path | None = None) -> ClipEncoder:
    """The encoder with the numbers that were fitted to it; itself where there are none.

    Args:
        encoder: Has none yet.
        file: A file that somebody names; None for the one in this user's folder.

    Raises:
        ConfigError: the file that is named cannot be used, or is for another encoder.
    """
    if file is None:
        kept = kept_calibration(encoder)
        return encoder if kept is None else CalibratedEncoder(encoder, kept[0], str(kept[1]))
    found = read_calibration(file)
    require_same_encoder(found, encoder_hash(encoder), encoder.model_id, file)
    return CalibratedEncoder(encoder, found, str(file))


def calibration_to_ask_with(
    encoder: TextEncoder, file: Path | None, of_map: EncoderCalibration | None
) -> tuple[EncoderCalibration, str] | None:
    """The numbers that a map is asked with, and where they were found, in words; None without any.

    Args:
        encoder: Of the map, which may be another one than the settings name.
        file: A file that the settings name, which counts if it is for this encoder; None for none.
        of_map: Numbers that the map was made with, for where this user has none.

    Raises:
        ConfigError: the file cannot be used.
    """
    if file is not None:
        named = read_calibration(file)
        if named.encoder_hash == encoder_hash(encoder):
            return named, str(file)
    if (kept := kept_calibration(encoder)) is not None:
        return kept[0], str(kept[1])
    if of_map is not None and of_map.encoder_hash == encoder_hash(encoder):
        return of_map, "the map"
    return None
