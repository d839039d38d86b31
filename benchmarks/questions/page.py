"""`docs/results/questions.md`: what an encoder makes of real pictures."""

from __future__ import annotations

from pathlib import Path

from benchmarks.harness.store import Store
from benchmarks.questions.bench import RecordingAnswers, questions_result

_TITLE = """# Questions to a real recording

`vizbot bench questions SEQ --questions FILE` maps a recording, asks its map once for each thing in
the file, and holds the first place of each answer against the places that a person marked in the
pictures ([the questions of the walk through an office](questions/hololens_office.toml)). With
`--clip FOLDER` another CLIP answers the same questions: so one sees what real weights give.

The embedded encoder was trained on simulated homes alone. It is there for rehearsals, and on real
pictures not to be relied on: this is how far it goes."""
_BY_SIMILARITY = """The scores are similarities, -1 to 1, by which the robot of that commit decided.
Today's decides by probabilities, and by similarities with the method `paper` alone."""


def questions_page(folder: Path, page: Path) -> str:
    """The page of the newest answers on each recording; empty without any.

    Args:
        folder: Folder of the kept answers.
        page: The file that the text is for.
    """
    newest = {line.result.recording: line for line in Store(
        folder / "answers.jsonl", RecordingAnswers
    ).all()}  # fmt: skip
    if not newest:
        return ""
    parts = [_TITLE]
    for name, line in newest.items():
        parts += [f"## {name}", f"Commit {line.commit}."]
        if line.result.score_kind == "similarity":
            parts.append(_BY_SIMILARITY)
        parts.append(questions_result(line.result).text)
    return "\n\n".join([*parts, ""])
