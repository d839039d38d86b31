"""What a step of training tells of its patches, and how true it is of each."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from sim_stubs.clip.training.captions.captions import (
    Caption,
    draw_captions,
    draw_colours,
    draw_contrasts,
    draw_negatives,
    target,
)
from sim_stubs.clip.training.captions.facts import ATOM_INDEX, ATOMS, Facts
from sim_stubs.clip.training.captions.held_out_pairs import withheld_atoms
from sim_stubs.homes.vocabulary import GROUPS, ROOMS, THINGS

NAMES = (*THINGS, *GROUPS, *ROOMS)
"""What goals are asked by most: bare names, told in every step."""


def draw_texts(atoms: Facts, rng: np.random.Generator) -> list[Caption]:
    """A caption for each patch, contrasts and all colours to some, bare names, and untruths."""
    count = len(atoms)
    captions = [caption for i in range(count) for caption in draw_captions(atoms, i, rng, 1)]
    for i in rng.choice(count, count // 2, replace=False):
        captions += draw_contrasts(atoms, int(i), rng, 1)
    for i in rng.choice(count, count // 8, replace=False):
        captions += draw_colours(atoms, int(i), rng)
    captions += draw_negatives(rng, count // 4)
    return captions + [Caption(name, (name,)) for name in NAMES]


def truth_of(
    captions: Sequence[Caption], atoms: Facts, changed: NDArray[np.bool_]
) -> NDArray[np.float32]:
    """`captions.target` (P, M), with what is told of colours open where they are `changed` (P,).

    Open is also what a patch that shows a withheld combination is told of that colour: "purple
    sofa" is in no caption, and were "purple chair" and all else that is purple wrong for a purple
    sofa, it would be learned that it is not purple.
    """
    truth = target(captions, atoms)
    told = [{ATOMS[ATOM_INDEX[key]].colour for key in it.atoms} - {""} for it in captions]
    truth[np.ix_(changed, np.array([bool(colours) for colours in told]))] = np.nan
    for colour, (of_it, bare) in withheld_atoms().items():
        strengths = atoms.columns(of_it)
        shown = (strengths > 0) | (np.isnan(strengths) & (atoms.columns(bare) > 0))
        of_colour = np.array([colour in colours for colours in told])
        rows = np.ix_(shown.any(axis=1), of_colour)
        truth[rows] = np.where(truth[rows] == 0, np.nan, truth[rows])
    return truth
