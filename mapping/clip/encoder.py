"""CLIP encoders: pictures and words to unit vectors that can be compared (paper, section III-A).

`ClipEncoder` is the protocol that mapper and retrieval use; `TransformersClip` runs any CLIP
checkpoint of the Hugging Face hub, or a folder that holds one. Nothing is ever downloaded here.
"""

from __future__ import annotations

import hashlib
import logging
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import torch
from numpy.typing import NDArray
from transformers import CLIPConfig, CLIPModel, CLIPTokenizer, CLIPVisionConfig, CLIPVisionModel
from transformers import __version__ as transformers_version
from transformers.utils import logging as transformers_logging

from mapping.clip.checkpoint.checkpoint import ClipCheckpoint, find_checkpoint
from mapping.clip.checkpoint.self_test import fault_in_use
from mapping.clip.checkpoint.tensors import lacks_memory, read_tensors, reason_of
from mapping.clip.compute_device import compute_device
from mapping.clip.reading import Reading
from vizbot.core.errors import DeviceError

log = logging.getLogger(__name__)

_LARGEST_LOG_SCALE = 10.0
"""Largest logarithm of a scale; CLIP's own ends at 4.6, that of a hundred."""


class TextEncoder(Protocol):
    """Embeds texts in the space of a model's images; enough to ask a saved map."""

    @property
    def model_id(self) -> str:
        """Id of the weights: embeddings of different ids must never be compared."""
        ...

    @property
    def dimension(self) -> int:
        """Length D of an embedding."""
        ...

    @property
    def threshold(self) -> float:
        """Similarity above which an image matches a text, unless the user sets another."""
        ...

    @property
    def log_odds(self) -> tuple[float, float] | None:
        """Scale and bias that make log odds of a similarity, as the model was trained.

        They say how surely an image shows what a text says. None where they are not known.
        """
        ...

    @property
    def notice(self) -> str | None:
        """Warning to show with all results of this encoder; None for models of real pictures."""
        ...

    def embed_texts(self, texts: Sequence[str]) -> NDArray[np.float32]:
        """Embeddings (N, D), unit rows, of N texts."""
        ...

    def reading(self, text: str) -> Reading:
        """How the encoder understands a user's text; unchanged where it knows open words.

        Raises:
            ConfigError: it knows names alone, and has none for this text.
        """
        ...


class ClipEncoder(TextEncoder, Protocol):
    """Embeds images and texts in one space, where the cosine measures how well they match."""

    def embed_images(self, images: Sequence[NDArray[np.uint8]]) -> NDArray[np.float32]:
        """Embeddings (N, D), unit rows, of N RGB images (h, w, 3) of any sizes, in one batch.

        Raises:
            DeviceError: the device has too little memory.
        """
        ...


@dataclass(frozen=True, slots=True)
class ImageInput:
    """Input format of an image tower; the defaults are OpenAI's.

    Attributes:
        size: Edge of the square input [px].
        mean: Of each colour channel over the training pictures, in 0 to 1.
        std: Standard deviation of each colour channel, in 0 to 1.
    """

    size: int = 224
    mean: tuple[float, float, float] = (0.48145466, 0.4578275, 0.40821073)
    std: tuple[float, float, float] = (0.26862954, 0.26130258, 0.27577711)


