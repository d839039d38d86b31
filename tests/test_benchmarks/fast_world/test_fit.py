"""The numbers of the belief: the file that is shipped, and what they are fitted with."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.episodes.run import encoder_of
from benchmarks.harness.bench_plan import UNATTENDED
from mapping.clip.fitted.encoder import weights_of
from mapping.clip.places.evidence import (
    EMBEDDED_FILE,
    NAMES,
    PRIOR,
    UNKNOWN_SCALE_FILE,
    WEIGHTS_FILE,
    Weights,
    fitted_weights,
    shipped_weights,
)
from mapping.clip.places.place_views import PlaceViews
from sim_stubs.homes.home import home
from sim_stubs.homes.start_pose import things_named
from vizbot.rehearsal.belief_fit import fit
from vizbot.rehearsal.belief_fit.fit import Omission, drawn_walk, fitted, logistic, walk
from vizbot.rehearsal.belief_fit.places import are_true, true_places
from vizbot.rehearsal.belief_fit.seen_home import SeenHome, ShownPlaces
from vizbot.rehearsal.belief_fit.view_list import OWN_HOMES
from vizbot.rehearsal.belief_fit.views import HEADINGS


@pytest.mark.parametrize("file", [WEIGHTS_FILE, UNKNOWN_SCALE_FILE, EMBEDDED_FILE])
def test_the_shipped_numbers_are_sixty_at_most_and_say_where_they_are_from(file):
    kept = json.loads(file.read_text())
    weights = fitted_weights(file)
    assert weights.near.shape == weights.far.shape == (20,) and weights.join.shape == (20,)
    assert weights.near.size + weights.far.size + weights.join.size <= 60
    assert kept["homes"] == list(OWN_HOMES) and min(OWN_HOMES) >= 916 and max(OWN_HOMES) <= 999
    encoders = ["embedded"] if file == EMBEDDED_FILE else ["embedded", "photos"]
    assert [each.split("-")[0] for each in kept["encoders"]] == encoders


def test_each_encoder_has_the_numbers_that_are_meant_for_it():
    own = encoder_of(UNATTENDED)
    assert weights_of(own) is fitted_weights(EMBEDDED_FILE)
    other = SimpleNamespace(model_id="clip-0123", log_odds=(1.0, 0.0))
    assert weights_of(other) is shipped_weights("clip-0123", scale_known=True)
    assert weights_of(other) is fitted_weights()
    other.log_odds = None
    assert weights_of(other) is fitted_weights(UNKNOWN_SCALE_FILE)


def test_nothing_seen_is_hardly_ever_believed():
    views = PlaceViews()
    views.add(
        np.array([[0, 0]]), np.float32([-2.5]), np.float32([0.0]), np.float32([1.0]),
        np.array([0]), np.zeros((1, 2), np.float32), np.zeros(1, np.float32),
    )  # fmt: skip
    odds = views.features(room=False)[0, 0] @ fitted_weights().join
    assert odds < -2.0


def test_a_regression_finds_what_made_the_outcomes():
    rng = np.random.default_rng(4)
    inputs = np.column_stack([rng.normal(size=(20_000, 2)), np.ones(20_000)])
    truth = np.array([1.5, -0.5, -1.0])
    outcomes = (rng.random(20_000) < 1 / (1 + np.exp(-inputs @ truth))).astype(float)
    assert logistic(inputs, outcomes, np.ones(20_000)) == pytest.approx(truth, abs=0.1)
    half = np.where(inputs[:, 0] > 0, 1.0, 1e-9)
    assert logistic(inputs, outcomes, half) == pytest.approx(truth, abs=0.2)


def test_a_regression_is_drawn_to_what_it_is_given_and_follows_what_it_sees():
    prior = np.array([2.0, 0.5, -1.0])
    nothing = np.zeros((50, 3)), np.full(50, 0.5), np.ones(50)
    assert logistic(*nothing, prior) == pytest.approx(prior)
    assert logistic(*nothing) == pytest.approx(np.zeros(3))
    rng = np.random.default_rng(4)
    inputs = np.column_stack([rng.normal(size=(20_000, 2)), np.ones(20_000)])
    outcomes = (rng.random(20_000) < 1 / (1 + np.exp(-inputs @ [-1.0, 0.5, -1.0]))).astype(float)
    drawn, free = (logistic(inputs, outcomes, np.ones(20_000), p) for p in (prior, None))
    assert free[0] < drawn[0] < 0.0


def in_order(home, rng):
    return range(len(home.stands))


def test_a_walk_looks_around_first_and_then_goes_to_what_is_near():
    xy = np.array([[x, 0.0] for x in range(10)])
    stations = walk(xy, np.random.default_rng(1))
    first = stations[0][0]
    assert stations[:HEADINGS] == [(first, heading) for heading in range(HEADINGS)]
    assert {stand for stand, _ in stations} == set(range(10))
    assert walk(xy, np.random.default_rng(1), 14)[:14] == stations[:14]
    assert 14 <= len(walk(xy, np.random.default_rng(1), 14)) < 14 + 4


def shown_in_a_row(there):
    """Views that show one place each, 1 m away, with or without a sofa."""
    rows = np.arange(len(there))
    places = np.stack([rows, 0 * rows], axis=1)
    true = {"sofa": (there[None], np.zeros(2, np.int64))}
    return ShownPlaces(
        np.zeros((0, 1), np.float32), np.stack([rows] * 3, axis=1), np.ones(len(rows), np.float32),
        np.ones(len(rows), np.float32), places, np.arange(len(rows) + 1), rows, 0.25 * places,
        0 * rows, true,
    )  # fmt: skip


def test_a_walk_takes_the_views_of_its_stations():
    home = replace(
        shown_in_a_row(np.zeros(3 * HEADINGS, bool)),
        stands=np.repeat([4, 7, 9], HEADINGS),
        headings=np.tile(np.arange(HEADINGS), 3),
    )
    views = drawn_walk(home, np.random.default_rng(2))
    assert len(set(home.stands[views])) == 3
    assert views[:HEADINGS] == [views[0] + i for i in range(HEADINGS)]


def test_places_are_looked_at_early_and_late_on_a_walk(monkeypatch):
    features = {"sofa": np.zeros((20, 20), np.float32)}
    likeness = {"sofa": np.zeros(20, np.float32)}
    home = SeenHome(shown_in_a_row(np.arange(20) == 3), features, {}, likeness)
    monkeypatch.setattr(fit, "_KEPT", 1.0)
    weights = Weights(*np.zeros((3, 20)))
    found = list(fit._joined(home, weights, np.random.default_rng(0), in_order))
    assert [len(outcomes) for _, outcomes, _ in found] == [5, 8, 14, 20] * 3
    for features, outcomes, counts in found:
        assert len(features) == len(outcomes) == len(counts)
        assert outcomes.sum() == 1.0 and (counts == 1.0).all()


def seen_at_random(views=400):
    """A home in which the first features of a view tell, and no view shows what another one did."""
    rng = np.random.default_rng(5)
    there = rng.random(views) < 0.3
    features = rng.normal(size=(views, len(NAMES))).astype(np.float32)
    features[:, :14] += 2.0 * there[:, None]
    ranges = rng.uniform(0.5, 5.0, views).astype(np.float32)
    shown = replace(shown_in_a_row(there), ranges=ranges)
    return SeenHome(shown, {"sofa": features}, {"sofa": there}, {"sofa": features[:, 0]})


def test_both_kinds_of_places_weigh_what_their_share_is():
    [(features, outcomes, weights, ranges)] = fit._views(seen_at_random(), np.random.default_rng(0))
    assert len(features) == len(ranges) == 400
    assert weights[outcomes == 1.0].sum() == pytest.approx(PRIOR)
    assert weights[outcomes == 0.0].sum() == pytest.approx(1.0 - PRIOR)


@pytest.mark.parametrize("without", [None, *Omission])
def test_what_is_left_out_weighs_nothing(without):
    found = fitted([seen_at_random()], without, in_order)
    z_scores = [*found.near[7:14], *found.far[7:14]]
    assert (np.abs(z_scores) > 1e-6).any() == (without is not Omission.Z_SCORE)
    assert (abs(found.near[18]) > 1e-6) == (without is not Omission.OFFSETS_OF_TEXTS)
    assert (abs(found.far[18]) > 1e-6) == (without is not Omission.OFFSETS_OF_TEXTS)
    others = np.delete(found.join, [0, 1, 6, 8, 14, 19])
    assert (np.abs(others) > 1e-6).any() == (without is not Omission.JOINED_VIEWS)
    assert abs(found.join[0]) > 1e-6 and abs(found.near[0]) > 1e-6


def test_all_numbers_are_drawn_to_those_that_come_along():
    free = fitted([seen_at_random()], walks=in_order)
    prior = Weights(*(each + 1.0 for each in (free.near, free.far, free.join)))
    drawn = fitted([seen_at_random()], walks=in_order, prior=prior)
    for name in ("near", "far"):
        of_free, of_prior, of_drawn = (getattr(each, name) for each in (free, prior, drawn))
        assert np.linalg.norm(of_drawn - of_prior) < np.linalg.norm(of_free - of_prior)
    assert not np.allclose(drawn.join, free.join, atol=0.01)


@pytest.fixture(scope="module")
def house():
    return home(1100)


def test_a_thing_is_where_it_stands(house):
    there, low = true_places(house, "sofa")
    sofas, _ = things_named(house, "sofa")
    on = np.floor(np.array([[it.x, it.y] for it in sofas]) / 0.25).astype(np.int64)
    assert are_true(on, there, low).all()
    assert 5 < there.sum() < 0.1 * there.size
    assert not are_true(np.array([[10_000, 0], [-10_000, 3]]), there, low).any()


def test_a_room_is_where_its_floor_is(house):
    there, low = true_places(house, "kitchen")
    [kitchen] = [room for room in house.rooms if room.name == "kitchen"]
    rows, columns = np.nonzero(there)
    for column, row in zip(columns[::7], rows[::7], strict=True):
        assert kitchen.contains(*((np.array([column, row]) + low + 0.5) * 0.25))


def test_what_the_house_has_not_is_nowhere(house):
    assert not true_places(house, "elephant")[0].any()
