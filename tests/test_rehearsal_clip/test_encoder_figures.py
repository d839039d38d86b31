"""The page of the embedded CLIP shows the figures that the examination has kept."""

import json
from hashlib import sha256

import pytest

from sim_stubs.clip.encoder import load_embedded_clip
from sim_stubs.clip.model_files import WEIGHTS
from sim_stubs.clip.training.captions.synonyms import WITHHELD_SYNONYMS
from sim_stubs.clip.training.evaluation import WITHHELD_WAYS
from sim_stubs.homes.vocabulary import GROUPS, ROOMS, THINGS
from tests.helpers.checkout import ROOT

ROWS = ROOT / "docs/results/rows/encoder"
BEFORE = "embedded-cc297db4"


@pytest.fixture(scope="module")
def page():
    return (ROOT / "docs/embedded_clip.md").read_text()


@pytest.fixture(scope="module")
def kept():
    """The figures of the shipped weights, and of those of the first stage."""
    return [
        json.loads((ROWS / f"{name}.json").read_text())
        for name in (load_embedded_clip().model_id, BEFORE)
    ]


def test_the_kept_figures_are_those_of_the_shipped_weights(kept):
    now, before = kept
    weights = (WEIGHTS / "model.safetensors").read_bytes()
    assert now["weights_sha256"] == sha256(weights).hexdigest()
    assert now["threshold"] == before["threshold"] == load_embedded_clip().threshold
    assert {*now["phrasings_withheld"]["each"]} == {*WITHHELD_WAYS}
    assert {*now["synonyms"]["each"]} == {*WITHHELD_SYNONYMS}
    for name in ("homes", "pictures_of_a_home", "patches"):
        assert now[name] == before[name]


def test_the_tables_hold_the_kept_figures(page, kept):
    now, before = kept
    rows = []
    for classes, label in ((16, "the paper's 16 goals"), (71, "all 71 classes")):
        cells = [[it for it in one["accuracy"] if it["classes"] == classes] for one in kept]
        shown = " | ".join(f"{it['right']:.3f} ({it['patches']} patches)" for it in cells[0])
        rows.append(f"| {label} | {shown} |")
        shown = " | ".join(f"{it['right']:.3f}" for it in cells[1])
        rows.append(f"| the same, before | {shown} |")
    for name, value in FIGURES.items():
        rows.append(f"| {name} | {value(now)} | {value(before)} |")
    assert [row for row in rows if row not in page] == []


def test_the_page_counts_what_the_encoder_knows(page):
    assert f"{len(THINGS) + len(GROUPS)} kinds of things and {len(ROOMS)} rooms" in " ".join(
        page.split()
    )


FIGURES = {
    "a withheld phrasing, mean": lambda it: f"{it['phrasings_withheld']['mean']:.3f}",
    "withheld phrasings that reach 0.8": lambda it: _part(it["phrasings_withheld"]),
    "the weakest withheld phrasing": lambda it: f"{it['phrasings_withheld']['least']:.3f}",
    "a trained phrasing, mean": lambda it: f"{it['phrasings_trained']['mean']:.3f}",
    "the right one of ten withheld combinations": lambda it: (
        f"{it['combinations']['right']:.3f}, mean of {it['combinations']['asked']}"
    ),
    "taken for it where another one is shown": lambda it: f"{it['combinations']['taken']:.3f}",
    "of 200 absent words, those that reach the threshold": lambda it: str(
        len(it["absent_words"]["reaching"])
    ),
    "absent words in withheld phrasings that reach it": lambda it: (
        f"{it['absent_words']['share_in_withheld_phrasings'] * 100:.2f} %"
    ),
    "withheld synonyms that the look-up resolves rightly": lambda it: (
        f"{sum(it['synonyms']['each'][w] == c for w, c in WITHHELD_SYNONYMS.items())}"
        f" of {len(WITHHELD_SYNONYMS)}"
    ),
}


def _part(reach):
    good = sum(share >= 0.8 for share in reach["each"].values())
    return f"{good} of {reach['phrasings']}"
