"""`docs/results/encoder.md`: what encoders said of patches, as kept, in tables and on pages."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from benchmarks.encoder.families import FAMILIES_FILE, FamilyTable, families_result
from benchmarks.encoder.separation import Separation, mean_over_names
from benchmarks.harness.store import Store, StoredResult
from benchmarks.harness.tables import markdown_table
from training.evaluation import SCALES

Kind = Literal["own", "others", "trained", "recording"]
TITLES: dict[Kind, str] = {
    "own": "own homes",
    "others": "homes by others",
    "trained": "homes by others, to train on",
}
"""Names of the groups of homes."""
_TEXT = """`vizbot bench encoder` asks patches of pictures for the paper's goals by bare names. A
patch shows a thing clearly, does not show it, or is left out as disputable. AUC is the
probability that a patch that shows a thing clearly is more similar to its name than one that does
not; recall is the share of the former above the similarity that one in a hundred of the latter
exceeds; both are means over names, and chance gives 0.5 and 0.01. Right at a scale is the share of
patches that are named rightly among all names. In recordings patches are those of the mapper, and
what they show follows from a person's marks."""
_FAMILIES = """## Encoders that nothing was fitted to

`vizbot bench encoder --families embedded,photos` judges what is believed of places in homes 932 to
937, which no number was fitted in: by numbers that were fitted to the encoders of the other family
alone, by those that come along, and by those that were fitted to the encoder itself. `weak` has
noise in its pictures, `offset` errors in its cosines as another encoder has, `unknown` is without
scale and bias. The calibration error is the mean difference of what is believed and what is
true."""


@dataclass(frozen=True, slots=True)
class Asked:
    """What an encoder said of the patches of one home or recording, or of several together.

    Attributes:
        source: Name of the home, the recording, or the group of homes.
        kind: Who drew it, and whether it is to train on.
        whole: Whether it is a group, or a recording.
        patches: Number of patches.
        names: How well each name is told apart, by the name.
        seen_models: In homes by others the same by patches of a model that is also in a home to
            train on.
        new_models: The same by patches of any other model.
        zero_shot: Share of patches named rightly among the names, by the scale.
        calibration_error: Of the encoder's own probabilities; None where it has none.
        own_poses: Whether marks were placed by poses of our own SLAM, as none were recorded.
    """

    source: str
    kind: Kind
    whole: bool
    patches: int
    names: dict[str, Separation]
    seen_models: dict[str, Separation]
    new_models: dict[str, Separation]
    zero_shot: dict[int, float]
    calibration_error: float | None
    own_poses: bool = False


@dataclass(frozen=True, slots=True)
class EncoderAnswers:
    """All that one encoder said.

    Attributes:
        encoder: Id of the weights.
        ms_a_frame: Median time of a frame of 640 x 480 pixels on this machine [ms].
        sources: Homes, groups of homes, and recordings.
    """

    encoder: str
    ms_a_frame: float
    sources: tuple[Asked, ...]


def answers_store(folder: Path) -> Store[EncoderAnswers]:
    """What encoders said, as kept in a folder."""
    return Store(folder / "encoder.jsonl", EncoderAnswers)


def answers_text(answers: EncoderAnswers) -> str:
    """The tables of what an encoder said."""
    whole = {source.source: source.names for source in answers.sources if source.whole}
    parts = [
        f"`{answers.encoder}`, {answers.ms_a_frame:.0f} ms a frame on this machine.",
        _sources_table(answers.sources),
        _names_table(("recall of", *whole), [*whole.values()], _recall),
        *_split_tables(answers.sources),
    ]
    return "\n\n".join(parts)


