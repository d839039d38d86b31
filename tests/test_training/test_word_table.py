"""The table of words that the embedded CLIP looks up."""

import pytest

from mapping.clip.embedded.encoder import load_embedded_clip
from mapping.clip.embedded.word_table import looked_up, read_goal, table
from training.captions.spoken_phrasing import TRAINED_SYNONYMS, WITHHELD_SYNONYMS
from training.captions.unrelated_words import HELD_OUT_WORDS
from training.spoken_texts import trained_words
from training.wordnet import WordNet, word_table
from vizbot.core.home_vocabulary import GROUPS, ROOMS, THINGS


def read(text):
    reading = read_goal(text, trained_words())
    return reading.text, reading.note


@pytest.mark.parametrize(
    ("text", "embedded", "note"),
    [
        ("loveseat", "sofa", "loveseat: a kind of sofa"),
        ("red loveseat", "red sofa", "loveseat: a kind of sofa"),
        ("Find me a Loveseat, please", "Find me a sofa, please", "loveseat: a kind of sofa"),
        ("the loveseat in the bedroom", "the sofa in the bedroom", "loveseat: a kind of sofa"),
        ("two loveseats", "two sofa", "loveseats: a kind of sofa"),
        ("telly", "tv", "telly: another word for tv"),
        ("foyer", "hallway", "foyer: another word for hallway"),
        ("grand piano", "piano", "grand piano: a kind of piano"),
        ("harpsichord", "musical instrument", "harpsichord: a kind of musical instrument"),
    ],
)
def test_a_noun_that_was_not_trained_is_put_in_words_that_were(text, embedded, note):
    assert read(text) == (embedded, note)


@pytest.mark.parametrize(
    "text",
    ["sofa", "sofas", "couch", "a nice sofa", "locate the sofa", "can you see the sofa?",
     "red carpet", "park yourself near the sofa", "an old polaroid of a sofa", "kitchen"],
)  # fmt: skip
def test_what_the_vocabulary_names_is_left_as_it_is(text):
    assert read(text) == (text, None)


@pytest.mark.parametrize(
    ("text", "word"),
    [("walrus", "walrus"), ("go to the elephant", "elephant"), ("a mattress", "mattress"),
     ("the walrus in the kitchen", "walrus"), ("a plant on a credenza", "credenza")],
)  # fmt: skip
def test_an_unknown_noun_is_searched_for_and_said_to_be_unknown(text, word):
    assert read(text) == (text, f"the rehearsal encoder was not trained on '{word}'")


def test_the_common_sense_of_a_word_comes_first():
    # WordNet's first commode is a toilet, its second a chest of drawers.
    assert looked_up("commode") == ("toilet", "commode: another word for toilet")
    # Rarer senses count as synonyms only: a bar is a table in its second sense at most.
    assert looked_up("bar") is None


def test_the_table_leads_to_classes_and_is_small():
    classes = {*THINGS, *GROUPS, *ROOMS}
    assert len(table()) > 1000
    assert {name for name, _ in table().values()} <= classes
    assert not classes & {*table()}
    assert not {*TRAINED_SYNONYMS} & {*table()}
    found = {word: name for word in HELD_OUT_WORDS for name, _ in [table().get(word, ("", 0))]}
    assert {name for name in found.values() if name} <= {"musical instrument"}


def test_the_table_resolves_most_synonyms_that_no_training_had():
    right = [
        word for word, name in WITHHELD_SYNONYMS.items() if (looked_up(word) or [0])[0] == name
    ]
    assert len(right) >= 0.6 * len(WITHHELD_SYNONYMS)


def test_kinds_are_followed_a_few_steps_and_no_farther():
    up = {1: (), 2: (1,), 3: (2,), 4: (3,), 5: (4,), 6: (), 7: (6,)}
    senses = {"kind": (2,), "fourth": (5,), "third": (4,), "rare": (7, 2), "other": (7, 1)}
    found = word_table(WordNet(senses, up), {1: "sofa"})
    assert found["third"] == ("sofa", 3)
    assert found["kind"] == ("sofa", 1)
    assert "fourth" not in found  # four hypernyms up
    assert "rare" not in found  # a kind by its second sense only
    assert found["other"] == ("sofa", 0)


def test_the_shipped_encoder_knows_the_words_of_its_training():
    encoder = load_embedded_clip()
    assert encoder.reading("can you see my loveseat").text == "can you see my sofa"
    assert encoder.reading("can you see my sofa").note is None