def to_pixel_values(images: Sequence[NDArray[np.uint8]], image_input: ImageInput) -> torch.Tensor:
    """Resize (bicubic), centre-crop and normalise RGB images as CLIP's own image processor does.

    Images of one shape are resized together, on 8-bit pixels: PyTorch then uses the arithmetic of
    Pillow, which the models were trained with, at a fraction of its time.

    Returns:
        (N, 3, size, size) float32.
    """
    size = image_input.size
    pixels = torch.empty((len(images), 3, size, size), dtype=torch.uint8)
    for shape in {image.shape for image in images}:
        alike = [i for i, image in enumerate(images) if image.shape == shape]
        batch = torch.from_numpy(np.stack([images[i] for i in alike])).permute(0, 3, 1, 2)
        height, width = (size * edge // min(shape[:2]) for edge in shape[:2])
        batch = torch.nn.functional.interpolate(
            batch, (height, width), mode="bicubic", antialias=True
        )
        top, left = (height - size) // 2, (width - size) // 2
        pixels[alike] = batch[..., top : top + size, left : left + size]
    mean, std = (torch.tensor(x).view(3, 1, 1) for x in (image_input.mean, image_input.std))
    return (pixels.float() / 255.0 - mean) / std


class TransformersClip:
    """A `ClipEncoder` on the `transformers` library, on the CPU or a CUDA device."""

    notice: str | None = None

    def __init__(
        self, model_id: str, model: CLIPModel, tokenizer: CLIPTokenizer, image_input: ImageInput
    ) -> None:
        """Wrap a model that is already in memory, on its device and in its precision."""
        self.model_id = model_id
        self.dimension: int = model.config.projection_dim
        # The paper, section IV-C; for other models the patch size decides.
        self.threshold = 0.30 if model.config.vision_config.patch_size == 32 else 0.27
        # It was trained to rank, with a scale and no bias: its threshold stands for even odds.
        scale = float(model.logit_scale.detach().exp())
        self.log_odds: tuple[float, float] | None = (scale, -scale * self.threshold)
        self._model = model.eval()
        self._tokenizer = tokenizer
        self._image_input = image_input
        self._longest_text: int = model.config.text_config.max_position_embeddings

    @torch.inference_mode()
    def embed_images(self, images: Sequence[NDArray[np.uint8]]) -> NDArray[np.float32]:
        """Embeddings (N, D), unit rows, of N RGB images (h, w, 3) of any sizes, in one batch.

        If the device has too little memory for all of them, the batch is split.

        Raises:
            DeviceError: the device has too little memory for a single image.
        """
        if not images:
            return np.zeros((0, self.dimension), np.float32)
        try:
            return self._embedded(images)
        except torch.OutOfMemoryError:
            if len(images) == 1:
                raise DeviceError(
                    f"{self.model_id}: {self._model.device} has no memory left for one image; end"
                    " other programs that use it, or set half = true"
                ) from None
        # Outside of the handler, which keeps the tensors of the batch that was too large.
        torch.cuda.empty_cache()
        half = len(images) // 2
        parts = [self.embed_images(images[:half]), self.embed_images(images[half:])]
        return np.concatenate(parts)

    def _embedded(self, images: Sequence[NDArray[np.uint8]]) -> NDArray[np.float32]:
        pixels = to_pixel_values(images, self._image_input)
        pixels = pixels.to(self._model.device, self._model.dtype)
        pooled = self._model.vision_model(pixel_values=pixels).pooler_output
        return _unit(self._model.visual_projection(pooled))

    @torch.inference_mode()
    def embed_texts(self, texts: Sequence[str]) -> NDArray[np.float32]:
        """Embeddings (N, D), unit rows; a text beyond the model's 77 tokens is cut off there."""
        if not texts:
            return np.zeros((0, self.dimension), np.float32)
        tokens = self._tokenizer(
            list(texts),
            padding=True,
            truncation=True,
            max_length=self._longest_text,
            return_tensors="pt",
        ).to(self._model.device)
        pooled = self._model.text_model(
            input_ids=tokens["input_ids"], attention_mask=tokens["attention_mask"]
        ).pooler_output
        return _unit(self._model.text_projection(pooled))

    def reading(self, text: str) -> Reading:
        """The text as it is: CLIP knows open words."""
        return Reading(text)

    def weights_hash(self) -> str:
        """Hash of the weights in their precision, and of the input format.

        It is the same for one set of weights in files of any kind. It takes about a second for each
        GB of weights.
        """
        found = hashlib.sha256(repr(self._image_input).encode())
        for name, tensor in sorted(self._model.state_dict().items()):
            found.update(f"{name} {tensor.dtype} {tuple(tensor.shape)}".encode())
            found.update(tensor.detach().cpu().contiguous().numpy())
        return found.hexdigest()


def load_clip(name: str, device: str = "auto", half: bool = False) -> TransformersClip:
    """Load a CLIP checkpoint that is on this machine, and try it; the network is never used.

    A pickle is read by its tensors alone, after a warning in the log.

    Args:
        name: A short name (`ViT-B/32`, `ViT-L/14`), a hub name, or a folder.
        device: `cpu`, `cuda`, `cuda:1`, or `auto`: CUDA where there is a device.
        half: Compute in 16-bit floating point (for CUDA; on a CPU it only saves memory).

    Raises:
        ConfigError: the weights are missing, damaged, not those of a CLIP model, or too large for
            the memory; what they compute distinguishes nothing; or there is no such device.
    """
    chosen = compute_device(device)
    checkpoint = find_checkpoint(name)
    if checkpoint.remark is not None:
        log.warning("%s", checkpoint.remark)
    with _quiet_transformers():
        model = _model_of(checkpoint, torch.float16 if half else torch.float32)
        tokenizer = _tokenizer_of(checkpoint, model)
        try:
            model = model.to(chosen)
        except torch.OutOfMemoryError as error:
            raise checkpoint.refused(f"does not fit into the memory of {chosen}") from error
    settings = checkpoint.image_settings
    image_input = ImageInput(
        model.config.vision_config.image_size, settings.image_mean, settings.image_std
    )
    encoder = TransformersClip(checkpoint.source, model, tokenizer, image_input)
    try:
        fault = fault_in_use(encoder)
    except DeviceError as error:
        raise checkpoint.refused(f"cannot be used: {error}") from error
    if fault is not None:
        raise checkpoint.refused(fault)
    return encoder


def _model_of(checkpoint: ClipCheckpoint, dtype: torch.dtype) -> CLIPModel:
    """The model with the weights of a checkpoint, on the CPU."""
    tensors = read_tensors(checkpoint)
    try:
        model, report = CLIPModel.from_pretrained(
            None,
            config=CLIPConfig.from_dict(checkpoint.config),
            state_dict=tensors,
            dtype=dtype,
            output_loading_info=True,
            ignore_mismatched_sizes=True,  # they are reported below, by name
        )
    except Exception as error:  # the library raises anything for settings that it does not know
        if lacks_memory(error):
            raise checkpoint.refused("does not fit into this computer's memory") from error
        fault = f"is none that transformers {transformers_version} can build"
        raise checkpoint.refused(f"{fault} ({reason_of(error)})") from error
    names = sorted(model.state_dict())
    # The library fills what is missing with random numbers.
    if missing := sorted(report["missing_keys"]):
        if len(missing) == len(names):
            first = next(iter(sorted(tensors)), "nothing")
            raise checkpoint.refused(f"has weights of another model, of {first} and not {names[0]}")
        fault = f"lacks {len(missing)} of its {len(names)} tensors, {missing[0]} first"
        raise checkpoint.refused(f"is incomplete: it {fault}")
    if other := sorted(report["mismatched_keys"]):
        tensor, found, wanted = other[0]
        fault = f"{tensor} is {_shape(found)}, by config.json {_shape(wanted)}"
        raise checkpoint.refused(f"has weights of another architecture: {fault}")
    if not abs(float(model.logit_scale.detach())) < _LARGEST_LOG_SCALE:  # nor is NaN
        raise checkpoint.refused("has a scale of similarities that no training leaves")
    built: CLIPModel = model
    return built


def _tokenizer_of(checkpoint: ClipCheckpoint, model: CLIPModel) -> CLIPTokenizer:
    try:
        tokenizer = CLIPTokenizer.from_pretrained(checkpoint.tokenizer, local_files_only=True)
        tokenizer(["of one length", "or another"], padding=True)  # there may be no token for it
        largest = max(tokenizer.get_vocab().values())
    except Exception as error:  # the library has no narrower one
        fault = f"has a tokenizer that transformers {transformers_version} cannot read"
        raise checkpoint.refused(f"{fault} ({reason_of(error)})") from error
    if largest >= model.config.text_config.vocab_size:
        raise checkpoint.refused("has a tokenizer with words that its text tower does not know")
    read: CLIPTokenizer = tokenizer
    return read


def _shape(size: Sequence[int]) -> str:
    return " x ".join(map(str, size)) or "one number"


def untrained_images(device: str, half: bool) -> Callable[[Sequence[NDArray[np.uint8]]], None]:
    """An image encoder like ViT-B/32 with random weights, which takes as long as with real ones.

    Raises:
        ConfigError: there is no such device.
    """
    chosen, dtype = compute_device(device), torch.float16 if half else torch.float32
    with torch.device("meta"):
        tower = CLIPVisionModel(CLIPVisionConfig())  # the library's default is that of ViT-B/32
    tower = tower.to(dtype).to_empty(device=chosen).eval()
    with torch.no_grad():
        for each in tower.parameters():
            each.fill_(0.01)
        for positions in tower.buffers():
            positions.copy_(torch.arange(positions.numel()))

    @torch.inference_mode()
    def embed(images: Sequence[NDArray[np.uint8]]) -> None:
        pixels = to_pixel_values(images, ImageInput()).to(chosen, dtype)
        tower(pixel_values=pixels).pooler_output.cpu()

    return embed


def gpu_name() -> str | None:
    """Name of the first CUDA device; None if there is none."""
    return torch.cuda.get_device_name(0) if torch.cuda.is_available() else None


def _unit(features: torch.Tensor) -> NDArray[np.float32]:
    # In 16 bits the sum of squares may overflow.
    unit = torch.nn.functional.normalize(features.float(), dim=-1).cpu().numpy()
    if not np.isfinite(unit).all():
        raise DeviceError(
            "the CLIP model computes what is no number: its weights are damaged; fetch them again"
        )
    return np.asarray(unit, np.float32)


@contextmanager
def _quiet_transformers() -> Iterator[None]:
    """Silence the library: its progress bars and reports break `--json` and one-line errors."""
    verbosity = transformers_logging.get_verbosity()
    bars = transformers_logging.is_progress_bar_enabled()
    transformers_logging.set_verbosity(transformers_logging.CRITICAL)
    transformers_logging.disable_progress_bar()
    try:
        yield
    finally:
        transformers_logging.set_verbosity(verbosity)
        if bars:
            transformers_logging.enable_progress_bar()
