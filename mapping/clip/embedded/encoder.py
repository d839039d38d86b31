"""The embedded CLIP: a real one, small enough to ship, for rehearsals in simulated homes.

`training` makes its weights. The image tower starts from ImageNet and both towers
are trained on pictures of simulated homes: it is not meant for real pictures, and says so.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from safetensors.torch import load as load_tensors
from tokenizers import Tokenizer

from mapping.clip.efficientnet import middle_squares
from mapping.clip.embedded.model_files import WEIGHTS, EmbeddedFiles, damaged_files, read_files
from mapping.clip.embedded.text_encoder import DIMENSION, NOTICE, token_ids
from mapping.clip.embedded.towers import INPUT_SIZE, Clip
from mapping.clip.embedded.word_table import read_goal
from mapping.clip.reading import Reading


class EmbeddedClip:
    """A `ClipEncoder` that runs anywhere."""

    dimension = DIMENSION
    notice: str | None = NOTICE

    def __init__(
        self,
        model_id: str,
        model: Clip,
        tokenizer: Tokenizer,
        threshold: float,
        words: frozenset[str] = frozenset(),
    ) -> None:
        """Wrap a model in memory.

        Args:
            model_id: Names the weights.
            model: Both towers, on the CPU.
            tokenizer: Splits texts into the text tower's tokens.
            threshold: Similarity above which an image shows what a text says.
            words: Words of the phrasings that it was trained on.
        """
        self.model_id = model_id
        self.threshold = threshold
        self.log_odds: tuple[float, float] | None = (
            math.exp(float(model.log_scale.detach())),
            float(model.bias.detach()),
        )
        self.model = model.eval()
        model.image_tower.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
        self.tokenizer = tokenizer
        self._words = words

    @torch.inference_mode()
    def embed_images(self, images: Sequence[NDArray[np.uint8]]) -> NDArray[np.float32]:
        """Embeddings (N, 256), unit rows, of N RGB images (h, w, 3) of any sizes, in one batch."""
        if not images:
            return np.zeros((0, DIMENSION), np.float32)
        return np.asarray(
            self.model.image_tower(to_values(torch.from_numpy(to_pixels(images)))).numpy(),
            np.float32,
        )

    @torch.inference_mode()
    def embed_texts(self, texts: Sequence[str]) -> NDArray[np.float32]:
        """Embeddings (N, 256), unit rows; a text beyond 24 tokens is cut off there."""
        if not texts:
            return np.zeros((0, DIMENSION), np.float32)
        ids = to_ids(self.tokenizer, texts)
        return np.asarray(self.model.text_tower(ids).numpy(), np.float32)

    def reading(self, text: str) -> Reading:
        """The text with nouns that were not trained looked up in a table of words."""
        return read_goal(text, self._words)


def load_embedded_clip(folder: Path = WEIGHTS) -> EmbeddedClip:
    """The embedded model.

    Raises:
        ConfigError: its files are missing or damaged.
    """
    return open_embedded_clip(read_files(folder))


def open_embedded_clip(files: EmbeddedFiles) -> EmbeddedClip:
    """The model of these files.

    Raises:
        ConfigError: the weights are damaged.
    """
    try:
        tensors = load_tensors(files.weights)
        model = Clip(files.tokenizer.get_vocab_size())
        model.load_state_dict({name: tensor.float() for name, tensor in tensors.items()})
    except Exception as error:  # the libraries raise whatever a damaged file leads them into
        raise damaged_files(files.folder) from error
    return EmbeddedClip(files.model_id, model, files.tokenizer, files.threshold, files.words)


def to_pixels(images: Sequence[NDArray[np.uint8]]) -> NDArray[np.uint8]:
    """The middle squares (N, 96, 96, 3) of RGB images (h, w, 3)."""
    return middle_squares(images, INPUT_SIZE)


def to_values(pixels: torch.Tensor) -> torch.Tensor:
    """Values (N, 3, H, W) in -1 to 1, channels last in memory, of RGB pixels (N, H, W, 3) uint8."""
    return pixels.permute(0, 3, 1, 2).float() / 127.5 - 1.0


def to_ids(tokenizer: Tokenizer, texts: Sequence[str]) -> torch.Tensor:
    """Token ids (N, L) of texts, 0 behind the end of each."""
    return torch.from_numpy(token_ids(tokenizer, texts))
