"""The examination of the belief: what is missed at the first pass, and what the page says of it."""

import json
from dataclasses import asdict

import cv2
import numpy as np
import pytest

from benchmarks.fast_world import examination
from benchmarks.fast_world.curves import COLOURS
from benchmarks.fast_world.examination import (
    ASKED,
    HELD_OUT,
    WALKS,
    Passes,
    after_refutation,
    examined,
    missed_at,
    passes_in,
    platt,
)
from benchmarks.fast_world.fit import HOMES, SeenHome
from benchmarks.fast_world.page import FILE, PICTURE, belief_page, write_belief_picture
from benchmarks.fast_world.views import HEADINGS

VIEWS = 5
SOFA_AT, WRONG_AT = 2, 4
"""The view that shows the sofa, and the one that shows what only looks like it."""


def corridor(sofa=4.0, wrong=1.0):
    """A walk along a corridor; each view shows one place, a metre ahead, with these log odds."""
    features = np.zeros((VIEWS, 20), np.float32)
    features[:, :3] = -5.0
    features[SOFA_AT, :3], features[WRONG_AT, :3] = sofa, wrong
    features[:, 18] = 1.0
    xy = np.stack([3.0 * np.arange(VIEWS), np.zeros(VIEWS)], axis=1)
    places = np.floor((xy + np.array([1.0, 0.0])) / 0.25).astype(np.int64)
    there = np.zeros((1, 100), bool)
    there[0, places[SOFA_AT, 0]] = True
    return SeenHome(
        {"sofa": features}, {}, {"sofa": (there, np.zeros(2, np.int64))},
        {"sofa": np.zeros(VIEWS, np.float32)}, np.ones(VIEWS, np.float32), places,
        np.arange(VIEWS + 1), np.arange(VIEWS), xy, np.zeros(VIEWS, np.int64),
    )  # fmt: skip


@pytest.fixture(autouse=True)
def straight_on(monkeypatch):
    monkeypatch.setattr(examination, "walk_in", lambda home, rng: list(range(VIEWS)))


def test_homes_of_the_examination_are_fitted_on_by_nothing():
    assert not set(HELD_OUT) & set(HOMES) and min(HELD_OUT) >= 916 and max(HELD_OUT) <= 999


def test_a_pass_holds_the_greatest_value_of_the_thing_and_a_walk_that_of_what_is_wrong():
    _, cosine = passes_in([corridor()], [7])
    assert cosine.first == [(7, 4.0)] * WALKS
    assert cosine.wrong == [(7, value) for value in (1.0, -5.0, -5.0)] * WALKS
    believed, _ = passes_in([corridor()], [7])
    weak, _ = passes_in([corridor(sofa=-4.0)], [7])
    assert 0.0 < weak.first[0][1] < believed.first[0][1] < 1.0


def test_what_is_passed_again_does_not_count(monkeypatch):
    home = corridor()
    later = corridor(sofa=9.0)
    both = SeenHome(
        {"sofa": np.concatenate([home.features["sofa"], later.features["sofa"]])}, {}, home.true,
        {"sofa": np.zeros(2 * VIEWS, np.float32)}, np.ones(2 * VIEWS, np.float32),
        np.concatenate([home.places] * 2), np.arange(2 * VIEWS + 1), np.arange(2 * VIEWS),
        np.concatenate([home.xy] * 2), np.zeros(2 * VIEWS, np.int64),
    )  # fmt: skip
    for between, greatest in ((3, 9.0), (HEADINGS, 4.0)):
        walk = [*range(VIEWS), *between * [0], *range(VIEWS, 2 * VIEWS)]
        monkeypatch.setattr(examination, "walk_in", lambda home, rng, walk=walk: walk)
        _, cosine = passes_in([both], [7])
        assert cosine.first == [(7, greatest)] * WALKS


