import numpy as np

from vizbot.config import AgreementConfig
from vizbot.sightings import rank


def ranked(places, similarities, keyframes, **settings):
    points = np.column_stack([places, np.zeros((len(places), 2))])
    config = AgreementConfig(**settings)
    return rank(points, np.array(similarities, np.float32), np.array(keyframes), config)


def test_what_several_views_agree_on_ranks_before_what_one_view_is_surer_of():
    places = [0.0, 5.0, 5.1, 5.2, 9.0]
    ranks = ranked(places, [0.60, 0.50, 0.52, 0.51, -0.1], [0, 1, 2, 3, 4])
    assert ranks.argmax() == 2
    assert ranks[0] < 0.5


def test_one_keyframe_alone_does_not_agree_with_itself():
    places = [0.0, 0.0, 0.0, 5.0, 5.0, 9.0]
    ranks = ranked(places, [0.60, 0.59, 0.58, 0.5, 0.5, 0.0], [0, 0, 0, 1, 2, 4])
    assert ranks.argmax() in (3, 4)


def test_of_elements_above_each_other_the_most_similar_ranks_first():
    assert ranked([0.0, 0.0, 0.0, 9.0], [0.5, 0.7, 0.6, 0.1], [0, 0, 0, 0]).argmax() == 1


def test_with_one_view_the_most_similar_ranks_first_as_in_the_paper():
    similarities = [0.60, 0.50, 0.52, 0.51, -0.1]
    ranks = ranked([0.0, 5.0, 5.1, 5.2, 9.0], similarities, [0, 1, 2, 3, 4], views=1)
    assert ranks.argmax() == 0


def test_the_rest_of_a_large_map_ranks_behind_by_similarity():
    similarities = np.linspace(0.9, -0.9, 2000)
    ranks = ranked(np.arange(2000.0) * 3, similarities, np.arange(2000))
    assert ranks[:600].min() >= ranks[600:].max()
    assert (np.diff(ranks[600:]) < 0).all()


def test_an_empty_map_ranks_nothing():
    assert len(ranked([], [], [])) == 0
