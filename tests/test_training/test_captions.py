import numpy as np
import pytest

from training.captions.captions import (
    Caption,
    draw_captions,
    draw_colours,
    draw_contrasts,
    draw_negatives,
    plain_noun,
    target,
)
from training.captions.facts import FACT_INDEX, FACTS, Fact, Facts
from training.captions.phrasing import NounPhrase, phrased, plural_noun
from training.captions.unrelated_words import CAPTION_WORDS

NAN = float("nan")


def shown(*patches):
    """Facts of patches given as dictionaries."""
    keys = sorted({key for patch in patches for key in patch})
    dense = np.array([[patch.get(key, 0.0) for key in keys] for patch in patches], np.float32)
    return Facts.from_dense(dense, np.array([FACT_INDEX[key] for key in keys], np.int64))


PATCHES = shown(
    {"sofa": 0.9, "red sofa": 0.9, "table": 0.4, "sofa next to table": 0.6, "living room": 1.0},
    {"sofa": 0.5, "red sofa": NAN, "chair": NAN},
    {"bed": 1.0, "grey bed": 1.0, "two bed": 0.8, "room": 1.0, "bedroom": 1.0},
    {},
)


def test_a_caption_is_as_true_as_the_least_shown_of_its_atoms():
    captions = [
        Caption("", ("sofa",)),
        Caption("", ("sofa", "table")),
        Caption("", ("sofa", "red sofa")),
        Caption("", ("red sofa", "bed")),
        Caption("", ("chair", "bed")),
        Caption("", ("room", "two bed")),
        Caption("", ()),
    ]
    truth = target(captions, PATCHES)
    expected = [
        [0.9, 0.4, 0.9, 0.0, 0.0, 0.0, 0.0],
        [0.5, 0.0, NAN, 0.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.8, 0.0],
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    ]
    np.testing.assert_allclose(truth, expected)
    assert truth.dtype == np.float32


def test_a_target_has_the_shape_of_patches_and_captions_even_if_there_are_none():
    assert target([], PATCHES).shape == (4, 0)
    assert target([Caption("", ())], PATCHES).shape == (4, 1)
    none = PATCHES.take(np.zeros(0, np.int64))
    assert target([Caption("", ("sofa",))], none).shape == (0, 1)


def test_captions_are_true_and_contrasts_mostly_not():
    rng = np.random.default_rng(0)
    for patch in range(2):
        captions = draw_captions(PATCHES, patch, rng, 300)
        assert len(captions) == 300
        assert (target(captions, PATCHES)[patch] > 0).all()
        contrasts = target(draw_contrasts(PATCHES, patch, rng, 300), PATCHES)[patch]
        assert np.mean(contrasts == 0) > 0.7


def test_most_captions_are_about_the_thing_that_is_shown_best():
    captions = draw_captions(PATCHES, 0, np.random.default_rng(1), 500)
    things = [caption.facts[0] for caption in captions]
    assert things.count("sofa") > 3 * things.count("table")
    assert {"sofa", "red sofa", "living room"} <= {*things}


def test_a_patch_that_shows_nothing_or_only_what_is_withheld_has_no_captions():
    rng = np.random.default_rng(0)
    assert draw_captions(PATCHES, 3, rng, 5) == []
    assert draw_contrasts(PATCHES, 3, rng, 5) == []
    assert draw_captions(shown({"purple bed": 1.0}), 0, rng, 5) == []


def test_the_same_seed_draws_the_same_texts():
    def drawn():
        rng = np.random.default_rng(7)
        texts = draw_captions(PATCHES, 0, rng, 50) + draw_contrasts(PATCHES, 2, rng, 50)
        return texts + draw_negatives(rng, 50)

    assert drawn() == drawn()


def test_a_thing_is_told_by_all_its_names_in_many_phrasings():
    captions = draw_captions(shown({"sofa": 1.0}), 0, np.random.default_rng(0), 3000)
    texts = {caption.text for caption in captions}
    assert {"sofa", "couch", "a settee", "a photo of a sofa", "find the couch"} <= texts
    assert len(texts) > 150


def test_negatives_are_about_nothing_that_is_shown():
    negatives = draw_negatives(np.random.default_rng(0), 5000)
    assert np.count_nonzero(target(negatives, PATCHES)) == 0
    words = {word for negative in negatives for word in negative.text.split()}
    assert len(words & {*CAPTION_WORDS}) >= 900


@pytest.mark.parametrize(
    ("fact", "words"),
    [
        (Fact("sofa"), "a sofa"),
        (Fact("armchair", colour="red"), "a red armchair"),
        (Fact("armchair"), "an armchair"),
        (Fact("stairs", material="wooden"), "wooden stairs"),
        (Fact("plant", relation="on", other="table"), "a plant on a table"),
        (Fact("lamp", relation="above", other="oven"), "a lamp above an oven"),
        (Fact("chest of drawers", colour="grey"), "a grey chest of drawers"),
        (Fact("shelf", count="two"), "two shelves"),
        (Fact("bench", count="several"), "several benches"),
    ],
)
def test_atoms_are_put_in_plain_words(fact, words):
    assert plain_noun(fact).with_article == words


def test_phrasings_take_a_noun_with_or_without_an_article():
    noun = NounPhrase.from_name("oven", "oven in white")
    assert phrased("find {a}", noun) == "find an oven in white"
    assert phrased("{bare} of {the}", noun) == "oven in white of the oven in white"
    assert phrased("{a}", NounPhrase.from_name("stairs", "stairs in red")) == "stairs in red"
    assert [plural_noun(name) for name in ("box", "book shelf", "chest of drawers", "stairs")] == [
        "boxes", "book shelves", "chests of drawers", "stairs"]  # fmt: skip


def test_atoms_keep_their_places_when_patches_are_taken_and_joined():
    twice = Facts.joined([PATCHES, PATCHES.take(np.array([2, 0]))])
    assert len(twice) == 6
    for patch, same in ((4, 2), (5, 0), (3, 3)):
        assert str(twice.take(np.array([patch]))) == str(PATCHES.take(np.array([same])))
    columns = np.array([FACT_INDEX["bed"], FACT_INDEX["sofa"]])
    np.testing.assert_allclose(
        twice.columns(columns), [[0, 0.9], [0, 0.5], [1, 0], [0, 0], [1, 0], [0, 0.9]], rtol=1e-6
    )


def test_every_atom_has_a_key_of_its_own():
    assert len(FACT_INDEX) == len(FACTS)
    assert FACTS[FACT_INDEX["plant on table"]] == Fact("plant", relation="on", other="table")


def test_a_thing_of_sure_colour_is_told_in_all_colours_but_withheld_ones():
    columns = np.array([FACT_INDEX[key] for key in ("sofa", "red sofa", "bed", "blue bed")])
    shown = np.array([[1.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, np.nan]], np.float32)
    facts = Facts.from_dense(shown, columns)
    texts = {caption.text for caption in draw_colours(facts, 0, np.random.default_rng(0))}
    assert {"red sofa", "green sofa"} <= texts
    assert not texts & {"purple sofa", "brown sofa"}
    assert draw_colours(facts, 1, np.random.default_rng(0)) == []
