"""Phrasings of the text stage: which are withheld, and what the shipped weights make of them."""

import re

import numpy as np
import pytest

from mapping.clip.embedded.encoder import load_embedded_clip
from training.captions import phrasing
from training.captions.held_out_pairs import is_withheld
from training.captions.spoken_phrasing import (
    ADJECTIVES,
    SPOKEN,
    TRAINED_ADJECTIVES,
    TRAINED_SPOKEN,
    TRAINED_SYNONYMS,
    WITHHELD_SPOKEN,
    WITHHELD_SYNONYMS,
    has_withheld_synonym,
    spoken,
)
from training.captions.unrelated_words import HELD_OUT_WORDS
from training.spoken_texts import draw_kept, draw_spoken, draw_unrelated
from vizbot.core.home_vocabulary import THINGS


@pytest.fixture(scope="module")
def texts():
    rng = np.random.default_rng(0)
    pairs = draw_spoken(rng, 6000) + draw_unrelated(rng, 2000)
    pairs += [pair for _ in range(10) for pair in draw_kept(rng, 64)]
    assert len(pairs) > 8000
    return [pair.text for pair in pairs]


@pytest.fixture(scope="module")
def encoder():
    return load_embedded_clip()


def test_a_fifth_of_phrasings_and_synonyms_is_withheld():
    assert len(SPOKEN) > 400
    assert not {*TRAINED_SPOKEN} & {*WITHHELD_SPOKEN}
    assert len(WITHHELD_SPOKEN) == round(0.2 * len(SPOKEN))
    both = len(TRAINED_SYNONYMS) + len(WITHHELD_SYNONYMS)
    assert len(WITHHELD_SYNONYMS) == round(0.2 * both)
    trained = [way for ways in phrasing.PHRASINGS for way in ways]
    assert not {*SPOKEN} & {*trained, *phrasing.WITHHELD_PHRASINGS}


def test_no_text_is_put_in_a_withheld_phrasing(texts):
    asked = {
        spoken(way, thing)
        for way in (*WITHHELD_SPOKEN, *phrasing.WITHHELD_PHRASINGS)
        for thing in THINGS
    }
    assert not asked & {*texts}


def test_no_text_has_a_withheld_adjective_or_synonym_or_combination(texts):
    adjectives = {*ADJECTIVES} - {*TRAINED_ADJECTIVES}
    assert len(adjectives) > 10
    # Some of them are words of other phrasings: only those before a thing count.
    things = "|".join(map(re.escape, THINGS))
    before = re.compile(rf"\b({'|'.join(map(re.escape, adjectives))}) ({things})\b")
    old = {way.split()[1] for ways in phrasing.PHRASINGS for way in ways if len(way.split()) > 2}
    assert not [text for text in texts if (m := before.search(text)) and m[1] not in old]
    assert not [text for text in texts if has_withheld_synonym(text)]
    assert not [text for text in texts if is_withheld(text, ())]


def test_unseen_words_are_in_no_text(texts):
    words = {word for text in texts for word in re.findall(r"[a-z']+", text)}
    assert not words & {*HELD_OUT_WORDS}


def test_a_phrasing_takes_articles_and_plurals():
    assert spoken("some {many}", "red sofa") == "some red sofas"
    assert spoken("find {a}", "office chair") == "find an office chair"
    assert spoken("my {many}", "study") == "my studies"


@pytest.mark.parametrize("words", ["sofa", "bed", "toilet", "kitchen"])
def test_withheld_phrasings_are_embedded_like_the_bare_name(encoder, words):
    ways = ("robot, find {the}", "tell me where {the} is", "where is my {bare}?", "a neat {bare}")
    assert {*ways} <= {*WITHHELD_SPOKEN}
    bare, *others = encoder.embed_texts([words, *(spoken(way, words) for way in ways)])
    assert (np.array(others) @ bare).min() > 0.9


def test_plurals_and_adjectives_are_embedded_like_the_bare_name(encoder):
    rows = encoder.embed_texts(["sofa", "sofas", "a nice sofa", "bed", "beds"])
    assert min(rows[0] @ rows[1], rows[0] @ rows[2], rows[3] @ rows[4]) > 0.9


def test_what_no_home_has_stays_apart_from_what_it_has(encoder):
    absent = encoder.embed_texts([f"robot, find the {word}" for word in HELD_OUT_WORDS])
    best = (absent @ encoder.embed_texts(["sofa", "bed", "toilet", "kitchen"]).T).max(axis=1)
    near = {word for word, top in zip(HELD_OUT_WORDS, best, strict=True) if top > 0.7}
    assert near <= {"igloo"}  # its last token is the word "loo"
