"""The paper's figures agree with each other: a slip in copying one would show."""

import itertools

import pytest

from benchmarks.objectnav.paper_figures import MULTI, OBJECT_NAVIGATION, RETRIEVAL, SCALES

COCO, OTHERS = 26, 28


def test_each_set_of_scales_has_the_features_of_its_scales():
    of_one = {scales[0]: features for scales, features, _ in SCALES if len(scales) == 1}
    assert of_one == {1: 1, 0: 4, -1: 20, -2: 88}
    for scales, features, success in SCALES:
        assert features == sum(of_one[scale] for scale in scales)
        assert round(100 * round(success / 100 * 54) / 54, 1) == success


@pytest.mark.parametrize("row", [*OBJECT_NAVIGATION, *RETRIEVAL], ids=lambda row: row[0])
def test_the_rate_of_all_is_that_of_objects_in_coco_and_of_others(row):
    _, of_all, coco, others = row
    successes = round(COCO * coco / 100) + round(OTHERS * others / 100)
    assert round(100 * successes / (COCO + OTHERS), 1) == of_all
    for rate, episodes in ((coco, COCO), (others, OTHERS)):
        assert round(100 * round(rate / 100 * episodes) / episodes, 1) == rate


def test_fewer_of_a_hundred_episodes_reach_more_goals():
    for method, counts in MULTI:
        assert all(0 < more < fewer <= 100 for fewer, more in itertools.pairwise(counts)), method
