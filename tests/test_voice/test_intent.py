import pytest
from hypothesis import given
from hypothesis import strategies as st

from vizbot.operator.language.command import (
    All,
    Ask,
    ComeBack,
    Decline,
    Dock,
    Explore,
    GoTo,
    Reason,
    Stop,
    Topic,
    WhereIs,
)
from vizbot.operator.language.language import load_language
from vizbot.operator.session.vocabulary import HOUSEHOLD
from vizbot.operator.voice.intent import (
    CERTAIN,
    NEARLY,
    PLAIN,
    Hypothesis,
    after_wake,
    choose_utterance,
    confirmed,
    plain_utterance,
    resolve_command,
    resolve_goal,
)
from vizbot.operator.voice.sentence_bank import similarity

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
        # Other words for a thing are known however they sound.
        ("bookcase", "bookshelf"),
        ("home office", "study"),
    ],
)
def test_what_sounds_like_a_thing_is_that_thing(heard, goal):
    assert resolve_goal(heard, THINGS).goal == goal
    assert resolve_goal(heard, THINGS).candidate is None


def test_a_yellow_carrier_is_a_yellow_chair():
    meaning = resolve_goal("yellow carrier", ["yellow chair", "bookshelf", "kitchen"])
    assert "yellow chair" in (meaning.goal, meaning.candidate)


@pytest.mark.parametrize(
    ("heard", "known", "doubt"),
    [
        ("grandfather clock", THINGS, False),
        ("red fog", ["red dog", "red log"], True),
        ("yellow carrier", [], False),
    ],
    ids=["near nothing", "near two things", "nothing is known"],
)
def test_what_is_near_no_one_thing_stays_as_it_is(heard, known, doubt):
    meaning = resolve_goal(heard, known)
    assert meaning.goal == heard
    assert (meaning.candidate is not None) == doubt


def test_what_the_map_finds_is_meant_before_what_it_does_not():
    doubtful = resolve_goal("red fog", ["red dog", "red log"])
    assert doubtful.candidate is not None
    assert resolve_goal("red fog", ["red dog", "red log"], ["red log"]).goal == "red log"
    assert resolve_goal("kitchin", THINGS, ["chair"]).goal == "kitchen"
    assert resolve_goal("kitchen", THINGS, ["kid's room"]).goal == "kitchen"


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


def heard(free, known=(), **others):
    return choose_utterance(
        [Hypothesis(*each) for each in free],
        [Hypothesis(*each) for each in known],
        THINGS,
        **others,
    )


@pytest.mark.parametrize(
    ("free", "known", "command"),
    [
        (
            [("Go turn the kitten.", -0.4), ("Go to the kitchen.", -0.5)],
            [],
            GoTo(("kitchen",)),
        ),
        ([("Hind that jar.", -0.1)], [("Find the chair.", -1.5)], GoTo(("chair",))),
        (
            [("Find the photo album.", -0.1)],
            [("Find the kitchen.", -2.5)],
            GoTo(("photo album",)),
        ),
        ([("Stop the chair.", -0.1), ("Go to the chair.", -0.2)], [], Stop()),
    ],
    ids=["a worse guess that is known", "nearly as well", "heard clearly", "stop first"],
)
def test_what_is_known_is_taken_where_it_fits_nearly_as_well_but_for_stop(free, known, command):
    assert heard(free, known).command == command


def test_a_guess_that_does_not_fit_the_sound_is_not_taken():
    heard = choose_utterance(
        [Hypothesis("Nice weather.", -0.1)], [Hypothesis("Go to the kitchen.", -4.0)], THINGS
    )
    assert heard.command is None
    assert heard.text == "Nice weather."


def test_haste_is_heard_although_what_is_known_says_nothing_of_it():
    known = [("Hey robot, find the chair.", -1.5)]
    chosen = heard([("Hey robot, now hind that jar.", -0.1)], known, wake="hey robot")
    assert (chosen.command, chosen.at_once) == (GoTo(("chair",)), True)
    assert confirmed(chosen).at_once
    assert not heard([("Find the chair.", -0.1)]).at_once


def test_a_stop_among_the_guesses_is_taken_unless_something_fits_well():
    free = [("Hop the chair.", -0.4), ("Stop.", -0.6)]
    assert heard(free, [("Go to the chair.", -2.5)]).command == Stop()
    assert heard(free, [("Go to the chair.", -0.5)]).command == GoTo(("chair",))


def test_with_a_wake_phrase_all_but_stop_must_begin_with_it():
    for text, command in (
        ("Hey robot, come back.", ComeBack()),
        ("Hey, robots. Come back.", ComeBack()),
        ("Come back.", None),
        ("My robot is nice.", None),
        ("Oh, stop it.", Stop()),
    ):
        assert heard([(text, -0.1)], wake="hey robot").command == command


def test_what_follows_a_wake_phrase_is_given_back():
    assert after_wake("Hey, robot! Go on.", "hey robot") == "Go on."
    assert after_wake("", "hey robot") is None


@given(st.text(max_size=30), st.text(max_size=30))
def test_likeness_is_between_nought_and_one_and_the_same_both_ways(a, b):
    assert 0.0 <= similarity(a, b) <= 1.0
    assert similarity(a, b) == pytest.approx(similarity(b, a))
    assert resolve_goal(a, [b]).goal in (a, b)


