"""Sentences of the grammar that sound like what was heard."""

import pytest

from vizbot.operator.language.command import Dock, GoTo
from vizbot.operator.language.language import ENGLISH, languages, load_language
from vizbot.operator.session.vocabulary import HOUSEHOLD
from vizbot.operator.voice.sentence_bank import SentenceBank

MOST = 10


@pytest.fixture(scope="module")
def bank():
    return SentenceBank(ENGLISH.grammar, ENGLISH.spoken)


@pytest.mark.parametrize(
    ("heard", "said"),
    [
        ("Scene the whole house.", "See the whole house."),
        ("Hand to the start.", "Head to the start."),
        ("Go on. The knocking station.", "Go on the docking station."),
        ("Trundel over at the electric fan.", "Trundle over at the electric fan."),
        ("Well, talk to you?", "What are you?"),
    ],
)
def test_what_is_spelt_by_its_sound_is_near_what_was_said(bank, heard, said):
    near = bank.nearest(heard, HOUSEHOLD, 3 * MOST)
    intended = ENGLISH.grammar.heard(said)
    assert intended is not None
    assert intended in map(ENGLISH.grammar.heard, near)


def test_sentences_are_written_as_whisper_does_about_the_thing_that_was_heard(bank):
    near = bank.nearest("Hind the Chest of Drawers?", HOUSEHOLD, MOST)
    assert len(near) == MOST
    assert all(text[0].isupper() and text.endswith("?") for text in near)
    assert all("the chest of drawers" in text for text in near)


def test_what_sounds_like_no_sentence_is_near_none(bank):
    for heard in (
        "",
        "...",
        "Nevertheless the parliament voted on Wednesday evening in favour of it.",
    ):
        assert bank.nearest(heard, HOUSEHOLD, MOST) == []


@pytest.mark.parametrize("code", languages())
def test_nearly_every_whole_sentence_of_a_language_is_near_itself(code):
    language = load_language(code)
    bank = SentenceBank(language.grammar, language.spoken)
    whole = [text for text in language.grammar.examples if language.grammar.heard(text) is not None]
    alone = [text for text in whole if not any(letter.isdigit() for letter in text)]
    found = [text for text in alone if text in bank.nearest(text, HOUSEHOLD, MOST)]
    assert len(found) >= 5, found


@pytest.mark.parametrize(
    ("heard", "goals", "after"),
    [
        ("Go to the lamp. In the sofa, and den to the sink, and dog.", "lamp sofa sink", Dock()),
        ("Could you please go to the sofa and nd go to the armchair and the clock?",
         "sofa armchair clock", None),
        ("Fine the lamp, in the sofa.", "lamp sofa", None),
    ],
)  # fmt: skip
def test_a_mission_is_read_where_only_its_joins_are_spelt_by_their_sounds(
    bank, heard, goals, after
):
    mission = bank.mission(heard, HOUSEHOLD)
    assert ENGLISH.grammar.heard(mission) == GoTo(tuple(goals.split()), after)


@pytest.mark.parametrize(
    "heard",
    [
        "Go to the sofa.",
        "Show me the table but not the chair.",
        "Go to the sofa, but first go to the bed.",
        "Go to the sofa after the bed.",
        "Where is the sofa and the sink?",
        "I see the sofa and the chair.",
        "Go to the lamp, the sofa, the sink and the bed.",
        "",
    ],
)
def test_what_is_no_mission_or_has_another_order_is_none(bank, heard):
    assert bank.mission(heard, HOUSEHOLD) is None
