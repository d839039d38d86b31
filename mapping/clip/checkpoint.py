"""The configuration of a CLIP checkpoint, checked before anything of its size is allocated."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

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
