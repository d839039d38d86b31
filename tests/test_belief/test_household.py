"""Beliefs for the words of a household: as many as there are questions, and no more."""

from types import SimpleNamespace

import numpy as np

from mapping.clip.background.phrases import other_rooms
from mapping.clip.places.likeliest_places import belief_of_map
from mapping.clip.scores import Query
from tests.helpers.bundles import bundle_of
from vizbot.config import Config
from vizbot.core.errors import ConfigError
from vizbot.core.home_vocabulary import ROOMS
from vizbot.operator.session.household import HouseholdBeliefs
from vizbot.operator.session.vocabulary import HOUSEHOLD


def embedding_of(text):
    drawn = np.random.default_rng(list(text.encode())).normal(size=4)
    return (drawn / np.linalg.norm(drawn)).astype(np.float32)


class Robot:
    """Embeds words; each text has an embedding of its own."""

    config = Config()
    map = SimpleNamespace(number=0)

    def goal(self, text):
        return text

    def question(self, text):
        rivals = [embedding_of(each) for each in other_rooms(text)]
        return Query(embedding_of(text), (10.0, -5.0), rivals)


def test_there_is_one_belief_for_each_question_however_often_and_by_whom_it_is_asked():
    household, robot = HouseholdBeliefs(), Robot()
    for frames in (6, 9, 12):
        bundle = bundle_of(4, frames=frames)
        household.found(bundle, 0, robot)
        household.in_view(bundle, 0, robot)
        household.believed(tuple(ROOMS), bundle, 0, robot)
    asked = {*HOUSEHOLD, *ROOMS, *(other for room in ROOMS for other in other_rooms(room))}
    assert len(household) <= len(asked) < 100


def test_beliefs_of_another_map_take_the_place_of_those_before():
    household, robot = HouseholdBeliefs(), Robot()
    for number in range(3):
        household.believed(tuple(ROOMS), bundle_of(number, frames=9), number, robot)
    assert len(household) <= len({other for room in ROOMS for other in (room, *other_rooms(room))})


def test_what_is_believed_of_a_word_is_what_the_whole_map_gives():
    household, robot, bundle = HouseholdBeliefs(), Robot(), bundle_of(7, frames=30)
    words = ("kitchen", "bedroom", "sofa")
    for _ in range(2):
        believed = household.believed(words, bundle, 0, robot)
    for word in words:
        whole = belief_of_map(
            bundle.place_map(),
            bundle.keyframes.poses(),
            bundle.elements.embeddings,
            bundle.statistics,
            bundle.pictures,
            robot.question(robot.goal(word)),
        )
        np.testing.assert_array_equal(believed[word].low, whole.low)
        np.testing.assert_allclose(believed[word].probabilities, whole.probabilities, atol=1e-6)


class RobotOfNames(Robot):
    """Its encoder has no name for some words."""

    def goal(self, text):
        if text in ("window", "study"):
            raise ConfigError(f"no name for {text!r}")
        return text


def test_words_that_the_encoder_has_no_name_for_are_left_out():
    household, robot, bundle = HouseholdBeliefs(), RobotOfNames(), bundle_of(7, frames=9)
    for _ in range(2):
        believed = household.believed(("sofa", "window", "study"), bundle, 0, robot)
        assert set(believed) == {"sofa"}
    assert household.believed(("window",), bundle, 0, robot) == {}
    assert not {"window", "study"} & set(household.in_view(bundle, 0, robot))
