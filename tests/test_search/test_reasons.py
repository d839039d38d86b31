"""Why the robot does what it does, in words: what decides in that step, and nothing else."""

import numpy as np
import pytest

from vizbot.core.geometry import planar
from vizbot.objectnav import reasons
from vizbot.objectnav.option import Option


def frontier(area, likeness, way):
    return Option("frontier", np.zeros(2), 0.1, way, area=area, likeness=likeness)


def place(probability):
    return Option("place", np.array([3.0, 4.0]), probability, 4.0)


@pytest.mark.parametrize(
    ("chosen", "other", "why"),
    [
        (frontier(3.0, 1.2, 4.0), frontier(9.0, 0.3, 2.0), reasons.MOST_ALIKE),
        (frontier(9.0, 0.3, 4.0), frontier(3.0, 0.2, 2.0), reasons.LARGEST),
        (frontier(3.0, 0.3, 2.0), frontier(9.0, 0.2, 4.0), reasons.NEAREST),
        (frontier(30.0, 0.1, 2.0), frontier(30.0, 0.2, 4.0), reasons.NEAREST),
        (frontier(8.0, 0.1, 3.0), frontier(9.0, 0.2, 3.0), reasons.MOST_FOR_THE_WAY),
        (frontier(8.0, 2.0, 3.0), None, reasons.LITTLE_LEFT),
    ],
)
def test_a_frontier_is_gone_to_for_what_it_has_and_others_have_not(chosen, other, why):
    options = [place(0.3), chosen] if other is None else [place(0.3), other, chosen]
    assert reasons.advantage_of(chosen, options) == why


def test_exploring_says_what_is_left_for_later():
    options = [place(0.07), place(0.12), frontier(9.0, 0.0, 2.0)]
    later = reasons.exploring(reasons.LITTLE_LEFT, options)
    assert later == "little else is left to see; " + reasons.LESS_WORTH.format(chance="12%")
    nothing = reasons.exploring(reasons.LITTLE_LEFT, options[2:])
    assert nothing == f"little else is left to see; {reasons.NOTHING_SEEN}"


def test_a_place_is_told_with_its_probability_and_how_far_it_is():
    assert reasons.looking_closer(place(0.41), planar(0.0, 0.0, 0.0)) == (
        "something 5 m away may be it (41%); from near by it tells more"
    )
