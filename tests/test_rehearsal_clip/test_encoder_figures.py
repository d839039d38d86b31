"""The kept figures are of the shipped weights; `vizbot bench --check` holds the page to them."""

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


def test_the_page_counts_what_the_encoder_knows(page):
    assert f"{len(THINGS) + len(GROUPS)} kinds of things and {len(ROOMS)} rooms" in " ".join(
        page.split()
    )
