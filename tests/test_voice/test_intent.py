import pytest
from hypothesis import given
from hypothesis import strategies as st

from vizbot.operator.language.command import All, ComeBack, GoTo, Stop, WhereIs
from vizbot.operator.voice.intent import (
    Hypothesis,
    after_wake,
    choose_utterance,
    confirmed,
    resolve_command,
    resolve_goal,
    similarity,
)

THINGS = ("yellow chair", "bookshelf", "chair", "electric fan", "kitchen", "kid's room", "study")


@pytest.mark.parametrize(
    ("heard", "goal"),
    [
        ("yellow chair", "yellow chair"),
        ("Yellow  Chair", "yellow chair"),
        ("yellow chairs", "yellow chair"),
        ("book shelf", "bookshelf"),
        ("bookshelves", "bookshelf"),
        ("studies", "study"),
        ("kids room", "kid's room"),
        ("electric van", "electric fan"),
        ("kitchin", "kitchen"),
    ],
)
def test_what_sounds_like_a_thing_is_that_thing(heard, goal):
    assert resolve_goal(heard, THINGS).goal == goal
    assert resolve_goal(heard, THINGS).candidate is None


def test_a_yellow_carrier_is_a_yellow_chair():
    meaning = resolve_goal("yellow carrier", ["yellow chair", "bookshelf", "kitchen"])
    assert "yellow chair" in (meaning.goal, meaning.candidate)


def test_what_is_near_nothing_stays_as_it_is():
    meaning = resolve_goal("grandfather clock", THINGS)
    assert meaning.goal == "grandfather clock"
    assert meaning.candidate is None


def test_two_things_that_sound_alike_leave_a_doubt():
    meaning = resolve_goal("red fog", ["red dog", "red log"])
    assert meaning.goal == "red fog"
    assert meaning.candidate is not None


def test_what_the_map_finds_is_meant_before_what_it_does_not():
    doubtful = resolve_goal("red fog", ["red dog", "red log"])
    assert doubtful.candidate is not None
    assert resolve_goal("red fog", ["red dog", "red log"], ["red log"]).goal == "red log"
    assert resolve_goal("kitchin", THINGS, ["chair"]).goal == "kitchen"
    assert resolve_goal("kitchen", THINGS, ["kid's room"]).goal == "kitchen"


def test_nothing_known_leaves_every_goal_alone():
    assert resolve_goal("yellow carrier", []).goal == "yellow carrier"


def test_the_goals_of_every_kind_of_command_are_resolved():
    assert resolve_command(GoTo(("kitchin", "book shelf")), THINGS)[0] == GoTo(
        ("kitchen", "bookshelf")
    )
    assert resolve_command(WhereIs("kitchin"), THINGS)[0] == WhereIs("kitchen")
    assert resolve_command(All("chairs"), THINGS)[0] == All("chair")
    assert resolve_command(Stop(), THINGS) == (Stop(), ())


def test_a_doubt_is_settled_by_a_yes():
    heard = choose_utterance([Hypothesis("go to the red fog", -0.1)], [], ["red dog", "red log"])
    assert heard.question is not None
    assert confirmed(heard).command in (GoTo(("red dog",)), GoTo(("red log",)))
    assert confirmed(heard).question is None


def test_a_worse_guess_about_something_known_is_taken():
    hypotheses = [Hypothesis("Go turn the kitten.", -0.4), Hypothesis("Go to the kitchen.", -0.5)]
    assert choose_utterance(hypotheses, [], THINGS).command == GoTo(("kitchen",))


def test_a_guess_that_does_not_fit_the_sound_is_not_taken():
    heard = choose_utterance(
        [Hypothesis("Nice weather.", -0.1)], [Hypothesis("Go to the kitchen.", -4.0)], THINGS
    )
    assert heard.command is None
    assert heard.text == "Nice weather."


def test_a_sentence_that_fits_nearly_as_well_is_taken_for_what_was_misheard():
    known = [Hypothesis("Find the chair.", -1.5)]
    assert choose_utterance([Hypothesis("Hind that jar.", -0.1)], known, THINGS).command == GoTo(
        ("chair",)
    )


def test_what_was_heard_clearly_is_not_bent_to_what_is_known():
    known = [Hypothesis("Find the kitchen.", -2.5)]
    heard = choose_utterance([Hypothesis("Find the photo album.", -0.1)], known, THINGS)
    assert heard.command == GoTo(("photo album",))


def test_haste_is_heard_although_what_is_known_says_nothing_of_it():
    free = [Hypothesis("Hey robot, now hind that jar.", -0.1)]
    known = [Hypothesis("Hey robot, find the chair.", -1.5)]
    heard = choose_utterance(free, known, THINGS, "hey robot")
    assert (heard.command, heard.at_once) == (GoTo(("chair",)), True)
    assert confirmed(heard).at_once
    assert not choose_utterance([Hypothesis("Find the chair.", -0.1)], [], THINGS).at_once


def test_a_stop_among_the_guesses_is_taken_unless_something_fits_well():
    free = [Hypothesis("Hop the chair.", -0.4), Hypothesis("Stop.", -0.6)]
    assert choose_utterance(free, [Hypothesis("Go to the chair.", -2.5)], THINGS).command == Stop()
    assert choose_utterance(free, [Hypothesis("Go to the chair.", -0.5)], THINGS).command == GoTo(
        ("chair",)
    )


def test_stop_is_taken_before_anything_known():
    hypotheses = [Hypothesis("Stop the chair.", -0.1), Hypothesis("Go to the chair.", -0.2)]
    assert choose_utterance(hypotheses, [], THINGS).command == Stop()


def test_with_a_wake_phrase_all_but_stop_must_begin_with_it():
    known = THINGS
    for text, command in (
        ("Hey robot, come back.", ComeBack()),
        ("Hey, robots. Come back.", ComeBack()),
        ("Come back.", None),
        ("My robot is nice.", None),
        ("Oh, stop it.", Stop()),
    ):
        assert choose_utterance([Hypothesis(text, -0.1)], [], known, "hey robot").command == command


def test_what_follows_a_wake_phrase_is_given_back():
    assert after_wake("Hey, robot! Go on.", "hey robot") == "Go on."
    assert after_wake("", "hey robot") is None


@given(st.text(max_size=30), st.text(max_size=30))
def test_likeness_is_between_nought_and_one_and_the_same_both_ways(a, b):
    assert 0.0 <= similarity(a, b) <= 1.0
    assert similarity(a, b) == pytest.approx(similarity(b, a))
    assert resolve_goal(a, [b]).goal in (a, b)
