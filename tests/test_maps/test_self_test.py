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


FAULTS = {
    swapped(0, 1): "in another order",
    swapped(1, 2): "in another order",
    of_the_batch: "otherwise alone than among others",
    lambda things: directions([things[0]] * len(things)): "as the same",
    lambda things: directions(things) * np.nan: "no direction",
    lambda things: 2.0 * directions(things): "no direction",
}


def test_an_encoder_that_does_what_it_is_for_has_no_fault():
    encoder = SimpleNamespace(embed_texts=directions, embed_images=directions)
    assert fault_in_use(encoder) is None


@pytest.mark.parametrize("embed", FAULTS)
def test_texts_that_are_embedded_wrongly_are_a_fault(embed):
    encoder = SimpleNamespace(embed_texts=embed, embed_images=directions)
    fault = fault_in_use(encoder)
    assert "texts" in fault and FAULTS[embed] in fault


@pytest.mark.parametrize("embed", [each for each in FAULTS if FAULTS[each] != "in another order"])
def test_pictures_that_are_embedded_wrongly_are_a_fault(embed):
    encoder = SimpleNamespace(embed_texts=directions, embed_images=embed)
    fault = fault_in_use(encoder)
    assert "pictures" in fault and FAULTS[embed] in fault


def test_pictures_in_another_order_are_a_fault():
    encoder = SimpleNamespace(embed_texts=directions, embed_images=swapped(0, 1))
    assert "pictures" in fault_in_use(encoder)
