"""Scores do not depend on an encoder's units, nor on what else a patch shows."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mapping.clip.background.phrases import PHRASES, other_rooms
from mapping.clip.background.pictures import EDGE, bank
from mapping.clip.scores import ABOVE_TO_LOG_ODDS, NO_PICTURES, USUAL_TAIL, Background, Query
from vizbot.rig import open_encoder


def unit(rows):
    return (rows / np.linalg.norm(rows, axis=-1, keepdims=True)).astype(np.float32)


@pytest.fixture(scope="module")
def space():
    """Elements, background phrases and a question in one space."""
    rng = np.random.default_rng(3)
    return (
        unit(rng.normal(size=(40, 64))),
        unit(rng.normal(size=(200, 64))),
        unit(rng.normal(size=64)),
    )


def test_the_list_of_phrases_is_long_and_has_none_twice():
    assert len(set(PHRASES)) == len(PHRASES) > 180


def test_a_score_is_the_log_odds_of_the_encoder_and_the_distance_from_the_background(space):
    elements, phrases, question = space
    statistics = Background(phrases).statistics(elements)
    odds, above = Query(question, (13.0, -5.0)).scores(elements, statistics).T
    cosines = elements @ question
    assert odds == pytest.approx(13.0 * cosines - 5.0, abs=1e-5)
    assert above == pytest.approx((cosines - statistics[:, 0]) / statistics[:, 1], abs=1e-4)


def test_without_known_log_odds_they_follow_from_the_distance(space):
    elements, phrases, question = space
    statistics = Background(phrases).statistics(elements)
    known = Query(question, (13.0, -5.0)).scores(elements, statistics)
    unknown = Query(question, None).scores(elements, statistics)
    slope, offset = ABOVE_TO_LOG_ODDS
    np.testing.assert_array_equal(unknown[:, 1], known[:, 1])
    np.testing.assert_allclose(unknown[:, 0], slope * known[:, 1] + offset, rtol=1e-5)


def test_the_upper_tail_is_what_one_in_a_hundred_pictures_exceeds():
    cosines = np.linspace(-1.0, 1.0, 1001, dtype=np.float32)
    pictures = np.column_stack([cosines, np.sqrt(1 - cosines**2)])
    question = Query(np.float32([1.0, 0.0]), (10.0, -5.0))
    assert question.tail(pictures) == pytest.approx(10.0 * 0.98 - 5.0, abs=1e-3)
    shifted = Query(np.float32([1.0, 0.0]), (10.0, -4.0))
    assert shifted.tail(pictures) == pytest.approx(question.tail(pictures) + 1.0)


def test_without_log_odds_or_pictures_the_usual_tail_stands_in(space):
    elements, _, question = space
    assert Query(question, None).tail(elements) == USUAL_TAIL
    assert Query(question, (13.0, -5.0)).tail(NO_PICTURES) == USUAL_TAIL


def test_the_bank_has_pictures_of_many_kinds():
    pictures = np.array(bank())
    assert pictures.shape == (256, EDGE, EDGE, 3) and pictures.dtype == np.uint8
    assert len({picture.tobytes() for picture in pictures}) > 250
    assert np.ptp(pictures.mean(axis=(1, 2, 3))) > 150


def test_the_background_has_no_pictures_by_who_embeds_texts_alone():
    class Texts:
        def embed_texts(self, texts):
            return np.ones((len(texts), 1), np.float32)

    class Both(Texts):
        def embed_images(self, images):
            return np.array([[image.mean()] for image in images], np.float32)

    assert len(Background.embedded_by(Texts()).pictures) == 0
    means = [[picture.mean()] for picture in bank()]
    np.testing.assert_allclose(Background.embedded_by(Both()).pictures, means, rtol=1e-5)


@given(a=st.floats(0.2, 0.9), b=st.floats(0.01, 0.3))
def test_scores_stay_where_all_similarities_are_scaled_and_shifted(a, b):
    rng = np.random.default_rng(5)
    elements, phrases = unit(rng.normal(size=(20, 32))), unit(rng.normal(size=(100, 32)))
    question = unit(rng.normal(size=(1, 32)))

    def scaled(rows):
        return np.column_stack([rows * np.sqrt(a), np.full(len(rows), np.sqrt(b))])

    before = Query(question[0], (13.0, -5.0)).scores(
        elements, Background(phrases).statistics(elements)
    )
    undone = (13.0 / a, -5.0 - 13.0 * b / a)
    shifted = scaled(elements)
    after = Query(scaled(question)[0], undone).scores(
        shifted, Background(scaled(phrases)).statistics(shifted)
    )
    assert after == pytest.approx(before, abs=2e-2)


def test_a_phrase_that_means_the_question_does_not_compete_with_it(space):
    elements, phrases, question = space
    same = unit(question + 0.05 * phrases[0])
    there = unit(question + 0.6 * elements)
    without = Background(phrases).statistics(there)
    beside = Background(np.vstack([phrases, same[None]])).statistics(there)
    asked = Query(question, None)
    assert asked.scores(there, beside)[:, 1] == pytest.approx(
        asked.scores(there, without)[:, 1], rel=0.02
    )


@pytest.mark.parametrize(("asked", "same"), [("sofa", "couch"), ("refrigerator", "fridge")])
def test_another_word_for_the_question_costs_it_nothing(asked, same):
    encoder = open_encoder("embedded", "cpu")
    pictures = encoder.embed_images(bank()[:64])
    phrases = encoder.embed_texts([each for each in PHRASES if each != same])
    question, other = encoder.embed_texts([asked, same])
    assert question @ other > 0.95
    likest = pictures[np.argsort(pictures @ question)[-8:]]
    query = Query(question, None)
    without = query.scores(likest, Background(phrases).statistics(likest))[:, 1]
    beside = query.scores(likest, Background(np.vstack([phrases, other])).statistics(likest))[:, 1]
    assert without.max() > 2.0
    assert beside == pytest.approx(without, rel=0.02)


@pytest.mark.slow
def test_a_table_before_a_window_lowers_it_hardly_more_than_its_cosine():
    """Pictures that are most like a window, whose lower half another one hides, like a table."""
    encoder = open_encoder("embedded", "cpu")
    pictures = np.array(bank())
    embeddings = encoder.embed_images(list(pictures))
    window, table = encoder.embed_texts(["window", "table"])
    likest = np.argsort(embeddings @ window)
    windows = likest[-8:]
    tables = [i for i in np.argsort(embeddings @ table) if i in likest[:-16]][-8:]
    hidden = np.repeat(pictures[windows], 8, axis=0)
    hidden[:, EDGE // 2 :] = np.tile(pictures[tables], (8, 1, 1, 1))[:, EDGE // 2 :]
    shared, alone = encoder.embed_images(list(hidden)), embeddings[windows]
    statistics = Background(encoder.embed_texts(PHRASES)).statistics
    asked = Query(window, None)

    def above(rows):
        return asked.scores(rows, statistics(rows))[:, 1]

    left = np.median(above(shared)) / np.median(above(alone))
    assert left > 0.8 * np.median(shared @ window) / np.median(alone @ window)
    assert np.mean(above(shared)[:, None] > above(embeddings[tables])) > 0.98


def test_rooms_have_rivals_and_things_have_none():
    rooms = other_rooms("The Dining Room")
    assert "bathroom" in rooms and not {"kitchen", "dining room"} & {*rooms}
    assert other_rooms("lounge") == other_rooms("living room")
    for thing in ("sofa", "kitchen table", "living room sofa", "", "toilet"):
        assert other_rooms(thing) == ()