def test_goals_that_do_not_count_leave_the_walks_of_others_as_they_are():
    all_goals, _ = passes_in([corridor()], [7])
    sofas, _ = passes_in([corridor()], [7], lambda goal: goal == "sofa")
    others, _ = passes_in([corridor()], [7], lambda goal: goal != "sofa")
    assert sofas.first == all_goals.first and others.first == []


def test_the_next_place_is_told_where_the_likeliest_is_wrong():
    right, _ = passes_in([corridor()], [7])
    assert [each for _, _, each in right.refuted] == [False] * WALKS, "before it was seen"
    wrong, _ = passes_in([corridor(sofa=0.0)], [7])
    seeds, values, nexts = zip(*wrong.refuted, strict=True)
    assert set(seeds) == {7} and any(nexts)
    told = after_refutation(wrong)
    assert told["count"] == len(values) and told["believed"] == pytest.approx(np.mean(values))
    assert told["right"] == pytest.approx(np.mean(nexts))


@pytest.mark.parametrize(("share", "missed"), [(0.0, 0.75), (0.25, 0.5), (0.5, 0.25), (1.0, 0.0)])
def test_the_level_lets_so_many_walks_end_wrongly(share, missed):
    wrong, first = [0.1, 0.3, 0.5, 0.7], [0.2, 0.4, 0.6, 0.8]
    passes = Passes([(1, each) for each in wrong], list(zip((1, 1, 2, 2), first, strict=True)))
    found = missed_at(passes, share)
    assert found.missed == pytest.approx(missed) and found.over_homes is not None


def test_bins_and_loss_are_those_of_the_places():
    values, there = np.array([0.05, 0.05, 0.95, 1.0]), np.array([False, True, True, True])
    found = examined(Passes([(1, 0.2)], [(1, 0.9)], [values], [there]))
    assert [(each.count, each.share) for each in found.bins] == [(2, 0.5), (2, 1.0)]
    loss = -np.log([0.95, 0.05, 0.95, 1.0]).mean()
    assert found.log_loss == pytest.approx(loss, abs=1e-6)
    assert found.calibration_error == pytest.approx((0.9 + 0.05) / 4)


def test_platt_gives_probabilities_that_hold_where_they_were_fitted():
    rng = np.random.default_rng(3)
    values = rng.normal(size=50_000)
    there = rng.random(50_000) < 1 / (1 + np.exp(-(2.0 * values - 1.0)))
    fitted, other = Passes(values=[values], there=[there]), Passes(values=[values], there=[there])
    platt(fitted, other)
    assert other.values[0] == pytest.approx(1 / (1 + np.exp(-(2.0 * values - 1.0))), abs=0.02)


def test_the_page_tells_both_and_its_picture_is_drawn(tmp_path):
    assert belief_page(tmp_path, tmp_path / "belief.md") == ""
    write_belief_picture(tmp_path, tmp_path / "belief.md")
    assert not (tmp_path / PICTURE).exists()
    believed, cosine = passes_in([corridor()], [7])
    platt(cosine, cosine)
    kept = {
        "commit": "c0ffee", "encoder": "embedded", "homes": [7], "passes": WALKS, "wrong_places": 9,
        "belief": asdict(examined(believed)), "cosine": asdict(examined(cosine)),
        "things": asdict(missed_at(believed, ASKED)), "rooms": asdict(missed_at(believed, ASKED)),
        "after_refutation": {
            "count": 8, "believed": 0.4, "right": 0.5, "over_homes": (0.3, 0.6),
        },
    }  # fmt: skip
    (tmp_path / FILE).write_text(json.dumps(kept))
    text = belief_page(tmp_path, tmp_path / "belief.md")
    assert "c0ffee" in text and f"{kept['belief']['log_loss']:.4f}" in text
    write_belief_picture(tmp_path, tmp_path / "belief.md")
    drawn = cv2.imread(str(tmp_path / PICTURE))
    for colour in COLOURS.values():
        assert (np.abs(drawn.astype(int) - colour).max(axis=2) < 3).sum() > 100
