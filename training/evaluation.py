"""Evaluation of an embedded CLIP on homes and furniture that it was not trained on.

`python -m training.evaluation` takes pictures of homes of development, which are no
benchmark's, and writes the figures to docs/results/rows/encoder.

How many patches a text reaches at the threshold, of those that the bare name reaches, is asked for
each phrasing by itself, with the threshold that a search decides by. There are no candidates to
choose from, so nothing is right by chance.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray
from rich.console import Console
from scipy.stats import rankdata

from mapping.clip.embedded.encoder import load_embedded_clip
from mapping.clip.embedded.model_files import WEIGHTS
from mapping.clip.embedded.word_table import looked_up
from mapping.clip.encoder import ClipEncoder
from training.captions.captions import Caption, caption_of, plain_noun, target
from training.captions.facts import FACT_INDEX, Fact, Facts
from training.captions.held_out_pairs import WITHHELD_COLOURS, WITHHELD_RELATIONS, relation_key
from training.captions.phrasing import WITHHELD_PHRASINGS
from training.captions.spoken_phrasing import (
    TRAINED_SPOKEN,
    WITHHELD_SPOKEN,
    WITHHELD_SYNONYMS,
    spoken,
)
from training.captions.unrelated_words import HELD_OUT_WORDS
from training.homes import Mixture, TrainingHome
from training.views import LabelledPatches, ViewsConfig, take_all
from vizbot.core.home_vocabulary import COLOURS, EVALUATION_CLASSES, THINGS, akin, kinds

CLEARLY = 0.6
"""Least strength of the class of a patch."""
ENOUGH = 10
"""Patches that a bare name has to reach, for its class to take part."""
SCALES: Mapping[int, tuple[int, int]] = {1: (380, 481), 0: (190, 271), -1: (90, 141)}
"""Edges of the patches [px] that stand for each of the paper's scales."""
HOMES = range(1100, 1200)
"""Homes with held-out furniture, for development; no benchmark drives in them."""
RESULTS = Path("docs/results/rows/encoder")
WITHHELD_WAYS = (*WITHHELD_PHRASINGS, *WITHHELD_SPOKEN)
"""Phrasings that no training text has."""
GOALS = 16
"""Number of the paper's goals, the first of the classes."""
CANDIDATES = 10
COMMON = (
    "bed", "chair", "sofa", "table", "carpet", "window", "toilet", "sink", "refrigerator", "tv",
    "bathtub", "wardrobe", "plant", "desk", "bookshelf", "lamp", "picture", "curtain", "door",
    "armchair", "oven", "mirror", "nightstand", "radiator",
)  # fmt: skip
"""Things that most homes have, for wrong candidates."""


@dataclass(frozen=True, slots=True)
class Question:
    """Ten captions of which the first is right; they differ in one word (a name counts as one).

    It is put to the patches on which the first is true and the others are not, by `target`.

    Attributes:
        candidates: The right caption, then nine wrong ones.
    """

    candidates: tuple[Caption, ...]

    @property
    def right(self) -> Caption:
        """The right caption, which is held out of training."""
        return self.candidates[0]


def _statement(fact: Fact) -> Caption:
    return caption_of((fact.key,), "{a}", plain_noun(fact))


def _others(thing: str, taken: tuple[str, ...] = ()) -> list[str]:
    """Things that cannot be mistaken for `thing`, common ones first."""
    alike = {*kinds(thing), *akin(thing), *taken}
    start = COMMON.index(thing) if thing in COMMON else 0
    turned = dict.fromkeys((*COMMON[start:], *COMMON[:start], *THINGS))
    return [
        other for other in turned if other not in alike and not {thing, *taken} & {*akin(other)}
    ]


def _of_colours() -> Iterator[Question]:
    for colour, thing in WITHHELD_COLOURS:
        right = Fact(thing, colour=colour)
        start = list(COLOURS).index(colour)
        turned = [*COLOURS][start:] + [*COLOURS][:start]
        colours = [other for other in turned if other not in (colour, *COLOURS[colour])]
        wrong = [replace(right, colour=other) for other in colours[:5]]
        wrong += [replace(right, thing=other) for other in _others(thing)]
        yield Question(tuple(_statement(fact) for fact in (right, *wrong)[:CANDIDATES]))


def _of_relations() -> Iterator[Question]:
    for thing, relation, other in WITHHELD_RELATIONS:
        right = Fact(thing, relation=relation, other=other)
        of_other = [replace(right, other=word) for word in _others(other, (thing,))]
        of_thing = [replace(right, thing=word) for word in _others(thing, (other,))]
        known = [[a for a in facts if _key(a) in FACT_INDEX] for facts in (of_other, of_thing)]
        wrong = [*known[0][:5], *known[1], *known[0][5:]]
        facts = (right, *wrong)[:CANDIDATES]
        yield Question(tuple(caption_of((_key(fact),), "{a}", plain_noun(fact)) for fact in facts))


