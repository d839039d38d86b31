"""Evaluation of an embedded CLIP on homes and furniture that it was not trained on.

`python -m sim_stubs.clip.training.evaluation` takes pictures of benchmark homes and
prints the figures.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from mapping.clip.encoder import ClipEncoder
from sim_stubs.clip.encoder import WEIGHTS, load_embedded_clip
from sim_stubs.clip.training.captions.captions import target
from sim_stubs.clip.training.captions.facts import FACT_INDEX, Facts
from sim_stubs.clip.training.captions.held_out_questions import (
    WITHHELD_COMBINATIONS,
    WITHHELD_PHRASINGS,
    Question,
)
from sim_stubs.clip.training.captions.unrelated_words import HELD_OUT_WORDS
from sim_stubs.clip.training.views import LabelledPatches, take_all
from sim_stubs.homes.vocabulary import EVALUATION_CLASSES

SCALES: Mapping[int, tuple[int, int]] = {1: (380, 481), 0: (190, 271), -1: (90, 141)}
"""Edges of the patches [px] that stand for each of the paper's scales."""
CLEARLY = 0.6
"""Least strength of the class of a patch."""
GOALS = 16
"""Number of the paper's goals, the first of the classes."""


@dataclass(frozen=True, slots=True)
class Accuracy:
    """Zero-shot classification at one scale.

    Attributes:
        scale: Scale of the paper: patches are about 2^scale times 224 px wide.
        patches: Number of patches that show one of the classes clearly.
        overall: Share of them whose most similar class is truly shown.
        by_class: The same for each class that is the clearest in three patches at least.
    """

    scale: int
    patches: int
    overall: float
    by_class: dict[str, float]

    @property
    def mean(self) -> float:
        """Averaged over classes, which counts rare ones as much as common ones."""
        return float(np.mean(list(self.by_class.values())))


def zero_shot(
    embeddings: NDArray[np.float32],
    views: LabelledPatches,
    encoder: ClipEncoder,
    classes: Sequence[str],
) -> list[Accuracy]:
    """Accuracy, at each scale, of naming a patch by the class whose bare name is most similar.

    A patch takes part if it shows one of the classes clearly; a name is right if what it says is
    shown at all.

    Args:
        embeddings: (N, D) of the patches.
        views: The patches.
        encoder: The encoder of the embeddings.
        classes: Names to choose from.
    """
    truth = np.nan_to_num(views.facts.columns(np.array([FACT_INDEX[name] for name in classes])))
    named = (embeddings @ encoder.embed_texts(list(classes)).T).argmax(axis=1)
    clearest = truth.argmax(axis=1)
    rows = np.arange(len(truth))
    right = truth[rows, named] > 0
    result = []
    for scale, (least, end) in SCALES.items():
        chosen = (truth[rows, clearest] >= CLEARLY) & (views.edges >= least) & (views.edges < end)
        of_class = {name: chosen & (clearest == i) for i, name in enumerate(classes)}
        by_class = {
            name: float(right[those].mean())
            for name, those in of_class.items()
            if np.count_nonzero(those) >= 3
        }
        overall = float(right[chosen].mean())
        result.append(Accuracy(scale, int(chosen.sum()), overall, by_class))
    return result


@dataclass(frozen=True, slots=True)
class Examination:
    """The answers to a question.

    Attributes:
        text: The right caption.
        patches: Number of patches that show it clearly, and no other candidate.
        won: Share of those patches to which it is the most similar of the ten.
        taken: Share of the patches that show another candidate clearly, and not it, to which it is
            the most similar all the same; NaN where there are none.
    """

    text: str
    patches: int
    won: float
    taken: float


