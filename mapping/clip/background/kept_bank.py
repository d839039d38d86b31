"""The bank of pictures as an encoder embeds it, kept for its next run.

With a large encoder on a processor the bank takes minutes, and it is always the same: it is kept in
the user's cache, under the hash of the encoder's weights. A file that cannot be read is made anew,
and where none can be written the run goes on without.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError
from safetensors.numpy import load, save

from mapping.clip.background.pictures import PICTURES_ID, bank
from vizbot.core.errors import ConfigError
from vizbot.core.files import read_regular, user_folder, write_whole

log = logging.getLogger(__name__)

OnProgress = Callable[[int, int], None]
"""A function that is called with the number of pictures embedded so far, and of all."""
_AT_ONCE = 8
"""Pictures in a batch: few, so that progress is seen with a slow encoder, too."""
_LARGEST = 64 * 1024 * 1024
"""Size of a kept bank that is read [bytes]."""
_UNIT = 1e-3
"""Greatest difference of a length from 1."""


@runtime_checkable
class KnownWeights(Protocol):
    """An encoder that can name its weights by a hash, whatever their file is called."""

    def weights_hash(self) -> str:
        """Hash of what embeds pictures: equal hashes give equal embeddings."""
        ...

    def embed_images(self, images: list[NDArray[np.uint8]]) -> NDArray[np.float32]:
        """Embeddings (N, D), unit rows, of N pictures."""
        ...


def kept_bank(encoder: KnownWeights, on_progress: OnProgress) -> NDArray[np.float32]:
    """The bank (B, D), float32, unit rows: as it is kept, else embedded now and then kept."""
    file = bank_file(encoder)
    pictures = bank()
    kept = _read(file, len(pictures))
    if kept is not None:
        return kept
    parts = list[NDArray[np.float32]]()
    for start in range(0, len(pictures), _AT_ONCE):
        on_progress(start, len(pictures))
        parts.append(encoder.embed_images(list(pictures[start : start + _AT_ONCE])))
    embedded = np.concatenate(parts)
    on_progress(len(pictures), len(pictures))
    _write(file, embedded)
    return embedded


def bank_file(encoder: KnownWeights) -> Path:
    """Where the bank of an encoder is kept; it may not be there.

    It is in `$XDG_CACHE_HOME/vizbot/banks` (default `~/.cache`).
    """
    name = f"{encoder.weights_hash()[:32]}-{PICTURES_ID}.safetensors"
    return user_folder("XDG_CACHE_HOME", ".cache") / "banks" / name


def _read(file: Path, pictures: int) -> NDArray[np.float32] | None:
    """What is kept; None where it is not there, or not what was written."""
    try:
        tensors = load(read_regular(file, _LARGEST))
    except FileNotFoundError:
        return None
    except (OSError, SafetensorError, ValueError, KeyError) as error:
        log.info("the bank of pictures kept in %s is made anew: %s", file, error)
        return None
    rows, digest = tensors.get("pictures"), tensors.get("digest")
    if (
        rows is None
        or digest is None
        or (rows.dtype, rows.ndim, len(rows)) != (np.float32, 2, pictures)
        or digest.tobytes() != sha256(rows.tobytes()).digest()
        or not (np.abs(np.linalg.norm(rows, axis=1) - 1.0) < _UNIT).all()
    ):
        log.info("the bank of pictures kept in %s is damaged: it is made anew", file)
        return None
    return np.asarray(rows, np.float32)


def _write(file: Path, rows: NDArray[np.float32]) -> None:
    digest = np.frombuffer(sha256(rows.tobytes()).digest(), np.uint8)
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        write_whole(file, save({"pictures": np.ascontiguousarray(rows), "digest": digest}))
    except (OSError, ConfigError) as error:
        log.warning(
            "the bank of pictures is not kept, so that each run embeds it anew: %s; set"
            " XDG_CACHE_HOME to a folder that can be written",
            " ".join(str(error).split()),
        )