def _key(fact: Fact) -> str:
    return relation_key(fact.thing, fact.relation, fact.other)


WITHHELD_COMBINATIONS: tuple[Question, ...] = (*_of_colours(), *_of_relations())
"""A question for each withheld colour of a thing and relation of two."""


@dataclass(frozen=True, slots=True, eq=False)
class NamedPatches:
    """The patches that bare names reach.

    Attributes:
        embeddings: Embeddings (P, D) of the patches that show a class clearly and that its bare
            name reaches, by the class; classes with `ENOUGH` of them.
        shares: Share of the patches that show a class clearly that its bare name reaches, by the
            class; all classes with `ENOUGH` clear patches.
    """

    embeddings: Mapping[str, NDArray[np.float32]]
    shares: Mapping[str, float]

    @staticmethod
    def from_names(
        embeddings: NDArray[np.float32], facts: Facts, encoder: ClipEncoder, names: Sequence[str]
    ) -> NamedPatches:
        """Ask for each of `names` bare, on patches with `embeddings` (N, D) and `facts`."""
        truth = np.nan_to_num(shown_on(facts, names))
        reached, shares = {}, {}
        for name, column, text in zip(names, truth.T, encoder.embed_texts(names), strict=True):
            clear = embeddings[column >= CLEARLY]
            those = clear[clear @ text > encoder.threshold]
            if len(clear) >= ENOUGH:
                shares[name] = len(those) / len(clear)
            if len(those) >= ENOUGH:
                reached[name] = those
        return NamedPatches(reached, shares)

    def reach_of(self, texts: Mapping[str, str], encoder: ClipEncoder) -> float:
        """Part of the patches that `texts`, by the class, reach, too; mean of the classes."""
        asked = {name: text for name, text in texts.items() if name in self.embeddings}
        rows = encoder.embed_texts(list(asked.values()))
        parts = [
            float((self.embeddings[name] @ row > encoder.threshold).mean())
            for name, row in zip(asked, rows, strict=True)
        ]
        return float(np.mean(parts)) if parts else np.nan

    def reach_of_phrasing(self, way: str, encoder: ClipEncoder) -> float:
        """`reach_of` a phrasing of all classes."""
        return self.reach_of({name: spoken(way, name) for name in self.embeddings}, encoder)


def shown_on(facts: Facts, names: Sequence[str]) -> NDArray[np.float32]:
    """How clearly patches show things (P, C), by the names (C,); NaN where it is disputable."""
    return facts.columns(np.array([FACT_INDEX[name] for name in names]))


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
    similarities: NDArray[np.float32],
    shown: NDArray[np.float32],
    edges: NDArray[np.integer],
    classes: Sequence[str],
) -> list[Accuracy]:
    """Accuracy, at each scale, of naming a patch by the class whose bare name is most similar.

    A patch takes part if it shows one of the classes clearly; a name is right if what it says is
    shown at all. A scale at which no patch does is left out.

    Args:
        similarities: (N, C) of patches and bare names.
        shown: (N, C) how clearly each class is shown; NaN where it is disputable.
        edges: (N,) edge of each patch [px].
        classes: Names (C,) to choose from.
    """
    truth = np.nan_to_num(shown)
    named, clearest = similarities.argmax(axis=1), truth.argmax(axis=1)
    rows = np.arange(len(truth))
    right = truth[rows, named] > 0
    result = []
    for scale, (least, end) in SCALES.items():
        chosen = (truth[rows, clearest] >= CLEARLY) & (edges >= least) & (edges < end)
        if not chosen.any():
            continue
        of_class = {name: chosen & (clearest == i) for i, name in enumerate(classes)}
        by_class = {
            name: float(right[those].mean())
            for name, those in of_class.items()
            if np.count_nonzero(those) >= 3
        }
        overall = float(right[chosen].mean())
        result.append(Accuracy(scale, int(chosen.sum()), overall, by_class))
    return result


def area_under_curve(with_it: NDArray[np.float32], without: NDArray[np.float32]) -> float:
    """Probability that one of `with_it` (N,) is above one of `without` (M,); a tie counts half.

    It is the area under the receiver operating characteristic (Mann and Whitney 1947).
    """
    ranks = rankdata(np.concatenate([with_it, without]))[: len(with_it)]
    wins = ranks.sum() - len(with_it) * (len(with_it) + 1) / 2
    return float(wins / (len(with_it) * len(without)))


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


def phrased_alarms(embeddings: NDArray[np.float32], encoder: ClipEncoder) -> float:
    """Share of these words in each withheld phrasing that reach the threshold on some patch."""
    shares = []
    for way in WITHHELD_WAYS:
        texts = [spoken(way, word) for word in HELD_OUT_WORDS]
        best = (embeddings @ encoder.embed_texts(texts).T).max(axis=0)
        shares.append(float((best > encoder.threshold).mean()))
    return float(np.mean(shares))


