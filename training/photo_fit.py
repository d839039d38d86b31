"""Fit the numbers of the classes of photographs: `python -m training.photo_fit PHOTOGRAPHS KEPT`.

PHOTOGRAPHS is a checkout of https://github.com/lightly-ai/coco128_yolo (commit 6d6f7a05): pictures
of COCO with a box for everything of 80 names. Those taken inside homes are used. What is said of
each is kept in the folder KEPT, so that a run that was broken off goes on there.

The temperature of the classifier is the one at which names are told apart best; scale and bias, by
which the cosine of a picture and a name becomes log odds, are those of the least cross entropy
(Platt 1999). Pictures are the patches that the robot would cut out. Names that the classifier does
not see in them, as tables under plates, say nothing of the others: they are left out.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray
from scipy.optimize import minimize

from mapping.clip.config import ClipMapperConfig
from mapping.clip.patches import patch_boxes
from mapping.clip.photos.encoder import PhotoClasses, open_photo_classes, root_probabilities
from mapping.clip.photos.fit import FIT_FILE
from mapping.clip.photos.names import distribution
from mapping.clip.photos.text_encoder import PhotoTexts
from training.evaluation import area_under_curve
from training.lessons import read_picture
from vizbot.operator.printing import echo

INDOORS = frozenset(
    {"bed", "chair", "couch", "dining table", "keyboard", "laptop", "microwave", "oven",
     "potted plant", "refrigerator", "sink", "toaster", "toilet", "tv"}
)  # fmt: skip
"""A picture with one of these is taken inside a home."""
MOST_INSIDE, LEAST_SHARE, LARGE_SHARE = 0.5, 0.1, 0.4
"""A patch shows a thing if it has over half of its box, which fills a tenth of the patch at least,
or if the box fills four tenths of it; if it has less of the box, it counts neither way."""
TEMPERATURES = (0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0)
"""Temperatures that are tried."""
_FEWEST, _LEAST_AUC = 8, 0.75
"""Patches that show a name, and the area under its ROC curve, for the name to count."""


@dataclass(frozen=True, slots=True, eq=False)
class PhotographPatches:
    """The patches of photographs.

    Attributes:
        names: The K names that have boxes.
        logits: (N, 1000) by the classifier.
        shown: (N, K) 1 where a patch shows a name, 0 where not, -1 where neither counts.
    """

    names: Sequence[str]
    logits: NDArray[np.float32]
    shown: NDArray[np.int8]


@dataclass(frozen=True, slots=True)
class Fitted:
    """Numbers at one temperature, and how good they are.

    Attributes:
        scale: Of the log odds.
        bias: Likewise.
        cross_entropy: Mean over names of that of their patches, each name's shown and other
            patches in their own proportions.
        auc: Mean over names of the area under the ROC curve.
    """

    temperature: float
    scale: float
    bias: float
    cross_entropy: float
    auc: float


def patches_indoors(photographs: Path, kept: Path) -> PhotographPatches:
    """Cut out and classify the patches of the pictures inside homes, or read what was kept."""
    config = (photographs / "object_detection" / "config.yaml").read_text(encoding="utf-8")
    all_names = re.findall(r"^ +\d+: (.+)$", config, re.MULTILINE)
    numbers = [i for i, name in enumerate(all_names) if distribution(name) is not None]
    encoder = open_photo_classes("cpu")
    logits, shown = [], []
    for picture, labels in _labelled(photographs):
        if INDOORS.isdisjoint(all_names[int(number)] for number in labels[:, 0]):
            continue
        image = read_picture(picture)
        height, width = image.shape[:2]
        boxes = patch_boxes(width, height, ClipMapperConfig())
        logits.append(_logits(encoder, image, boxes, kept / f"{picture.stem}.npy"))
        placed = labels * (1, width, height, width, height)
        shown.append(np.stack([_shown(boxes, placed, number) for number in numbers], axis=1))
    names = [all_names[number] for number in numbers]
    return PhotographPatches(names, np.concatenate(logits), np.concatenate(shown))


def _labelled(photographs: Path) -> Iterator[tuple[Path, NDArray[np.float64]]]:
    """Each picture, and (M, 5): number of each thing, centre and size of its box in its shares."""
    for file in sorted((photographs / "object_detection" / "labels").glob("*/*.txt")):
        picture = photographs / "images" / file.parent.name / f"{file.stem}.jpg"
        text = file.read_text(encoding="utf-8")
        yield picture, np.array(text.split(), np.float64).reshape(-1, 5)


def _logits(
    encoder: PhotoClasses, image: NDArray[np.uint8], boxes: NDArray[np.int32], kept: Path
) -> NDArray[np.float32]:
    """Logits (P, 1000) of the patches of an image, from a file if it is there."""
    if not kept.exists():
        found = encoder.logits([image[v0:v1, u0:u1] for u0, v0, u1, v1 in boxes])
        kept.parent.mkdir(parents=True, exist_ok=True)
        part = kept.with_suffix(".part.npy")
        np.save(part, found)
        part.replace(kept)
        echo(f"classified {kept.stem}")
    return np.asarray(np.load(kept), np.float32)


def _shown(
    patches: NDArray[np.int32], things: NDArray[np.float64], number: int
) -> NDArray[np.int8]:
    """Whether patches (P, 4) show a thing: (P,) as in `PhotographPatches`.

    `things` (M, 5) are numbers, centres and sizes [px].
    """
    found = np.zeros(len(patches), np.int8)
    for u, v, width, height in things[things[:, 0] == number, 1:]:
        low, high = (u - width / 2, v - height / 2), (u + width / 2, v + height / 2)
        common = np.minimum(patches[:, 2:], high) - np.maximum(patches[:, :2], low)
        area = np.clip(common, 0.0, None).prod(axis=1)
        share = area / (patches[:, 2] - patches[:, 0]) ** 2
        inside = area / max(width * height, 1.0)
        clear = ((inside > MOST_INSIDE) & (share > LEAST_SHARE)) | (share > LARGE_SHARE)
        found = np.where(clear | (found == 1), 1, np.where(share > 0.0, -1, found)).astype(np.int8)
    return found


def with_names_seen(patches: PhotographPatches) -> PhotographPatches:
    """The same with those names alone that count."""
    seen = [
        number
        for number, (cosines, shown) in enumerate(_cosines(patches, 1.0))
        if shown.sum() >= _FEWEST
        and area_under_curve(cosines[shown], cosines[~shown]) >= _LEAST_AUC
    ]
    names = [patches.names[number] for number in seen]
    return PhotographPatches(names, patches.logits, patches.shown[:, seen])


def _cosines(
    patches: PhotographPatches, temperature: float
) -> list[tuple[NDArray[np.float32], NDArray[np.bool_]]]:
    """Of each name the cosines (M,) of what counts, and whether that shows it."""
    embedded = root_probabilities(patches.logits, temperature)
    texts = PhotoTexts().embed_texts(patches.names)
    return [
        (embedded[shown >= 0] @ text, shown[shown >= 0] == 1)
        for text, shown in zip(texts, patches.shown.T, strict=True)
    ]


def fitted(patches: PhotographPatches, temperature: float) -> Fitted:
    """The numbers for one temperature."""
    names = _cosines(patches, temperature)

    def cross_entropy(numbers: NDArray[np.float64]) -> float:
        scale, bias = numbers
        losses = [
            np.logaddexp(0.0, np.where(shown, -1.0, 1.0) * (scale * cosines + bias)).mean()
            for cosines, shown in names
        ]
        return float(np.mean(losses))

    best = minimize(cross_entropy, np.array([10.0, -5.0]), method="Nelder-Mead")
    auc = np.mean([area_under_curve(cosines[shown], cosines[~shown]) for cosines, shown in names])
    scale, bias = best.x.tolist()
    return Fitted(
        temperature, round(scale, 2), round(bias, 2), round(best.fun, 4), round(float(auc), 5)
    )


def fit(
    photographs: Annotated[Path, typer.Argument(help="A checkout of coco128_yolo.")],
    kept: Annotated[Path, typer.Argument(help="Where what was classified is kept.")],
) -> None:
    """Fit the numbers and write them beside the encoder."""
    patches = with_names_seen(patches_indoors(photographs, kept))
    tried = [fitted(patches, temperature) for temperature in TEMPERATURES]
    for each in tried:
        echo(
            f"temperature {each.temperature:g}: cross entropy {each.cross_entropy:.4f},"
            f" AUC {each.auc:.3f}, scale {each.scale:.1f}, bias {each.bias:.1f}"
        )
    best = max(tried, key=lambda each: each.auc)
    about = {"patches": len(patches.logits), "names": ", ".join(patches.names)}
    FIT_FILE.write_text(json.dumps(asdict(best) | about, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    typer.run(fit)
