from collections import Counter

import pytest

from sim_stubs.homes.furniture import procedural
from sim_stubs.homes.furniture.catalogue import CLASSES
from vizbot.core import home_vocabulary as vocabulary
from vizbot.core.home_vocabulary import (
    COLOURS,
    EVALUATION_CLASSES,
    GROUPS,
    ROOMS,
    SYNONYMS,
    THINGS,
    akin,
    class_of,
    kinds,
    room_of,
)


def test_every_class_of_furniture_can_be_told():
    assert {*CLASSES, *procedural.SHAPES} <= {*THINGS}


@pytest.mark.parametrize(
    ("label", "classes"),
    [
        ("sofa", ("sofa",)),
        ("office chair", ("office chair", "chair")),
        ("yellow chair", ("yellow chair", "chair")),
        ("yellow office chair", ("yellow office chair", "office chair", "chair")),
        ("washing machine", ("washing machine", "laundry")),
        ("single bed", ("single bed", "bed")),
        ("bunk bed", ("bunk bed", "bed")),
        ("no such thing", ("no such thing",)),
    ],
)
def test_an_instance_belongs_to_its_class_and_the_wider_ones(label, classes):
    assert kinds(label) == classes


def test_nothing_is_both_of_a_class_and_perhaps_of_it():
    for thing in THINGS:
        assert not {*kinds(thing)} & {*akin(thing)}
    assert "table" in akin("desk")


def test_what_is_merely_like_a_goal_counts_against_it():
    assert "sofa" not in akin("armchair")
    assert "toilet" not in akin("bidet")
    assert "tv" not in akin("computer")
    assert kinds("armchair") == ("armchair", "chair")


def test_every_word_stands_for_one_class():
    words = Counter(
        word
        for table in (SYNONYMS, ROOMS)
        for name, others in table.items()
        for word in (name, *others)
    )
    assert [word for word, count in words.items() if count > 1] == []
    assert not {word for others in SYNONYMS.values() for word in others} & {*THINGS, *GROUPS}


def test_a_class_is_found_by_any_of_its_words():
    assert class_of("couch") == "sofa"
    assert class_of(" TV  set") == "tv"
    assert class_of("corridor") == "hallway"
    assert class_of("laundry") == "laundry"
    assert class_of("giraffe") is None


def test_the_sort_of_a_room_is_the_end_of_its_name():
    assert room_of("second bedroom") == "bedroom"
    assert room_of("Lounge") == "living room"
    assert room_of("kid's room") == "kid's room"
    assert room_of("wine cellar") is None


def test_tables_speak_of_known_things():
    known = {*THINGS, *GROUPS}
    tables = (vocabulary._AKIN, vocabulary._WIDER, GROUPS)
    for table in tables:
        assert {word for others in table.values() for word in others} <= known
    assert {*vocabulary._AKIN, *vocabulary._WIDER} <= known
    assert {*SYNONYMS} <= known
    assert {near for others in COLOURS.values() for near in others} <= {*COLOURS}


def test_the_evaluation_has_the_papers_goals_and_sixty_classes_more():
    assert len(set(EVALUATION_CLASSES)) == len(EVALUATION_CLASSES)
    things = [name for name in EVALUATION_CLASSES if name not in ROOMS]
    assert len(EVALUATION_CLASSES) >= 60
    assert {*things} <= {*THINGS, *GROUPS}
