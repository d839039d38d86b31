"""Whose cosines an encoder has, which options name."""

from __future__ import annotations

from typing import Literal

EncoderScale = Literal["clip", "offset"]
"""`clip`: scaled and shifted to those of ViT-L/14; `offset`: that, with offsets and errors."""
