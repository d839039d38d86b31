"""Encoders of one's own, as `--clip MODULE:CLASS` names them."""

import sys
from pathlib import Path

import numpy as np
import pytest

from mapping import map_bundle
from mapping.clip.own_encoder import broken_promise, open_class
from mapping.clip.reading import Reading
from tests.helpers.bundles import Encoder, bundle_of
from vizbot.config import Config
from vizbot.core.errors import ConfigError, MapError
from vizbot.rig import open_encoder, open_map_encoder, open_text_encoder, require_encoder

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
COLOURS = "colour_encoder:ColourEncoder"


class Honest:
    model_id, dimension, threshold = "honest", 3, 0.2
    log_odds, notice = (10.0, -2.0), None

    def embed_texts(self, texts):
        return np.tile(np.array([[1, 0, 0]], np.float32), (len(texts), 1))

    def embed_images(self, images):
        return np.tile(np.array([[0, 1, 0]], np.float32), (len(images), 1))

    def reading(self, text):
        return Reading(text)


def changed(**members):
    return type("Changed", (Honest,), members)()


def by_count(self, inputs):
    rows = np.zeros((len(inputs), 3), np.float32)
    rows[:, min(len(inputs), 2)] = 1.0
    return rows


def means_of(self, images):
    rows = np.array([image.mean((0, 1)) for image in images], np.float32).reshape(-1, 3)
    return rows / np.linalg.norm(rows, axis=1, keepdims=True)


def reversed_rows(self, images):
    return means_of(self, images)[::-1]


def by_size(self, images):
    """Embeds pictures of one size together, and forgets to put them back into their order."""
    return means_of(self, sorted(images, key=np.size))


def broken(self, inputs):
    raise ValueError("no such\nkernel")


@pytest.fixture
def in_examples(monkeypatch):
    monkeypatch.chdir(EXAMPLES)
    yield
    sys.path[:] = [each for each in sys.path if each != str(EXAMPLES)]


def test_the_example_is_found_in_the_folder_where_it_lies_and_finds_colours(in_examples):
    require_encoder(COLOURS)
    encoder = open_encoder(COLOURS, "cpu")
    red = np.full((60, 60, 3), (205, 25, 35), np.uint8)
    blue = np.full((60, 60, 3), (40, 70, 190), np.uint8)
    found = encoder.embed_images([red, blue]) @ encoder.embed_texts(["something red"]).T
    assert found[0] > encoder.threshold > found[1]
    assert open_text_encoder(COLOURS, "cpu").model_id == COLOURS


def test_what_keeps_the_contract_is_taken():
    assert broken_promise(Honest()) is None
    assert broken_promise(changed(embed_images=means_of)) is None


@pytest.mark.parametrize(
    ("members", "words"),
    [
        ({"model_id": "two\nlines"}, "model_id"),
        ({"dimension": 0}, "dimension is 0"),
        ({"threshold": 27}, "threshold is 27"),
        ({"log_odds": (0.0, 1.0)}, "log_odds"),
        ({"log_odds": (float("nan"), 1.0)}, "log_odds"),
        ({"notice": 3}, "notice is 3"),
        ({"embed_texts": lambda self, texts: [[1, 0, 0]] * len(texts)}, "no array"),
        ({"embed_texts": lambda self, texts: np.eye(3)[: len(texts)]}, "float64"),
        ({"embed_texts": lambda self, texts: np.ones((3, 3), np.float32)}, "(0, 3)"),
        ({"embed_images": lambda self, images: np.ones((len(images), 3), np.float32)}, "not 1"),
        ({"embed_images": by_count}, "otherwise when it is alone"),
        ({"embed_images": reversed_rows}, "embed_images embeds the same thing otherwise"),
        ({"embed_images": by_size}, "embed_images embeds the same thing otherwise"),
        ({"embed_images": broken}, "embed_images: ValueError: no such kernel"),
        ({"embed_texts": broken}, "embed_texts: ValueError: no such kernel"),
        ({"reading": broken}, "reading: ValueError: no such kernel"),
        ({"log_odds": 3}, "its values: TypeError: "),
        ({"embed_images": None}, "embed_images: TypeError: 'NoneType' object is not callable"),
        ({"reading": lambda self, text: text}, "no Reading"),
    ],
)
def test_what_breaks_the_contract_is_told_by_name(members, words):
    fault = broken_promise(changed(**members))
    assert fault is not None
    assert words in fault
    assert len(fault.splitlines()) == 1


@pytest.mark.parametrize("name", ["os:abort", "sprung_trap:Trap", "sprung_trap.inner:Trap"])
def test_a_map_that_names_a_class_imports_and_calls_nothing(name, tmp_path, monkeypatch):
    (tmp_path / "sprung_trap").mkdir()
    for module in ("__init__", "inner"):
        (tmp_path / "sprung_trap" / f"{module}.py").write_text("Trap = dict")
    monkeypatch.syspath_prepend(tmp_path)
    bundle = bundle_of(model_id=name)
    for ask in (
        lambda: open_map_encoder(bundle, Config()),
        lambda: map_bundle.require_encoder(bundle, Encoder("embedded")),
    ):
        with pytest.raises(MapError) as refused:
            ask()
        assert str(refused.value) == (
            f"this map was made with an encoder of somebody's own, {name}; if you trust it, name"
            f" it: --clip {name}"
        )
    assert "sprung_trap" not in sys.modules
    with pytest.raises(ConfigError, match="''"):
        open_map_encoder(bundle, Config(), clip="")


def test_a_class_that_a_person_names_is_asked_about_its_map(in_examples):
    bundle = bundle_of(model_id=COLOURS)
    with pytest.raises(MapError, match="have 4 numbers"):  # it was opened, and knows 5 colours
        open_map_encoder(bundle, Config(), clip=COLOURS)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("nowhere_at_all:Encoder", "there is no module nowhere_at_all"),
        ("colour_encoder:Missing", "AttributeError"),
        ("json:JSONDecoder", "is no encoder"),
    ],
)
def test_a_class_that_cannot_be_used_is_one_line(name, words, in_examples):
    with pytest.raises(ConfigError) as refused:
        open_class(name)
    assert words in str(refused.value)
    assert name in str(refused.value)
    assert len(str(refused.value).splitlines()) == 1