def examined(
    embeddings: NDArray[np.float32],
    facts: Facts,
    encoder: ClipEncoder,
    questions: Sequence[Question],
) -> list[Examination]:
    """The answers to all questions but those whose right text no patch shows clearly."""
    answers = []
    for question in questions:
        truth = target(question.candidates, facts)
        asked = (truth[:, 0] >= CLEARLY) & (truth[:, 1:] == 0).all(axis=1)
        if not asked.any():
            continue
        texts = encoder.embed_texts([caption.text for caption in question.candidates])
        first = (embeddings @ texts.T).argmax(axis=1) == 0
        other = (truth[:, 0] == 0) & (truth[:, 1:] >= CLEARLY).any(axis=1)
        taken = float(first[other].mean()) if other.any() else np.nan
        won = float(first[asked].mean())
        answers.append(Examination(question.right.text, int(asked.sum()), won, taken))
    return answers


def false_alarms(embeddings: NDArray[np.float32], encoder: ClipEncoder) -> list[str]:
    """Words that are in no caption, and yet reach the threshold on some patch."""
    best = (embeddings @ encoder.embed_texts(HELD_OUT_WORDS).T).max(axis=0)
    return [word for word, top in zip(HELD_OUT_WORDS, best, strict=True) if top > encoder.threshold]


def evaluate_clip(
    folder: Annotated[Path, typer.Argument(help="Where pictures are kept.")],
    weights: Annotated[Path, typer.Option(help="Folder of the embedded CLIP.")] = WEIGHTS,
    homes: Annotated[int, typer.Option(help="Benchmark homes, from 1000 on.")] = 40,
    pictures: Annotated[int, typer.Option(help="Pictures in each home.")] = 60,
) -> None:
    """Examine an embedded CLIP on homes and furniture that it was not trained on."""
    console, encoder = Console(), load_embedded_clip(weights)
    views = LabelledPatches.joined(
        [
            LabelledPatches.load(path)
            for path in take_all(folder, range(1000, 1000 + homes), pictures, 2)
        ]
    )
    embeddings = embed(views, encoder)
    for title, classes in (
        ("the paper's 16 goals", EVALUATION_CLASSES[:GOALS]),
        (f"all {len(EVALUATION_CLASSES)} classes", EVALUATION_CLASSES),
    ):
        table = Table("scale", "patches", "right", "mean of classes", "classes", title=title)
        accuracies = zero_shot(embeddings, views, encoder, classes)
        for it in accuracies:
            cells = (it.scale, it.patches, f"{it.overall:.3f}", f"{it.mean:.3f}", len(it.by_class))
            table.add_row(*map(str, cells))
        console.print(table)
        for it in accuracies:
            weakest = sorted(it.by_class.items(), key=lambda item: item[1])
            names = ", ".join(f"{name} {part:.2f}" for name, part in weakest[:16])
            console.print(f"scale {it.scale}, the weakest: {names}")
    for title, questions in (
        ("withheld combinations", WITHHELD_COMBINATIONS),
        ("withheld phrasings", WITHHELD_PHRASINGS),
    ):
        answers = examined(embeddings, views.facts, encoder, questions)
        won = np.mean([it.won for it in answers])
        taken = np.nanmean([it.taken for it in answers])
        console.print(f"{title}: {won:.3f}, mean of {len(answers)} of {len(questions)}")
        console.print(f"taken for it where another candidate is shown: {taken:.3f}")
        console.print(", ".join(f"{it.text} {it.won:.2f}" for it in answers))
    alarms = false_alarms(embeddings, encoder)
    console.print(
        f"{len(alarms)} of {len(HELD_OUT_WORDS)} unseen words reach {encoder.threshold:.3f}"
    )
    console.print(", ".join(alarms))


def embed(views: LabelledPatches, encoder: ClipEncoder) -> NDArray[np.float32]:
    """Embeddings (N, D) of all patches."""
    batches = np.array_split(views.pixels, max(1, len(views) // 256))
    return np.concatenate([encoder.embed_images(list(batch)) for batch in batches])


if __name__ == "__main__":
    typer.run(evaluate_clip)