def test_a_free_hypothesis_that_asks_for_more_wins_where_all_of_it_is_known():
    bound = [("Go to the kitchen.", -0.9)]
    for text, command in (
        ("Go to the kitchen, then come back.", GoTo(("kitchen",), ComeBack())),
        ("Go to the kitchen, then dock.", GoTo(("kitchen",), Dock())),
        ("Go to the kitchen and explore.", GoTo(("kitchen",), Explore())),
        ("Go to the kitchen, the study, then the chair.", GoTo(("kitchen", "study", "chair"))),
    ):
        assert heard([(text, -0.8)], bound).command == command
    assert heard([("Go to the kitchen, then the sop.", -0.8)], bound).command == GoTo(("kitchen",))


def test_a_free_command_without_a_thing_wins():
    assert heard([("Explore.", -0.5)], [("Come back.", -1.0)]).command == Explore()
    assert heard([("Where are you?", -0.5)], [("Go to the chair.", -1.0)]).command == Ask(
        Topic.PLACE
    )


def test_what_forbids_is_not_taken_for_what_it_forbids():
    forbids = [("Don't go to the kitchen.", -0.4)]
    assert heard(forbids, [("Go to the kitchen.", -1.0)]).command == Decline(Reason.NOT)
    assert heard([("Don't.", -1.9)], [("Dock.", -1.7)]).command == Dock()
    denies = [("Is there no chair here?", -0.9)]
    assert heard(denies, [("Is there the chair here?", -1.0)]).command == WhereIs("chair")


def test_what_drives_and_was_not_heard_well_is_asked_back():
    unsure = heard([("Go to the kitchen.", CERTAIN - 0.1)])
    assert unsure.question == 'did you say "go to kitchen"?'
    assert confirmed(unsure).question is None
    assert confirmed(unsure).command == GoTo(("kitchen",))
    known = [("Go to the kitchen.", -0.4 - NEARLY)]
    assert heard([("Two chicken.", -0.3)], known).question is not None
    assert heard([("Two chicken.", -0.3), ("Go to the kitchen", -0.7)], known).question is None
    assert heard([("Two chicken.", -0.3)], [("Where is the sink?", -1.9)]).question is None
    forbids = [("Go to the kitchen.", -0.3), ("Don't go to the kitchen.", -0.5)]
    assert heard(forbids, [("Go to the kitchen.", -0.3)]).question is not None
    assert heard([("Where is the kitchen?", CERTAIN - 0.1)]).question is None
    assert heard([("Stop.", CERTAIN - 0.1)]).question is None


def test_a_plain_command_that_was_heard_well_is_believed_at_once():
    well = [Hypothesis("Go to the kitchens, then the kids room.", PLAIN)]
    assert plain_utterance(well, THINGS).command == GoTo(("kitchen", "kid's room"))
    for text, score in (
        ("Go to the kitchen.", PLAIN - 0.1),
        ("Go to the kitchin.", -0.1),
        ("Go to the mace.", -0.1),
        ("Nice weather.", -0.1),
        ("Don't go to the kitchen.", -0.1),
    ):
        assert plain_utterance([Hypothesis(text, score)], THINGS) is None


def test_german_is_understood_from_what_whisper_writes():
    german = load_language("de")
    words = [german.lexicon.own(word) for word in HOUSEHOLD]
    for text, command in (
        ("Fahr in die Küche, dann komm zurück.", GoTo(("küche",), ComeBack())),
        ("Wo ist der Kühlschrank?", WhereIs("kühlschrank")),
        ("Erkunde die Wohnung.", Explore()),
        ("Wie voll ist der Akku?", Ask(Topic.BATTERY)),
        ("Stopp!", Stop()),
    ):
        hypotheses = [Hypothesis(text, -0.2)]
        assert choose_utterance(hypotheses, [], words, language=german).command == command


def test_a_command_is_asked_back_where_the_best_guess_names_another_thing_that_is_known():
    free = [("Got the study, then comb bag.", -0.9)]
    disputed = heard(free, [("Go to the chair, then come back.", -1.0)])
    assert disputed.command == GoTo(("chair",), ComeBack())
    assert disputed.question is not None
    assert heard(free, [("Go to the chair, then come back.", -0.5)]).question is None
    agreed = [("Go to the yellow care. Then comeback.", -0.9)]
    assert heard(agreed, [("Go to the yellow chair.", -0.9)]).question is None


def test_a_guess_that_is_not_the_best_is_asked_back_where_nothing_known_fits():
    free = [("At the floor info alone.", -0.9), ("Let's go to the kitchen.", -1.2)]
    assert heard(free, [("Explore.", -5.4)]).question == 'did you say "go to kitchen"?'
    assert heard(free).question is None


def test_a_plain_command_without_a_thing_is_believed_however_it_was_heard():
    unclear = PLAIN - 0.5
    assert plain_utterance([Hypothesis("What do you see?", unclear)], THINGS) is not None
    perhaps_stop = [Hypothesis("Go on.", unclear), Hypothesis("Stop.", unclear - 0.1)]
    assert plain_utterance(perhaps_stop, THINGS) is None


def test_a_fuller_guess_is_asked_back_where_the_best_one_is_a_command_that_asks_for_less():
    free = [("Go to the kitchen.", -0.6), ("Go to the kitchen. Come back.", -0.9)]
    doubtful = heard(free, [("Go to the kitchen.", -0.6)])
    assert doubtful.command == GoTo(("kitchen",), ComeBack())
    assert doubtful.question is not None
