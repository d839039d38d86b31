"""What an encoder whose weights were loaded must do, or is refused."""

from types import SimpleNamespace

import numpy as np
import pytest

from mapping.clip.checkpoint.self_test import fault_in_use


def directions(things):
    """A direction for each thing (N, 8), which depends on nothing but it."""
    seeds = [int(np.frombuffer(np.asarray(each).tobytes(), np.uint8).sum()) for each in things]
    rows = np.array([np.random.default_rng(seed).normal(size=8) for seed in seeds], np.float32)
    return rows / np.linalg.norm(rows, axis=1, keepdims=True)


def swapped(first, second):
    def embed(things):
        rows = directions(things)
        if len(rows) > second:
            rows[[first, second]] = rows[[second, first]]
        return rows

    return embed


def of_the_batch(things):
    rows = directions(things) + (0.2 if len(things) > 1 else 0.0)
    return rows / np.linalg.norm(rows, axis=1, keepdims=True)


THIRD_SWAPPED = swapped(1, 2)
"""It shows in three texts and not in two pictures."""
FAULTS = {
    swapped(0, 1): "in another order",
    THIRD_SWAPPED: "in another order",
    of_the_batch: "otherwise alone than among others",
    lambda things: directions([things[0]] * len(things)): "as the same",
    lambda things: directions(things) * np.nan: "no direction",
    lambda things: 2.0 * directions(things): "no direction",
}


def test_an_encoder_that_does_what_it_is_for_has_no_fault():
    encoder = SimpleNamespace(embed_texts=directions, embed_images=directions)
    assert fault_in_use(encoder) is None


@pytest.mark.parametrize(
    ("things", "embed"),
    [
        *(("texts", embed) for embed in FAULTS),
        *(("pictures", embed) for embed in FAULTS if embed is not THIRD_SWAPPED),
    ],
)
def test_what_is_embedded_wrongly_is_a_fault(things, embed):
    by = {"embed_texts": directions, "embed_images": directions}
    by["embed_texts" if things == "texts" else "embed_images"] = embed
    fault = fault_in_use(SimpleNamespace(**by))
    assert things in fault and FAULTS[embed] in fault
