"""`docs/results/questions.md`: what an encoder makes of real pictures."""

from __future__ import annotations

from pathlib import Path

from benchmarks.harness.store import Store
from benchmarks.questions.bench import RecordingAnswers, questions_result

_TEXT = """`vizbot bench questions SEQ --questions FILE` maps a recording, asks its map once for
each thing in the file, and compares the first place of each answer with the places that a person
marked in the pictures ([questions of the walk through an office](questions/hololens_office.toml)).
With `--clip FOLDER` another CLIP answers the same questions, so that one sees what real weights
give. The embedded encoder was trained on simulated homes alone: it is there for rehearsals, and not
to be relied on in real pictures."""
_BY_SIMILARITY = "The scores are similarities, -1 to 1, by which the robot of that commit decided."


def questions_page(folder: Path, page: Path) -> str:
    """The page of the newest answers on each recording; empty without any."""
    newest = {line.result.recording: line for line in Store(
        folder / "answers.jsonl", RecordingAnswers
    ).all()}  # fmt: skip
    if not newest:
        return ""
    parts = ["# Questions to a real recording"]
    for name, line in newest.items():
        parts += [f"## {name}", questions_result(line.result).text, f"Commit {line.commit}."]
        if line.result.score_kind == "similarity":
            parts.append(_BY_SIMILARITY)
    return "\n\n".join([*parts, _TEXT, ""])
