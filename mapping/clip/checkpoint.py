"""Where a CLIP checkpoint is, and its configuration, checked before anything of its size is loaded.

Nothing here needs PyTorch, so that a model which is not on this machine is refused at once.
"""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

from vizbot.core.errors import ConfigError

SHORT_NAMES = {
    "ViT-B/32": "openai/clip-vit-base-patch32",
    "ViT-L/14": "openai/clip-vit-large-patch14",
}
"""The paper's names of the models, and their repositories on the Hugging Face hub."""
_EXAMPLE = SHORT_NAMES["ViT-B/32"]
_CLIP_ALONE = 'give a CLIP model, whose config.json has "model_type": "clip"'

_Width = Annotated[int, Field(gt=0, le=16_384, strict=True)]
_Layers = Annotated[int, Field(gt=0, le=128, strict=True)]


class _Tower(BaseModel):
    """What decides how large a tower is; absent values are the library's own."""

    model_config = ConfigDict(extra="ignore")

    hidden_size: _Width | None = None
    intermediate_size: Annotated[int, Field(gt=0, le=65_536, strict=True)] | None = None
    num_hidden_layers: _Layers | None = None
    num_attention_heads: _Layers | None = None
    projection_dim: _Width | None = None
    vocab_size: Annotated[int, Field(gt=0, le=1_000_000, strict=True)] | None = None
    max_position_embeddings: _Width | None = None
    num_channels: Annotated[int, Field(ge=3, le=3, strict=True)] | None = None
    image_size: Annotated[int, Field(gt=0, le=2048, strict=True)] | None = None
    patch_size: Annotated[int, Field(gt=0, le=2048, strict=True)] | None = None


class _Checkpoint(BaseModel):
    model_config = ConfigDict(extra="ignore")

    projection_dim: _Width | None = None
    text_config: _Tower = _Tower()
    vision_config: _Tower = _Tower()


class ImageSettings(BaseModel):
    """`preprocessor_config.json`: mean and standard deviation of each colour, 0 to 1."""

    model_config = ConfigDict(extra="ignore")

    image_mean: tuple[FiniteFloat, FiniteFloat, FiniteFloat]
    image_std: tuple[
        Annotated[FiniteFloat, Field(gt=0.0)],
        Annotated[FiniteFloat, Field(gt=0.0)],
        Annotated[FiniteFloat, Field(gt=0.0)],
    ]


def require_plausible(config: Any) -> None:
    """Refuse sizes that no CLIP has, 16 times those of the largest one.

    Args:
        config: The content of `config.json`.

    Raises:
        ValueError: a size is none, or too large.
    """
    _Checkpoint.model_validate(config)


@dataclass(frozen=True, slots=True)
class ClipCheckpoint:
    """A CLIP model on this machine.

    Attributes:
        source: Name on the Hugging Face hub, or absolute path of a folder.
        config: The content of its `config.json`.
        remedy: What to do where it turns out to be unusable.
    """

    source: str
    config: dict[str, Any]
    remedy: str

    def file(self, name: str) -> dict[str, Any]:
        """The content of a JSON file of the model.

        Raises:
            OSError: it is not there.
            ValueError: it is not JSON.
        """
        return _json_file(self.source, name)


def find_checkpoint(name: str) -> ClipCheckpoint:
    """The CLIP model of a name.

    Args:
        name: A short name (`ViT-B/32`, `ViT-L/14`), a hub name, or a folder.

    Raises:
        ConfigError: there is no such model on this machine, or it is not CLIP.
    """
    folder = Path(name).expanduser()
    if name and folder.is_dir():
        source = str(folder.resolve())
        remedy = f"give a folder as filled by: hf download {_EXAMPLE} --local-dir FOLDER"
    else:
        source = SHORT_NAMES.get(name, name)
        fetched = f"fetch it with: hf download {source}"
        known = source in SHORT_NAMES.values()
        remedy = fetched if known else f"{_CLIP_ALONE}; if it is one, {fetched}"
        if not re.fullmatch(r"[\w.-]+/[\w.-]+", source):
            raise ConfigError(
                f"no CLIP model {name!r}: give {' or '.join(SHORT_NAMES)}, a hub name like"
                f" {_EXAMPLE}, or an existing folder"
            )
    try:
        config = dict(_json_file(source, "config.json"))
    except (OSError, ValueError, TypeError) as error:
        raise ConfigError(f"no CLIP weights for {source} on this machine: {remedy}") from error
    kind = config.get("model_type")
    if kind != "clip":
        raise ConfigError(
            f"{source} holds a {kind} model, which cannot be used: {_CLIP_ALONE}, such as"
            f" {' or '.join(SHORT_NAMES)}"
        )
    return ClipCheckpoint(source, config, remedy)


def _json_file(source: str, filename: str) -> dict[str, Any]:
    path = Path(source) / filename
    if not Path(source).is_absolute():
        from huggingface_hub import try_to_load_from_cache

        cached = try_to_load_from_cache(source, filename)
        if not isinstance(cached, str):
            raise FileNotFoundError(filename)
        path = Path(cached)
    content: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return content
