"""The robot's encoder with the cosines of others."""

from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.encoder.weak_encoder import WeakEncoder
from benchmarks.episodes.other_encoders import (
    ERROR,
    OFFSET,
    OWN_USUAL,
    THRESHOLD,
    USUAL,
    OtherEncoder,
)
from mapping.clip.fitted.encoder import weights_of
from mapping.clip.places.evidence import UNKNOWN_SCALE_FILE, fitted_weights
from mapping.clip.reading import Reading
from mapping.clip.scores import Background, Query

OWN_THRESHOLD = 0.48


def unit(rows):
    return (rows / np.linalg.norm(rows, axis=1, keepdims=True)).astype(np.float32)


RNG = np.random.default_rng(3)
PICTURES = [RNG.integers(0, 255, (8, 8, 3), np.uint8) for _ in range(60)]
TEXTS = [f"thing {i}" for i in range(50)]
ROWS = dict(
    zip((each.tobytes() for each in PICTURES), unit(RNG.normal(size=(60, 16))), strict=True)
)
WORDS = dict(zip(TEXTS, unit(RNG.normal(size=(50, 16))), strict=True))
OWN = SimpleNamespace(
    model_id="own", dimension=16, threshold=OWN_THRESHOLD, log_odds=(13.0, -5.3), notice="a notice",
    embed_images=lambda images: np.array([ROWS[image.tobytes()] for image in images]),
    embed_texts=lambda texts: np.array([WORDS[text] for text in texts]),
    reading=lambda text: Reading(text),
)  # fmt: skip
OWN_COSINES = np.array(list(ROWS.values())) @ np.array(list(WORDS.values())).T


def cosines(encoder):
    pictures, texts = encoder.embed_images(PICTURES), encoder.embed_texts(TEXTS)
    for rows in (pictures, texts):
        assert rows.shape[1] == encoder.dimension
        np.testing.assert_allclose(np.linalg.norm(rows, axis=1), 1.0, atol=1e-5)
    return pictures @ texts.T


def test_cosines_lie_where_those_of_clip_do_in_the_same_order():
    encoder = OtherEncoder(OWN, "clip")
    slope = (THRESHOLD - USUAL) / (OWN_THRESHOLD - OWN_USUAL)
    shift = USUAL - slope * OWN_USUAL
    assert slope * OWN_THRESHOLD + shift == pytest.approx(THRESHOLD) == encoder.threshold
    np.testing.assert_allclose(cosines(encoder), slope * OWN_COSINES + shift, atol=1e-5)


def test_log_odds_and_standard_scores_are_those_of_the_own_encoder():
    encoder, scores = OtherEncoder(OWN, "clip"), []
    for each in (OWN, encoder):
        pictures = each.embed_images(PICTURES)
        statistics = Background(each.embed_texts(TEXTS)).statistics(pictures)
        question = Query(each.embed_texts(["thing 7"])[0], each.log_odds)
        scores.append(question.scores(pictures, statistics))
    np.testing.assert_allclose(scores[0], scores[1], atol=1e-3)


def test_an_encoder_may_not_tell_its_scale():
    encoder = OtherEncoder(OWN, "unknown")
    assert encoder.log_odds is None and encoder.model_id == "own-unknown"
    np.testing.assert_array_equal(cosines(encoder), cosines(OtherEncoder(OWN, "clip")))


def test_texts_have_offsets_and_pairs_errors_which_are_the_same_every_time():
    beyond = cosines(OtherEncoder(OWN, "offset")) - cosines(OtherEncoder(OWN, "clip"))
    offsets = beyond.mean(axis=0)
    errors = beyond - offsets
    assert 0.7 * OFFSET < offsets.std() < 1.4 * OFFSET
    assert 0.8 * ERROR < errors.std() < 1.2 * ERROR
    again = OtherEncoder(OWN, "offset")
    np.testing.assert_array_equal(again.embed_texts(TEXTS[3:5]), again.embed_texts(TEXTS)[3:5])
    one = again.embed_images(PICTURES[9:10])
    np.testing.assert_allclose(one, again.embed_images(PICTURES)[9:10], atol=1e-6)
    assert again.embed_images([]).shape[0] == 0
    assert (again.model_id, again.notice) == ("own-offset", "a notice")
    assert again.reading("sofa").text == "sofa"


def test_it_is_believed_by_the_numbers_of_the_own_one_while_scale_and_bias_are_known():
    assert weights_of(OtherEncoder(OWN, "offset")) is weights_of(OWN)
    unknown = OtherEncoder(OWN, "unknown")
    assert weights_of(unknown) is fitted_weights(UNKNOWN_SCALE_FILE)


def test_a_weak_encoder_says_half_as_much_of_each_picture():
    encoder = WeakEncoder(OWN)
    assert encoder.model_id == "own-weak" and encoder.log_odds == OWN.log_odds
    weak = cosines(encoder)
    np.testing.assert_array_equal(weak, cosines(encoder))  # the same noise again
    slope = (weak * OWN_COSINES).sum() / (OWN_COSINES**2).sum()
    assert slope == pytest.approx(np.sqrt(0.5), abs=0.08)
    off = weak - slope * OWN_COSINES
    assert off.std() == pytest.approx(np.sqrt(0.5) / np.sqrt(16), rel=0.2)
    rows = np.array([*ROWS.values()])
    np.testing.assert_array_equal(
        encoder.embeddings_of_pictures(rows), encoder.embed_images(PICTURES)
    )
    assert encoder.embeddings_of_pictures(rows[:0]).shape == (0, 16)
