import numpy as np
import pytest

from mapping.clip.placement import halvings
from vizbot.config import AgreementConfig
from vizbot.perception.sightings import Sightings


def sighted(places, similarities, keyframes, seen_from=None, halvings=None):
    """Elements at x, by default seen from where they are."""
    zeros, keyframes = np.zeros(len(places)), np.array(keyframes, np.int32)
    cameras = places if seen_from is None else seen_from
    return Sightings(
        np.column_stack([places, zeros, zeros]),
        np.array(similarities, np.float32),
        keyframes,
        keyframes,
        np.column_stack([cameras, zeros]),
        np.array(zeros if halvings is None else halvings, np.float32),
    )


def ranked(places, similarities, keyframes, seen_from=None, halvings=None, **settings):
    """Their ranks."""
    return sighted(places, similarities, keyframes, seen_from, halvings).ranks(
        AgreementConfig(**settings)
    )


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


def test_what_was_seen_from_near_by_ranks_before_what_was_a_little_more_similar_from_afar():
    places, similarities = [0.0, 5.0, 20.0], [0.55, 0.5, 0.0]
    near, far = [0.0, 5.0, 20.0], [4.0, 5.0, 20.0]
    assert ranked(places, similarities, [0, 1, 2], near, views=1).argmax() == 0
    assert ranked(places, similarities, [0, 1, 2], far, views=1).argmax() == 1
    assert ranked(places, similarities, [0, 1, 2], far, views=1, range_doubt=0.0).argmax() == 0


def test_what_a_large_patch_shows_ranks_before_what_a_small_one_is_a_little_surer_of():
    places, keyframes = [0.0, 5.0, 9.0], [0, 1, 2]
    for small, best in ((0.62, 0), (0.75, 1)):
        ranks = ranked(places, [0.60, small, 0.1], keyframes, halvings=[0, 2, 0], views=1)
        assert ranks.argmax() == best


def test_patches_are_told_by_how_often_the_largest_was_halved():
    boxes = np.array([[0, 0, 448, 448], [10, 0, 234, 224], [0, 5, 112, 117]], np.int32)
    assert halvings(boxes).tolist() == [0.0, 1.0, 2.0]
    assert halvings(boxes[:0]).shape == (0,)


def test_what_lies_beside_the_goal_counts_little_more_than_it_is_similar_itself():
    carpet = [(0.0, 0.0), (0.1, 0.0), (0.2, 0.0)]
    points = np.array([(x, y, 0.0) for x, y in [*carpet, (0.6, 0.0)]])
    similarities = np.array([0.6, 0.6, 0.6, 0.42], np.float32)
    frames, zeros = np.arange(4, dtype=np.int32), np.zeros(4, np.float32)
    seen = Sightings(points, similarities, frames, frames, points[:, :2] - 1.0, zeros)
    agreed = seen.agreed(AgreementConfig(views=3, lent=0.2), 0.4)
    assert agreed[:3].min() > 0.58
    assert agreed[3] == pytest.approx(0.504)


def test_of_the_place_that_views_agree_on_the_most_similar_patch_is_the_answer():
    """A cup on a table: large patches show both, a small one little else."""
    places, similarities = [0.0, 0.0, 0.2, 0.6, 5.0], [0.50, 0.51, 0.55, 0.56, 0.1]
    seen = sighted(places, similarities, range(5), halvings=[0, 0, 2, 2, 0])
    config = AgreementConfig(views=2, halving_doubt=0.08)
    assert seen.ranks(config).argmax() == 1
    assert seen.answers(config)[0] == 2
    assert seen.answers(config, count=1) == (2,)
    assert seen.take(np.zeros(5, bool)).answers(config) == ()