def _sources_table(sources: Sequence[Asked]) -> str:
    """A row for each source, the homes of a group below it."""
    header = ("where", "patches", "names", "AUC", "recall", "above even odds",
              *(f"right at scale {scale}" for scale in SCALES), "calibration error")  # fmt: skip
    return markdown_table(
        header,
        [
            [
                ("" if source.whole else "- ")
                + source.source
                + (", placed by our own SLAM" if source.own_poses else ""),
                source.patches,
                len(source.names),
                _three(mean_over_names(source.names, "auc")),
                mean_over_names(source.names, "recall"),
                mean_over_names(source.names, "above_even"),
                *(source.zero_shot.get(scale) for scale in SCALES),
                _three(source.calibration_error),
            ]
            for source in sources
        ],
    )


def _names_table(
    header: Sequence[str],
    columns: Sequence[Mapping[str, Separation]],
    *figures: Callable[[Separation], str | None],
) -> str:
    """A row for each name, with these figures of each column's."""
    names = dict.fromkeys(name for column in columns for name in column)

    def cells(name: str) -> list[str | None]:
        return [of(each[name]) if name in each else None for each in columns for of in figures]

    return markdown_table(header, [[name, *cells(name)] for name in names])


def _recall(found: Separation) -> str:
    """Recall of a name, and how many patches that is of."""
    return f"{found.recall:.2f} of {found.clear}"


def _split_tables(sources: Sequence[Asked]) -> list[str]:
    """Names of which both models of homes to train on and others are there; none without any."""
    if not (split := [source for source in sources if source.seen_models]):
        return []
    header = ("homes", "models", "names", "AUC", "recall")
    rows = []
    for source in split:
        both = source.seen_models.keys() & source.new_models.keys()
        for title, found in (("to train on", source.seen_models), ("others", source.new_models)):
            kept = {name: found[name] for name in sorted(both)}
            auc, recall = (mean_over_names(kept, of) for of in ("auc", "recall"))
            rows.append([source.source, title, len(kept), _three(auc), recall])
    return [markdown_table(header, rows)]


def _three(value: float | None) -> str | None:
    return None if value is None else f"{value:.3f}"


def homes_by_others(folder: Path) -> str:
    """A section with the newest answers of each encoder in homes by others, by classes of things.

    The models of furniture of those that judge are split by whether a home to train on has them,
    where the encoder was asked in both together. Empty where no encoder was asked there.
    """
    parts = []
    for line in _newest(folder):
        sources = [each for each in line.result.sources if each.kind in ("others", "trained")]
        if sources:
            parts += [
                f"`{line.result.encoder}`, commit {line.commit}:",
                _sources_table(sources),
                *_split_tables(sources),
                _classes_table([each for each in sources if each.whole]),
            ]
    text = "[What recall and AUC are](encoder.md) of patches, by bare names."
    return "\n\n".join(["## Patches of homes by others", text, *parts]) if parts else ""


def _classes_table(groups: Sequence[Asked]) -> str:
    """Recall at 1 % false, with the number of patches, and AUC of each thing, by its models."""
    columns = {}
    for group in groups:
        columns[group.source] = group.names
        if group.seen_models or group.new_models:
            columns["their models that homes to train on have"] = group.seen_models
            columns["their other models"] = group.new_models
    header = ("thing", *(f"{title}: {of}" for title in columns for of in ("recall", "AUC")))
    return _names_table(header, [*columns.values()], _recall, lambda found: _three(found.auc))


def _newest(folder: Path) -> list[StoredResult[EncoderAnswers]]:
    """The newest answers of each encoder."""
    return answers_store(folder).newest(lambda each: each.encoder)


def encoder_page(folder: Path, page: Path) -> str:
    """The page of the newest answers of each encoder; empty without any."""
    parts = [
        f"## {line.result.encoder}\n\n{answers_text(line.result)}\n\n"
        f"Commit {line.commit}, {line.hardware}."
        for line in _newest(folder)
    ]
    if kept := Store(folder / FAMILIES_FILE, FamilyTable).all():
        parts += [_FAMILIES, families_result(kept[-1].result).text, f"Commit {kept[-1].commit}."]
    return "\n\n".join(["# Encoders", _TEXT, *parts, ""]) if parts else ""
