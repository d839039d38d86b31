"""Why a search does what it does, in words.

A reason is one clause or more, joined by `CLAUSE_JOINT`; the first one stands by itself. Other
languages have each clause in the table `doing` of their file, by the text that it has here.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from vizbot.core.observer import CLAUSE_JOINT
from vizbot.core.types import SE3
from vizbot.objectnav.option import Option

AROUND = "what is all around is seen first"
MAY_BE = "something {away} m away may be it ({chance})"
FROM_NEAR = "from near by it tells more"
SURE = "what is near by is likely enough ({chance})"
NOT_SURE = "what is near by may be it ({chance})"
AFFIRMED = "somebody has said that this is it"
COUNTS = "the view from here is to count, too"
ALL_TRIED = "nothing else is left to try"
MAY_BE_GONE = "what was bumped into may be gone"
NOTHING_COMES_OF_IT = "nothing has come of it for a while"
OTHERS_TRIED = "nothing else is left, so what was left alone is tried again"
LITTLE_LEFT = "little else is left to see"
MOST_ALIKE = "what was seen around there is most like it"
LARGEST = "more is unseen there than elsewhere"
NEAREST = "no other unseen place is reached sooner"
MOST_FOR_THE_WAY = "for its way, most may be seen there"
NOTHING_SEEN = "no place seen so far is worth a closer look"
LESS_WORTH = "that is worth more than the likeliest place left to look at ({chance})"
NONE_ABOVE = "nothing that can be reached is above theta, {theta}"
ABOVE = "the similarity {score} is above theta, {theta}"
NONE_LEFT = "nothing unseen can be reached"

_ALIKE = 0.5
"""Likeness from which the reason is what was seen beside a frontier [standard deviations]."""


def near_by(probability: float, *, sure: bool, standing: bool) -> str:
    """Why the robot approaches a place near by, or looks at it.

    The `probability` that it is the goal is enough to arrive where `sure`.
    """
    said = (SURE if sure else NOT_SURE).format(chance=f"{probability:.0%}")
    return f"{said}{CLAUSE_JOINT}{COUNTS}" if standing else said


def looking_closer(option: Option, T_map_base: SE3) -> str:
    """Why the robot goes to a place that may be the goal."""
    said = _of_place(MAY_BE, option.xy, option.probability, T_map_base)
    return f"{said}{CLAUSE_JOINT}{FROM_NEAR}"


def going_back(place_xy: NDArray[np.float64], probability: float, T_map_base: SE3) -> str:
    """Why the robot goes to (2,) a place that it has seen before, in `map` [m]."""
    return f"{ALL_TRIED}{CLAUSE_JOINT}{_of_place(MAY_BE, place_xy, probability, T_map_base)}"


def exploring(advantage: str, options: Sequence[Option]) -> str:
    """Why the robot goes to a frontier: its `advantage` (`advantage_of`) over other `options`."""
    chances = [option.probability for option in options if option.kind == "place"]
    less = LESS_WORTH.format(chance=f"{max(chances):.0%}") if chances else NOTHING_SEEN
    return f"{advantage}{CLAUSE_JOINT}{less}"


def advantage_of(chosen: Option, options: Sequence[Option]) -> str:
    """What a frontier has that the other ones among the options have not."""
    others = [each for each in options if each.kind == "frontier" and each is not chosen]
    if not others:
        return LITTLE_LEFT
    if chosen.likeness > max(_ALIKE, *(each.likeness for each in others)):
        return MOST_ALIKE
    if chosen.area > max(each.area for each in others):
        return LARGEST
    if chosen.way < min(each.way for each in others):
        return NEAREST
    return MOST_FOR_THE_WAY


def none_above(theta: float) -> str:
    """Why the paper's Algorithm 1 goes to the distant point."""
    return NONE_ABOVE.format(theta=f"{theta:.3f}")


def above(similarity: float, theta: float, *, lowered: bool) -> str:
    """Why the paper's Algorithm 1 goes to an element, by a theta that it may have lowered."""
    said = ABOVE.format(score=f"{similarity:.3f}", theta=f"{theta:.3f}")
    return f"{said}{CLAUSE_JOINT}{NONE_LEFT}" if lowered else said


def _of_place(
    clause: str, place_xy: NDArray[np.float64], probability: float, T_map_base: SE3
) -> str:
    away = float(np.linalg.norm(place_xy - T_map_base[:2, 3]))
    return clause.format(away=f"{away:.0f}", chance=f"{probability:.0%}")
