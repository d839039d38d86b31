"""Whose cosines an encoder has, which options name."""

from __future__ import annotations

from typing import Literal

EncoderScale = Literal["clip", "offset", "unknown"]
"""`clip`: scaled and shifted to those of ViT-L/14; `offset`: that, with offsets and errors;
`unknown`: those of `clip`, of an encoder that does not tell its scale and bias."""
