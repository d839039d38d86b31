"""Texts of a training step, and how true each is for each patch."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from training.captions.captions import (
    Caption,
    draw_captions,
    draw_colours,
    draw_contrasts,
    draw_negatives,
    target,
)
from training.captions.facts import FACT_INDEX, FACTS, Facts
from training.captions.held_out_pairs import withheld_columns
from vizbot.core.home_vocabulary import GROUPS, ROOMS, THINGS

NAMES = (*THINGS, *GROUPS, *ROOMS)
"""Bare names, by which most goals are given; they are in every step."""


def draw_texts(facts: Facts, rng: np.random.Generator) -> list[Caption]:
    """A caption for each patch, contrasts and all colours for some, bare names, and negatives."""
    count = len(facts)
    captions = [caption for i in range(count) for caption in draw_captions(facts, i, rng, 1)]
    for i in rng.choice(count, count // 2, replace=False):
        captions += draw_contrasts(facts, int(i), rng, 1)
    for i in rng.choice(count, count // 8, replace=False):
        captions += draw_colours(facts, int(i), rng)
    captions += draw_negatives(rng, count // 4)
    return captions + [Caption(name, (name,)) for name in NAMES]


def truth_of(
    captions: Sequence[Caption], facts: Facts, changed: NDArray[np.bool_]
) -> NDArray[np.float32]:
    """`captions.target` (P, M), NaN for captions with colours where patches are `changed` (P,).

    A caption with a colour is also NaN for a patch that shows a withheld thing of this colour.
    "purple sofa" is in no caption; if "purple chair" and all else that is purple were wrong for a
    purple sofa, the encoder would learn that it is not purple.
    """
    truth = target(captions, facts)
    colours_of = [{FACTS[FACT_INDEX[key]].colour for key in it.facts} - {""} for it in captions]
    truth[np.ix_(changed, np.array([bool(colours) for colours in colours_of]))] = np.nan
    for colour, (of_it, bare) in withheld_columns().items():
        strengths = facts.columns(of_it)
        shown = (strengths > 0) | (np.isnan(strengths) & (facts.columns(bare) > 0))
        of_colour = np.array([colour in colours for colours in colours_of])
        rows = np.ix_(shown.any(axis=1), of_colour)
        truth[rows] = np.where(truth[rows] == 0, np.nan, truth[rows])
    return truth
