"""Which encoder suits which computer, for the settings file and docs/robot.md."""

from __future__ import annotations

from dataclasses import dataclass

from mapping.clip.checkpoint.checkpoint import SHORT_NAMES, find_checkpoint
from vizbot.core.errors import ConfigError


@dataclass(frozen=True, slots=True)
class EncoderChoice:
    """An encoder on a computer.

    Attributes:
        computer: What it runs on.
        frame: Time for the 25 patches of a frame [s].
        meaning: What that means for a search.
    """

    computer: str
    encoder: str
    frame: float
    meaning: str


CHOICES = (
    EncoderChoice(
        "an NVIDIA GPU (an H200)",
        'clip = "ViT-L/14", device = "cuda", half = true',
        0.017,
        "every frame is looked at",
    ),
    EncoderChoice(
        "a PC or a NUC (one core of Zen 4; more cores take less)",
        'clip = "ViT-B/32"',
        2.9,
        "a look in 1.5 m at full speed, two in the first turn: it may pass a thing by",
    ),
    EncoderChoice(
        "16 cores of a server",
        'clip = "ViT-L/14"',
        4.7,
        "a look in 2.4 m at full speed, one or two in the first turn: ViT-B/32 sees more",
    ),
    EncoderChoice(
        "a PC or a NUC (one core of Zen 4)",
        'clip = "ViT-L/14"',
        53.0,
        "a look in a minute: most of a home is passed by unseen; do not take it",
    ),
    EncoderChoice(
        "any",
        'clip = "embedded"',
        0.065,
        "for rehearsals: it knows simulated homes alone, and launch refuses it",
    ),
)
"""As measured (docs/hardware.md); distances follow from the speed limits."""


def choices_text() -> list[str]:
    """The table in lines of plain text, two for each encoder."""
    lines = ["Choose the encoder: computer; seconds for a frame; what that means for a search."]
    for each in CHOICES:
        lines.append(f"  {each.encoder}")
        lines.append(f"    {each.computer}; {each.frame:g} s; {each.meaning}")
    return lines


def fetched_encoders() -> list[str]:
    """The published encoders that are on this machine, by their short names; none is loaded."""
    found = []
    for name in SHORT_NAMES:
        try:
            find_checkpoint(name)
        except ConfigError:
            continue
        found.append(name)
    return found
