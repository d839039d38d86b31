"""Real pictures by the classes of a classifier of photographs, as an encoder.

A picture is the square root of the probabilities of its classes, which has unit length.
"""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from hashlib import sha256

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn

from mapping.clip.compute_device import compute_device
from mapping.clip.efficientnet import (
    FEATURES,
    Layers,
    Variant,
    fold_published,
    middle_squares,
    pooled_features,
    untrained_layers,
)
from mapping.clip.photos.fit import photo_fit
from mapping.clip.photos.names import CLASSES
from mapping.clip.photos.text_encoder import PhotoTexts
from mapping.clip.photos.weights import (
    keep_tensors,
    kept_tensors,
    published_pickle,
)
from mapping.clip.reading import Reading

INPUT_SIZE = 260
"""Edge of the square input [px]."""
_LITE2 = Variant(width=1.1, depth=1.2, same=True)
_AT_ONCE = 8
"""Pictures of a batch: more are no faster on a processor."""


class Classifier(nn.Module):
    """EfficientNet-Lite2: images (N, 3, 260, 260), values in -1 to 1, to logits (N, 1000)."""

    def __init__(self) -> None:
        super().__init__()
        self.stem, self.blocks, self.head = untrained_layers(_LITE2)
        self.classes = nn.Linear(FEATURES, CLASSES)

    def forward(self, images: torch.Tensor) -> torch.Tensor:
        """Classify."""
        features = pooled_features(Layers(self.stem, self.blocks, self.head), images)
        logits: torch.Tensor = self.classes(features)
        return logits

    def start_from(self, checkpoint: Mapping[str, torch.Tensor]) -> None:
        """Take over the published weights, as `efficientnet.fold_published`."""
        fold_published(Layers(self.stem, self.blocks, self.head), checkpoint)
        with torch.no_grad():
            self.classes.weight.copy_(checkpoint["_fc.weight"])
            self.classes.bias.copy_(checkpoint["_fc.bias"])


class PhotoClasses:
    """A `ClipEncoder` of a thousand names, on the CPU or a CUDA device."""

    def __init__(self, tensors: Mapping[str, NDArray[np.float32]], device: torch.device) -> None:
        """Load a classifier.

        Args:
            tensors: Its state.
            device: Where it computes, in 32 bits.
        """
        self._texts = PhotoTexts()
        self.model_id, self.dimension = self._texts.model_id, CLASSES
        self.threshold, self.log_odds = self._texts.threshold, self._texts.log_odds
        self.notice = self._texts.notice
        self._temperature = photo_fit().temperature
        self._device = device
        with torch.device("meta"):  # random weights would take longer than these
            self._classifier = Classifier().eval()
        state = {name: torch.from_numpy(tensor) for name, tensor in tensors.items()}
        self._classifier.load_state_dict(state, assign=True)
        self._classifier.to(device, memory_format=torch.channels_last)  # type: ignore[call-overload]

    @torch.inference_mode()
    def logits(self, images: Sequence[NDArray[np.uint8]]) -> NDArray[np.float32]:
        """Logits (N, 1000) of N RGB images (h, w, 3) of any sizes."""
        rows = [np.zeros((0, CLASSES), np.float32)]
        for start in range(0, len(images), _AT_ONCE):
            squares = middle_squares(images[start : start + _AT_ONCE], INPUT_SIZE)
            pixels = torch.from_numpy(squares).to(self._device)
            values = (pixels.permute(0, 3, 1, 2).float() - 127.0) / 128.0
            rows.append(self._classifier(values).cpu().numpy())
        return np.concatenate(rows)

    def embed_images(self, images: Sequence[NDArray[np.uint8]]) -> NDArray[np.float32]:
        """Embeddings (N, 1000), unit rows, of N RGB images (h, w, 3) of any sizes."""
        return root_probabilities(self.logits(images), self._temperature)

    def embed_texts(self, texts: Sequence[str]) -> NDArray[np.float32]:
        """Embeddings (N, 1000), unit rows; a text without a name is like no picture."""
        return self._texts.embed_texts(texts)

    def reading(self, text: str) -> Reading:
        """The name that a text ends with.

        Raises:
            ConfigError: it has none.
        """
        return self._texts.reading(text)

    def weights_hash(self) -> str:
        """Hash of all that embeds, the same as that of `PhotoTexts`: of the id that names it."""
        return sha256(self.model_id.encode()).hexdigest()


def root_probabilities(logits: NDArray[np.float32], temperature: float) -> NDArray[np.float32]:
    """Square roots of the softmax of logits (N, 1000) over a temperature."""
    tempered = logits / np.float32(temperature)
    roots = np.exp((tempered - tempered.max(axis=1, keepdims=True)) / 2.0)
    return np.asarray(roots / np.linalg.norm(roots, axis=1, keepdims=True), np.float32)


def open_photo_classes(device: str) -> PhotoClasses:
    """The encoder with the weights of this machine; those of the package are kept as they are read.

    Raises:
        ConfigError: there are none, they are damaged, or there is no such device.
    """
    chosen = compute_device(device)
    tensors = kept_tensors()
    if tensors is None:
        tensors = converted(published_pickle())
        keep_tensors(tensors)
    return PhotoClasses(tensors, chosen)


def converted(pickle: bytes) -> dict[str, NDArray[np.float32]]:
    """The state of a `Classifier` by the published file, of which tensors alone are read."""
    classifier = Classifier()
    classifier.start_from(torch.load(io.BytesIO(pickle), map_location="cpu", weights_only=True))
    return {name: tensor.numpy() for name, tensor in classifier.state_dict().items()}
