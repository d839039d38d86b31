"""Texts embedded with and without PyTorch: the same answers, to the last digits."""

import dataclasses

import numpy as np
import pytest

from mapping.clip.embedded.encoder import load_embedded_clip
from mapping.clip.embedded.model_files import read_files
from mapping.clip.embedded.text_encoder import EmbeddedTexts, token_ids
from mapping.clip.embedded.word_table import table
from vizbot.core.errors import ConfigError
from vizbot.core.home_vocabulary import COLOURS, EVALUATION_CLASSES

ODD = ["?", "\u2603", "sofa " * 100, "a bed next to a red sofa", "Where is the KITCHEN?"]


@pytest.fixture(scope="module")
def encoders():
    return load_embedded_clip(), EmbeddedTexts(read_files())


@pytest.fixture(scope="module")
def texts():
    coloured = [f"{colour} {name}" for colour in COLOURS for name in EVALUATION_CLASSES]
    return [*EVALUATION_CLASSES, *sorted(table()), *coloured, *ODD]


@pytest.mark.slow
def test_every_word_has_the_same_embedding_as_by_pytorch(encoders, texts):
    by_torch, by_numpy = (encoder.embed_texts(texts) for encoder in encoders)
    assert by_numpy.dtype == np.float32 and by_numpy.shape == by_torch.shape
    assert np.allclose(np.linalg.norm(by_numpy, axis=1), 1.0, atol=1e-6)
    assert np.abs(by_numpy - by_torch).max() < 1e-6


@pytest.mark.slow
def test_cosines_with_images_differ_by_less_than_1e_6_and_decide_the_same(encoders, texts):
    # What a map holds scatters around the texts: their cosines lie on both sides of the threshold.
    rng = np.random.default_rng(0)
    by_torch, by_numpy = (encoder.embed_texts(texts) for encoder in encoders)
    seen = by_torch[::5] + rng.normal(0.0, 0.06, by_torch[::5].shape).astype(np.float32)
    seen /= np.linalg.norm(seen, axis=1, keepdims=True)
    one, other = seen @ by_torch.T, seen @ by_numpy.T
    assert np.abs(one - other).max() < 1e-6
    threshold = encoders[0].threshold
    assert 0.01 < np.mean(one > threshold) < 0.99
    decided = np.abs(one - threshold) > 1e-6
    assert np.array_equal((one > threshold)[decided], (other > threshold)[decided])
    assert decided.mean() > 0.999


def test_a_text_is_embedded_the_same_alone_and_among_longer_ones(encoders):
    encoder = encoders[1]
    alone = encoder.embed_texts(["a bed"])
    among = encoder.embed_texts(["a bed", ODD[2]])[:1]
    assert np.abs(alone - among).max() < 1e-6


def test_both_encoders_of_the_model_say_the_same_of_it(encoders):
    by_torch, by_numpy = encoders
    for name in ("model_id", "dimension", "threshold", "log_odds", "notice"):
        assert getattr(by_numpy, name) == getattr(by_torch, name)
    for text in ("loveseat", "the walrus in the kitchen", "yellow chair"):
        assert by_numpy.reading(text) == by_torch.reading(text)


def test_no_texts_have_no_embeddings(encoders):
    assert all(encoder.embed_texts([]).shape == (0, 256) for encoder in encoders)


def test_a_text_beyond_24_tokens_is_cut_off():
    ids = token_ids(read_files().tokenizer, ["sofa", ODD[2]])
    assert ids.shape == (2, 24) and np.count_nonzero(ids[0]) < 24


def test_weights_that_are_torn_are_refused_in_one_line():
    files = read_files()
    with pytest.raises(ConfigError, match="damaged: install vizbot again"):
        EmbeddedTexts(dataclasses.replace(files, weights=files.weights[:5000]))
