"""Settings of the CLIP map."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, model_validator

from vizbot.core.settings import BASIC, Settings


class ClipMapperConfig(Settings):
    """Patches of a frame."""

    patch_size: int = Field(default=224, ge=8, le=4096, json_schema_extra=BASIC)
    """A patch at scale 0 (the paper's S) is this wide, whatever the encoder's input size [px]."""
    scales: tuple[Annotated[int, Field(ge=-12, le=12)], ...] = Field(
        default=(1, 0, -1), min_length=1, json_schema_extra=BASIC
    )
    """Patches are 2^i `patch_size` pixels wide at scale i, and these are the scales [1]."""
    min_depth_share: float = Field(default=0.1, ge=0.001, le=1.0)
    """At least this share of a patch's pixels must have depth; a patch with less has no point and
    is dropped [1]."""

    @model_validator(mode="after")
    def _whole_pixels(self) -> Self:
        for scale in self.scales:
            if not (self.patch_size * 2.0**scale).is_integer():
                raise ValueError(
                    f"scale {scale} of patch_size {self.patch_size} is not whole pixels"
                )
        return self

    def patch_sizes(self) -> list[int]:
        """Edges s_i of the patches [px], one for each scale."""
        return [int(self.patch_size * 2.0**scale) for scale in self.scales]
