"""Names of things and rooms: known, other words for them, written alike, unknown."""

import ast
import re

import numpy as np
import pytest

from tests.helpers.checkout import ROOT
from vizbot.behaviours.safety import MAYBE_MOVED
from vizbot.core.home_vocabulary import GROUPS, ROOMS, SYNONYMS, THINGS
from vizbot.objectnav import reasons
from vizbot.objectnav.option import Option
from vizbot.operator.language.command import GoTo, WhereIs, goals_of
from vizbot.operator.language.language import ENGLISH, languages, load_language
from vizbot.operator.language.understanding import understand
from vizbot.operator.session.vocabulary import HOUSEHOLD

NAMES = sorted({*THINGS, *ROOMS, *GROUPS, *HOUSEHOLD})
OTHER_WORDS = [word for table in (SYNONYMS, ROOMS) for words in table.values() for word in words]
GERMAN = load_language("de")


def understood(text, language=ENGLISH):
    command = language.grammar.typed(text)
    return understand(command, language, language.grammar.literals(text))


@pytest.mark.parametrize("say", ["{}", "go to the {}", "a {}", "my red {}, please"])
def test_no_name_of_the_encoder_is_asked_back(say):
    asked = [name for name in NAMES if understood(say.format(name)).question is not None]
    assert asked == []
    for name in NAMES:
        assert isinstance(understood(say.format(name)).command, GoTo), name


def test_every_other_word_is_understood_and_said():
    for word in OTHER_WORDS:
        meant = understood(f"go to the {word}")
        assert meant.question is None, word
        if word not in NAMES:
            (goal,) = meant.command.goals
            assert goal in NAMES and meant.notes == (f"{word}: {goal}",)


@pytest.mark.parametrize(
    ("word", "name"),
    [("couch", "sofa"), ("fridge", "refrigerator"), ("telly", "tv"), ("rug", "carpet")],
)
def test_what_means_the_same_is_said(word, name):
    assert understood(f"Where is the {word}?").command == WhereIs(name)
    assert understood(f"my old {word}").notes == (f"{word}: {name}",)


def test_a_kind_of_what_it_knows_keeps_its_name():
    meant = understood("go to the rocking chair")
    assert (meant.command, meant.notes) == (GoTo(("rocking chair",)), ())


@pytest.mark.parametrize(
    ("written", "meant"),
    [("kitchn", "kitchen"), ("go to the yelow chair", "yellow chair"), ("bethroom", "bathroom"),
     ("where is the refridgerator", "refrigerator"), ("coffe machine", "coffee machine"),
     ("how many chiars are there", "chair")],
)  # fmt: skip
def test_what_is_written_alike_is_offered(written, meant):
    doubtful = understood(written)
    assert doubtful.question == f'did you mean "{meant}"?'
    settled = understood(doubtful.meant)
    assert settled.question is None and meant in str(settled.command)


@pytest.mark.parametrize("word", ["asdf", "xyzzy", "the moon", "a unicorn", "my gizmo"])
def test_what_is_far_from_every_word_is_asked_back(word):
    plain = ENGLISH.grammar.typed(word).goals[0]
    doubtful = understood(word)
    assert doubtful.question == f'I can go to things and rooms. Search for "{plain}"?'
    assert understood(doubtful.meant).question is None


def test_of_several_doubts_each_is_asked_in_turn():
    first = understood("go to the kitchn, then the asdf, then come back")
    assert first.question == 'did you mean "kitchen"?'
    second = understood(first.meant)
    assert second.question == 'I can go to things and rooms. Search for "asdf"?'
    assert second.meant == 'go to kitchen, then "asdf", then come back'
    assert understood(second.meant).question is None


def test_goals_between_moves_are_read_like_others():
    meant = understood("turn around, then go to the couch and bed, then turn left, then the loo")
    assert goals_of(meant.command) == ("sofa", "bed", "toilet")
    assert meant.notes == ("couch: sofa", "loo: toilet")
    doubtful = understood("turn around, then the kitchn")
    assert doubtful.meant == "turn left 180 degrees, then go to kitchen"


def test_what_is_in_quotes_is_never_asked_back():
    assert understood('find the "last exit" sign').command == GoTo(("last exit sign",))


def test_things_in_a_row_are_several_goals_and_a_name_with_and_is_one():
    assert understood("sofa and bed").command == GoTo(("sofa", "bed"))
    assert understood("table and chairs").command == GoTo(("table", "chairs"))
    assert understood("salt and pepper").question is not None


def test_german_has_a_word_for_every_name_and_reads_all_its_words():
    known = {*GERMAN.lexicon.names.values()}
    assert [name for name in {*THINGS, *ROOMS, *GROUPS} - known if name != "tv"] == []
    for plain, written in GERMAN.lexicon.offered.items():
        meant = understood(written, GERMAN)
        (goal,) = meant.command.goals
        assert meant.question is None
        assert goal.casefold() == GERMAN.lexicon.names[plain]


def test_german_says_which_word_was_taken():
    assert understood("geh zum Kühlschrank", GERMAN).notes == ("kühlschrank: refrigerator",)
    assert GERMAN.lexicon.own("kitchen") == "Küche"
    assert understood("Kühlschrnk", GERMAN).question == 'meinst du "Kühlschrank"?'


def test_every_language_has_the_answers_and_the_sentences_of_english():
    for language in map(load_language, languages()):
        assert {*language.answers} == {*ENGLISH.answers}
        for answer, text in language.answers.items():
            fields = ("goal", "text", "heard", "meant", "percent", "room", "names", "activity",
                      "task", "why", "word")  # fmt: skip
            for field in fields:
                assert (f"{{{field}" in text) == (f"{{{field}" in ENGLISH.answers[answer])


def activities():
    """What the robot may be doing, as the sources call it."""
    found = set()
    for path in (ROOT / "vizbot").rglob("*.py"):
        for call in ast.walk(ast.parse(path.read_text())):
            if isinstance(call, ast.Call) and getattr(call.func, "id", "") == "Decision":
                said = call.args[1]
                found |= {said.value} if isinstance(said, ast.Constant) else set()
    touched = {"a bump", "an edge", "a virtual wall", "a stuck wheel"}
    others = {"starting", "exploring", "looking closer", "going to what was found"}
    others |= {MAYBE_MOVED.text}
    return found | others | {f"backing off after {what}" for what in touched}


def test_what_it_does_and_why_is_said_in_german():
    assert len(activities()) > 30
    constants = {name: value for name, value in vars(reasons).items() if name[0].isupper()}
    texts = {value for value in constants.values() if isinstance(value, str)}
    clauses = texts - {reasons.CLAUSE_JOINT}
    assert {*GERMAN.entries["doing"]} == activities() | clauses
    for english, own in GERMAN.entries["doing"].items():
        assert re.findall(r"{\w+}", english) == re.findall(r"{\w+}", own)
    why = reasons.looking_closer(Option("place", np.array([3.0, 4.0]), 0.4, 4.0), np.eye(4))
    said = "etwas in 5 m Entfernung ist es vielleicht (40%); aus der Nähe sagt es mehr"
    assert GERMAN.doing(why) == said and ENGLISH.doing(why) == why
    assert GERMAN.doing(f"{reasons.NEAREST}; whatever").endswith("; whatever")