def figures(views: LabelledPatches, encoder: ClipEncoder) -> dict[str, object]:
    """All figures of the examination, by name, ready for JSON."""
    embeddings = embed(views, encoder)
    answers = examined(embeddings, views.facts, encoder, WITHHELD_COMBINATIONS)
    named = NamedPatches.from_names(embeddings, views.facts, encoder, EVALUATION_CLASSES)
    found = {word: (looked_up(word) or (None,))[0] for word in WITHHELD_SYNONYMS}
    return {
        "threshold": encoder.threshold,
        "patches": len(views),
        "accuracy": [
            {
                "classes": len(classes),
                "scale": it.scale,
                "patches": it.patches,
                "right": round(it.overall, 4),
                "mean_of_classes": round(it.mean, 4),
            }
            for classes in (EVALUATION_CLASSES[:GOALS], EVALUATION_CLASSES)
            for it in zero_shot(
                embeddings @ encoder.embed_texts(list(classes)).T,
                shown_on(views.facts, classes),
                views.edges,
                classes,
            )
        ],
        "bare_names": {name: round(share, 4) for name, share in named.shares.items()},
        "phrasings_withheld": _reach(named, encoder, WITHHELD_WAYS),
        "phrasings_trained": _reach(named, encoder, TRAINED_SPOKEN),
        "synonyms": {
            "right": round(
                float(np.mean([found[w] == c for w, c in WITHHELD_SYNONYMS.items()])), 4
            ),
            "each": found,
        },
        "combinations": {
            "withheld": len(WITHHELD_COMBINATIONS),
            "asked": len(answers),
            "right": round(float(np.mean([it.won for it in answers])), 4),
            "taken": round(float(np.nanmean([it.taken for it in answers])), 4),
            "each": {it.text: [it.patches, round(it.won, 4)] for it in answers},
        },
        "absent_words": {
            "words": len(HELD_OUT_WORDS),
            "reaching": false_alarms(embeddings, encoder),
            "share_in_withheld_phrasings": round(phrased_alarms(embeddings, encoder), 5),
        },
    }


def _reach(named: NamedPatches, encoder: ClipEncoder, ways: Sequence[str]) -> dict[str, object]:
    each = {way: named.reach_of_phrasing(way, encoder) for way in ways}
    values = np.array(list(each.values()))
    return {
        "classes": len(named.embeddings),
        "phrasings": len(ways),
        "mean": round(float(values.mean()), 4),
        "least": round(float(values.min()), 4),
        "share_at_80_percent": round(float((values >= 0.8).mean()), 4),
        "each": {way: round(share, 4) for way, share in each.items()},
    }


def evaluate_clip(
    folder: Annotated[Path, typer.Argument(help="Where pictures are kept.")],
    weights: Annotated[Path, typer.Option(help="Folder of the embedded CLIP.")] = WEIGHTS,
    homes: Annotated[int, typer.Option(help="Homes, from 1100 on; 100 at most.")] = 6,
    pictures: Annotated[int, typer.Option(help="Pictures in each home.")] = 60,
    out: Annotated[Path, typer.Option(help="Folder for the figures, as JSON.")] = RESULTS,
) -> None:
    """Examine an embedded CLIP on homes of development, and write MODEL-ID.json."""
    if not 1 <= homes <= len(HOMES):
        raise typer.BadParameter(f"--homes {homes}: give 1 to {len(HOMES)}")
    encoder = load_embedded_clip(weights)
    seeds = HOMES[:homes]
    ours = [TrainingHome(Mixture.OURS, seed) for seed in seeds]
    paths = take_all(folder, ours, ViewsConfig(pictures=pictures), 2)
    views = LabelledPatches.joined([LabelledPatches.load(path) for path in paths])
    content = {
        "model_id": encoder.model_id,
        "weights_sha256": sha256((weights / "model.safetensors").read_bytes()).hexdigest(),
        "homes": [seeds[0], seeds[-1]],
        "pictures_of_a_home": pictures,
        **figures(views, encoder),
    }
    out.mkdir(parents=True, exist_ok=True)
    text = json.dumps(content, indent=1)
    (out / f"{encoder.model_id}.json").write_text(text + "\n", encoding="utf-8")
    Console().print_json(text)


def embed(views: LabelledPatches, encoder: ClipEncoder) -> NDArray[np.float32]:
    """Embeddings (N, D) of all patches."""
    batches = np.array_split(views.pixels, max(1, len(views) // 256))
    return np.concatenate([encoder.embed_images(list(batch)) for batch in batches])


if __name__ == "__main__":
    typer.run(evaluate_clip)
