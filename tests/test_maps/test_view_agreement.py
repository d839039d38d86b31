import numpy as np
import pytest

from mapping.clip.view_agreement import MOST, AgreementRule, agreed_similarities


def agreed(at, places, similarities, keyframes, **settings):
    points = np.column_stack([places, np.zeros(len(places)), np.arange(len(places))])
    return agreed_similarities(
        np.array([[at, 0.0]]),
        points,
        np.array(similarities, np.float32),
        np.array(keyframes, np.int32),
        AgreementRule(**{"floor": 0.2, "radius": 0.5, "views": 2} | settings),
    )[0]


def test_the_best_keyframes_count_with_their_best():
    similarities, keyframes = [0.3, 0.5, 0.4, 0.25], [0, 0, 1, 2]
    assert agreed(0.0, [0.0, 0.1, 0.2, 0.3], similarities, keyframes) == pytest.approx(0.45)


def test_one_keyframe_alone_is_believed_half():
    assert agreed(0.0, [0.0, 0.1], [0.6, 0.6], [3, 3]) == pytest.approx(0.4)
    assert agreed(0.0, [0.0, 0.1], [0.6, 0.6], [3, 3], views=1) == pytest.approx(0.6)


def test_what_is_elsewhere_or_below_the_floor_does_not_count():
    assert agreed(0.0, [0.6, 0.1], [0.9, 0.1], [0, 1]) == pytest.approx(0.2)


def test_a_keyframe_seen_again_later_counts_once():
    assert agreed(0.0, [0.0, 0.0, 0.0], [0.6, 0.5, 0.6], [1, 2, 1]) == pytest.approx(0.55)


def test_the_most_similar_of_very_many_are_weighed():
    many = MOST + 50
    similarities = np.full(many, 0.3)
    similarities[-2:] = 0.8
    keyframes = np.arange(many)
    assert agreed(0.0, np.zeros(many), similarities, keyframes) == pytest.approx(0.8)


def test_what_is_farther_off_says_less():
    places, similarities, keyframes = [0.3, 0.0], [0.6, 0.5], [0, 1]
    assert agreed(0.0, places, similarities, keyframes, falloff=0.5) == pytest.approx(0.475)
