"""Spoilt folders of CLIP weights: an encoder or one line, in bounded time and memory."""

import json

import numpy as np
import pytest

from mapping.clip.checkpoint.checkpoint import require_plausible
from mapping.clip.encoder import load_clip
from tests.fuzz.trial import outcomes_in_turn
from tests.helpers.memory import peak_kib
from tests.helpers.random_clip import save_tiny_clip
from vizbot.core.errors import VizbotError

pytestmark = pytest.mark.slow

VALUES = (-1, 0, 1, 7, 2**31, 10**9, 1e308, float("nan"), 3.5, None, True, "x", [], {}, [1] * 3)
SHORT, LONG = 60, 1000
"""Folders that are tried."""
MOST_MEMORY = 2_000_000
"""Growth of the process that is allowed [kB]."""


@pytest.fixture(scope="module")
def checkpoint(tmp_path_factory):
    folder = tmp_path_factory.mktemp("clip")
    save_tiny_clip(folder)
    return folder


def places(value, before=()):
    """Keys to every value in a JSON document that is no large list."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from places(inner, (*before, key))
    elif isinstance(value, list) and 0 < len(value) < 6:
        yield before
        for place, inner in enumerate(value):
            yield from places(inner, (*before, place))
    else:
        yield before


def spoil(folder, rng):
    """One value of a document, a cut, a missing file, or bits of a file's beginning."""
    path = folder / str(rng.choice(sorted(each.name for each in folder.iterdir())))
    data, kind = bytearray(path.read_bytes()), rng.integers(8)
    if path.suffix == ".json" and kind < 5:
        document = json.loads(data)
        found = [place for place in places(document) if place]
        *way, last = found[rng.integers(len(found))]
        inner = document
        for key in way:
            inner = inner[key]
        inner[last] = VALUES[rng.integers(len(VALUES))]
        path.write_text(json.dumps(document))
    elif kind == 5:
        path.write_bytes(data[: rng.integers(len(data))])
    elif kind == 6:
        path.unlink()
    else:
        for _ in range(rng.integers(1, 10)):
            data[rng.integers(min(len(data), 4000))] ^= 1 << rng.integers(8)
        path.write_bytes(data)


def outcome(folder):
    """Whether it embeds, or the line that refuses it."""
    try:
        encoder = load_clip(str(folder), "cpu")
        text = encoder.embed_texts(["sofa"])
        image = encoder.embed_images([np.zeros((60, 60, 3), np.uint8)])
    except VizbotError as error:
        return str(error)
    return bool(np.isfinite(text).all() and np.isfinite(image).all())


@pytest.mark.parametrize("count", [SHORT, pytest.param(LONG, marks=pytest.mark.long)])
def test_spoilt_weights_give_an_encoder_or_one_line(checkpoint, tmp_path, count):
    before = peak_kib()
    rngs = (np.random.default_rng((2, number)) for number in range(count))
    became = outcomes_in_turn(checkpoint, tmp_path, spoil, outcome, rngs)
    assert False not in became, "one embeds what is no number"
    assert peak_kib() - before < MOST_MEMORY


@pytest.mark.parametrize(
    "config",
    [
        {"vision_config": {"num_hidden_layers": 2**31}},
        {"text_config": {"vocab_size": 10**9}},
        {"text_config": {"hidden_size": True}},
        {"projection_dim": 0},
        {"vision_config": 3},
    ],
)
def test_sizes_that_no_clip_has_are_refused_before_anything_is_allocated(config):
    with pytest.raises(ValueError, match="validation error"):
        require_plausible(config)
    require_plausible({"vision_config": {"num_hidden_layers": 24, "image_size": 336}})
