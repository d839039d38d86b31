import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim_stubs.clip import ColourWords

YELLOW = (230, 190, 25)
PLAIN = {
    "oak": (180, 130, 80),
    "pine": (222, 184, 135),
    "walnut": (90, 60, 35),
    "beige": (230, 215, 180),
    "cream": (255, 245, 205),
    "white": (240, 240, 240),
    "a white wall in warm light": (250, 225, 170),
    "dusk": (25, 22, 20),
    "terracotta": (200, 110, 70),
}
CHAIRS = {
    "blue": (30, 60, 200),
    "red": (200, 30, 30),
    "green": (30, 160, 60),
    "orange": (240, 130, 20),
}


def seen(background, colour=None, part=0.0, size=112, exposure=1.0, noise=6.0, seed=0):
    """A patch with a square of `colour` that fills `part` of it, as a noisy camera sees it."""
    image = np.full((size, size, 3), background, float)
    edge = round(size * np.sqrt(part))
    if colour is not None:
        image[3 : 3 + edge, 5 : 5 + edge] = colour
    rng = np.random.default_rng(seed)
    return (image * exposure + rng.normal(0, noise, image.shape)).clip(0, 255).astype(np.uint8)


def score(image, text):
    encoder = ColourWords()
    return float(encoder.embed_images([image])[0] @ encoder.embed_texts([text])[0])


@settings(max_examples=150)
@given(
    background=st.sampled_from(sorted(PLAIN)),
    part=st.floats(0.045, 0.8),
    size=st.sampled_from([112, 224, 448]),
    exposure=st.floats(0.5, 1.3),
    seed=st.integers(0, 1000),
)
def test_a_patch_with_a_fair_part_of_yellow_is_clearly_found(
    background, part, size, exposure, seed
):
    image = seen(PLAIN[background], YELLOW, part, size, exposure, seed=seed)
    assert score(image, "yellow chair") > ColourWords.threshold + 0.05


@settings(max_examples=150)
@given(
    background=st.sampled_from(sorted(PLAIN)),
    chair=st.sampled_from([None, *sorted(CHAIRS)]),
    part=st.floats(0.02, 0.8),
    exposure=st.floats(0.4, 1.3),
    noise=st.floats(0.0, 15.0),
    seed=st.integers(0, 1000),
)
def test_floors_walls_and_other_chairs_are_not_yellow(
    background, chair, part, exposure, noise, seed
):
    colour = None if chair is None else CHAIRS[chair]
    image = seen(PLAIN[background], colour, part, 112, exposure, noise, seed)
    assert score(image, "yellow chair") < ColourWords.threshold / 2


def test_more_of_a_colour_scores_higher():
    scores = [score(seen(PLAIN["oak"], YELLOW, part), "yellow chair") for part in (0.04, 0.1, 0.5)]
    assert scores[0] < scores[1] < scores[2]


@pytest.mark.parametrize(
    ("text", "rgb"),
    [
        ("the red sofa", (200, 30, 30)),
        ("Orange lamp", (240, 130, 20)),
        ("yellow chair", YELLOW),
        ("GREEN plant", (30, 160, 60)),
        ("cyan vase", (20, 190, 200)),
        ("blue bed", (30, 60, 200)),
        ("purple cushion", (120, 30, 180)),
        ("violet cushion", (120, 30, 180)),
        ("pink towel", (230, 40, 150)),
        ("a brown table", (110, 60, 25)),
        ("white fridge", (245, 245, 245)),
        ("grey cat", (120, 120, 120)),
        ("gray cat", (120, 120, 120)),
        ("black television", (10, 10, 10)),
    ],
)
def test_every_colour_word_fits_its_colour_best(text, rgb):
    encoder = ColourWords()
    palette = [(200, 30, 30), (240, 130, 20), YELLOW, (30, 160, 60), (20, 190, 200), (30, 60, 200)]
    palette += [(120, 30, 180), (230, 40, 150), (110, 60, 25), (245, 245, 245), (120, 120, 120)]
    palette += [(10, 10, 10)]
    images = encoder.embed_images([seen(colour) for colour in palette])
    scores = images @ encoder.embed_texts([text])[0]
    assert palette[int(scores.argmax())] == rgb
    assert scores.max() > 0.9
    assert np.sort(scores)[-2] < encoder.threshold


@pytest.mark.parametrize("text", ["bookshelf", "", "a yellowish-looking thing? reddish"])
def test_a_text_without_a_colour_word_fits_nothing(text):
    for colour in (YELLOW, *PLAIN.values(), *CHAIRS.values()):
        assert abs(score(seen(colour), text)) < 1e-6


def test_a_word_that_only_contains_a_colour_is_not_that_colour():
    assert score(seen(CHAIRS["red"]), "bored cat in a greenhouse") == pytest.approx(0.0)


@given(size=st.integers(1, 40), seed=st.integers(0, 999))
def test_embeddings_are_unit_whatever_the_picture(size, seed):
    rng = np.random.default_rng(seed)
    image = rng.integers(0, 256, (size, size + 3, 3), np.uint8)
    encoder = ColourWords()
    embeddings = encoder.embed_images([image, image // 8])
    assert embeddings.dtype == np.float32
    np.testing.assert_allclose(np.linalg.norm(embeddings, axis=1), 1.0, atol=1e-5)
    assert encoder.embed_images([]).shape == encoder.embed_texts([]).shape == (0, 13)


def test_it_says_that_it_is_for_rehearsals():
    assert ColourWords.notice == "rehearsal model: not meant for real pictures"
