import re

import numpy as np
import pytest

from training.captions import phrasing, spoken_phrasing
from training.captions.captions import draw_captions, draw_contrasts, draw_negatives
from training.captions.facts import FACT_INDEX, FACTS, Facts
from training.captions.held_out_pairs import (
    WITHHELD_COLOURS,
    WITHHELD_RELATIONS,
    is_withheld,
)
from training.captions.phrasing import NounPhrase, phrased
from training.captions.unrelated_words import CAPTION_WORDS, HELD_OUT_WORDS
from training.evaluation import WITHHELD_COMBINATIONS
from vizbot.core.home_vocabulary import COLOURS, ROOMS, SYNONYMS, THINGS

DRAWS = 20_000


@pytest.fixture(scope="module")
def captions():
    """Of patches that show anything that can be told, withheld combinations above all."""
    rng = np.random.default_rng(0)
    withheld = [q.right.facts[0] for q in WITHHELD_COMBINATIONS]
    patches = 400
    rows = []
    for _ in range(patches):
        shown = {FACT_INDEX[key] for key in rng.choice(withheld, 3)}
        shown |= {FACT_INDEX["room"], int(rng.integers(8))}
        shown |= set(rng.integers(len(FACTS), size=12).tolist())
        rows.append(sorted(shown))
    starts = np.concatenate([[0], np.cumsum([len(row) for row in rows])])
    indices = np.concatenate(rows).astype(np.int32)
    facts = Facts(starts, indices, np.ones(len(indices), np.float32))
    told = draw_negatives(rng, DRAWS // 10)
    for i in range(patches):
        told += draw_captions(facts, i, rng, DRAWS * 7 // 10 // patches)
        told += draw_contrasts(facts, i, rng, DRAWS * 3 // 10 // patches)
    assert len(told) > 0.95 * DRAWS
    return told


def test_no_caption_tells_a_withheld_combination(captions):
    withheld = {q.right.facts[0] for q in WITHHELD_COMBINATIONS}
    assert len(withheld) >= 30
    assert not [c.text for c in captions if {*c.facts} & withheld]
    for colour, thing in WITHHELD_COLOURS:
        words = "|".join((thing, *SYNONYMS.get(thing, ())))
        both = re.compile(rf"^(?=.*\b{colour}\b)(?=.*\b({words})\b)")
        assert not [c.text for c in captions if both.search(c.text)]


def test_the_parts_of_what_is_withheld_are_told(captions):
    told = {FACTS[FACT_INDEX[key]] for caption in captions for key in caption.facts}
    coloured = [fact for fact in told if fact.colour]
    related = [fact for fact in told if fact.relation]
    for colour, thing in WITHHELD_COLOURS:
        assert any(fact.colour == colour for fact in coloured)
        assert any(fact.thing == thing for fact in coloured)
    for thing, relation, other in WITHHELD_RELATIONS:
        assert any(fact.relation == relation for fact in related)
        for end in (thing, other):
            assert any(end in (fact.thing, fact.other) for fact in related)


def test_withheld_combinations_are_known_in_any_words():
    assert is_withheld("a couch in purple", ())
    assert is_withheld("two purple settees", ())
    assert is_withheld("a green office chair", ())
    assert not is_withheld("a green armchair", ())
    assert is_withheld("", ("desk next to office chair",))
    assert is_withheld("", ("table lamp on nightstand",))
    assert is_withheld("", ("bed next to nightstand",))
    assert not is_withheld("", ("computer on table",))


def test_no_caption_is_put_in_a_withheld_phrasing(captions):
    gap = "\N{REPLACEMENT CHARACTER}"
    shapes = [phrased(way, NounPhrase(gap, counted=False)) for way in phrasing.WITHHELD_PHRASINGS]
    patterns = [re.compile(re.escape(shape).replace(gap, ".+") + "$") for shape in shapes]
    assert len(patterns) >= 30
    told = [way for ways in phrasing.PHRASINGS for way in ways]
    assert not {*told} & {*phrasing.WITHHELD_PHRASINGS}
    for pattern in patterns:
        assert not [c.text for c in captions if pattern.match(c.text)]


def test_ten_candidates_differ_in_one_thing_or_colour():
    names = sorted({*THINGS, *COLOURS}, key=len, reverse=True)
    word = re.compile(rf"\b({'|'.join(names)})\b")
    for question in WITHHELD_COMBINATIONS:
        assert len({c.text for c in question.candidates}) == 10
        right = word.findall(question.right.text)
        for wrong in question.candidates[1:]:
            found = word.findall(wrong.text)
            assert len(found) == len(right)
            assert sum(a != b for a, b in zip(found, right, strict=True)) == 1
        for candidate in question.candidates:
            assert {*candidate.facts} <= {*FACT_INDEX}


def test_unseen_words_are_in_no_caption(captions):
    words = {word for caption in captions for word in re.findall(r"[a-z']+", caption.text)}
    assert len(HELD_OUT_WORDS) == 200
    assert len(CAPTION_WORDS) >= 900
    assert not words & {*HELD_OUT_WORDS}


def test_plain_words_have_nothing_to_do_with_homes_or_phrasings():
    ways = (
        *(way for ways in phrasing.PHRASINGS for way in ways),
        *phrasing.WITHHELD_PHRASINGS,
        *spoken_phrasing.SPOKEN,
        *phrasing.ROOM,
        *phrasing.WITH_COLOUR,
        *phrasing.WITH_MATERIAL,
        *(way for ways in phrasing.RELATED.values() for way in ways),
        *THINGS,
        *COLOURS,
        *ROOMS,
        *(word for table in (SYNONYMS, ROOMS) for others in table.values() for word in others),
    )
    home = {word for way in ways for word in re.findall(r"[a-z']+", way)}
    assert not home & {*CAPTION_WORDS, *HELD_OUT_WORDS}
    assert not {*CAPTION_WORDS} & {*HELD_OUT_WORDS}
