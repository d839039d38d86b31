"""The kept figures are of the shipped weights; `vizbot bench --check` holds the page to them."""

import json
from hashlib import sha256

import pytest
from safetensors.numpy import load_file

from mapping.clip.embedded.encoder import load_embedded_clip
from mapping.clip.embedded.model_files import WEIGHTS
from mapping.clip.embedded.word_table import TABLE
from tests.helpers.checkout import ROOT
from training.captions.phrasing import WITHHELD_PHRASINGS
from training.captions.spoken_phrasing import SPOKEN, TRAINED_SYNONYMS, WITHHELD_SYNONYMS
from training.captions.unrelated_words import CAPTION_WORDS
from training.evaluation import WITHHELD_WAYS
from vizbot.core.home_vocabulary import COLOURS, GROUPS, MATERIALS, ROOMS, THINGS

ROWS = ROOT / "docs/results/rows/encoder"
BEFORE = "embedded-87dc9cae"


@pytest.fixture(scope="module")
def page():
    return (ROOT / "docs/embedded_clip.md").read_text()


@pytest.fixture(scope="module")
def kept():
    """The figures of the shipped weights, and of those before the wide stages."""
    return [
        json.loads((ROWS / f"{name}.json").read_text())
        for name in (load_embedded_clip().model_id, BEFORE)
    ]


def test_the_kept_figures_are_those_of_the_shipped_weights(kept):
    now, before = kept
    weights = (WEIGHTS / "model.safetensors").read_bytes()
    assert now["weights_sha256"] == sha256(weights).hexdigest()
    assert now["threshold"] == load_embedded_clip().threshold
    assert {*now["phrasings_withheld"]["each"]} == {*WITHHELD_WAYS}
    assert {*now["synonyms"]["each"]} == {*WITHHELD_SYNONYMS}
    for name in ("homes", "pictures_of_a_home", "patches"):
        assert now[name] == before[name]


def test_the_page_counts_what_the_encoder_knows(page):
    text = " ".join(page.split())
    weights = load_file(WEIGHTS / "model.safetensors").values()
    nouns = sum(not line.startswith("#") for line in TABLE.read_text().splitlines())
    for said in (
        f"{sum(each.size for each in weights) / 1e6:.1f} million weights",
        f"{(WEIGHTS / 'model.safetensors').stat().st_size / 1e6:.0f} MB in 16 bits",
        f"{len(THINGS) + len(GROUPS)} kinds of things and {len(ROOMS)} rooms",
        f"{len(WITHHELD_SYNONYMS) + len(TRAINED_SYNONYMS)} synonyms of them",
        f"{len(COLOURS)} colours, {len(MATERIALS)} materials",
        f"all {len(THINGS) + len(GROUPS) + len(ROOMS)} bare names",
        f"A fifth of the {len(SPOKEN)} phrasings",
        f"the {len(WITHHELD_PHRASINGS)} phrasings that the first stage withheld",
        f"some {round(nouns, -2):,} nouns",
        f"the {len(CAPTION_WORDS)} that training presented as never shown",
    ):
        assert said in text
