"""Training homes by others and mixtures: what is replaced, what is painted, what a stage sees."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from sim_stubs.homes.floor_plan.walls import RectangularRoom, build_structure
from sim_stubs.homes.furniture.appearance import appearance
from sim_stubs.homes.geometry.house import House, Instance
from sim_stubs.homes.geometry.solids import Piece, box
from training import views
from training.homes import Mixture, TrainingHome, models_in, painted, refurnished
from training.views import NEAR, ViewsConfig, pictures
from training.wide_stage import WideStageConfig, homes_of
from vizbot.core.errors import ConfigError

GREY = (0.5, 0.5, 0.5)
SIZES = {"sofa": (2.0, 0.9, 0.8), "bed": (1.6, 2.0, 0.6), "window": (1.2, 0.1, 1.3),
         "yellow chair": (0.5, 0.5, 0.9), "tv": (1.0, 0.1, 0.6)}  # fmt: skip


def piece(label, size, attribution="ours"):
    return Piece(label, label, np.array(size), (box((0, 0, 0), size, GREY),), attribution)


@pytest.fixture(scope="module")
def house():
    room = RectangularRoom("living room", 0, 0, 6, 5, GREY, 1.0, GREY)
    instances = tuple(
        Instance(f"{label}#1", piece(label, size), 1.0 + number, 2.5, 0.3 * number)
        for number, (label, size) in enumerate(SIZES.items())
    )
    structure = build_structure((room,), ())
    lights = np.array([[3.0, 2.5, 2.3]])
    return House((room.room,), structure, instances, lights, (0.5, 0.5, 0.0))


def theirs(label, _):
    """A model of others that is a little larger than ours."""
    return piece(label, np.array(SIZES[label]) * 1.3, "theirs")


def always(value):
    """A generator whose draws are all this value."""
    return SimpleNamespace(
        random=lambda: value, integers=lambda n: 0, uniform=lambda *_: 0.5,
        beta=lambda *_: 0.5, exponential=lambda _: 0.0,
    )  # fmt: skip


def makers(house):
    return {it.label: it.piece.attribution for it in house.instances}


def test_another_model_fills_the_place_of_the_first(house):
    other = refurnished(house, theirs, always(0.0))
    assert makers(other) == {"sofa": "theirs", "bed": "theirs", "tv": "theirs",
                             "window": "ours", "yellow chair": "ours"}  # fmt: skip
    for before, after in zip(house.instances, other.instances, strict=True):
        np.testing.assert_allclose(after.piece.size, before.piece.size)
        np.testing.assert_allclose(after.footprint, before.footprint)
        assert (after.name, after.elevation) == (before.name, before.elevation)


@pytest.mark.parametrize(
    "furnisher",
    [lambda *_: None, lambda label, _: piece(label, np.array(SIZES[label]) * (1.0, 1.0, 1.8))],
    ids=["no model", "too much stretched"],
)
def test_a_piece_stays_where_no_other_fits(house, furnisher):
    assert {*makers(refurnished(house, furnisher, always(0.0))).values()} == {"ours"}


def test_some_pieces_stay_and_the_draws_decide_alone(house):
    both = [makers(refurnished(house, theirs, np.random.default_rng(3))) for _ in range(2)]
    assert both[0] == both[1]
    drawn = [makers(refurnished(house, theirs, np.random.default_rng(i))) for i in range(40)]
    assert 0.7 < np.mean([each["sofa"] == "theirs" for each in drawn]) < 0.98


def test_paint_is_on_whole_walls_and_on_furniture_that_may_have_any_colour(house):
    other = painted(house, always(0.0))
    high = [np.ptp(part.vertices[:, 2]) > 2.2 for part in house.structure]
    assert any(high) and not all(high)
    for before, after, is_wall in zip(house.structure, other.structure, high, strict=True):
        assert np.array_equal(after.rgba, before.rgba) != is_wall
    colours = {it.label: appearance(it.piece).colours for it in other.instances}
    assert colours["tv"] == colours["window"] == appearance(house.instances[0].piece).colours
    assert colours["sofa"] != colours["tv"] == colours["yellow chair"]


def test_many_homes_are_not_painted(house):
    unchanged = [painted(house, np.random.default_rng(i)) is house for i in range(100)]
    assert 40 < sum(unchanged) < 80


def test_models_are_different_pieces_by_their_class(house):
    twice = replace(house, instances=(*house.instances, *house.instances[:2]))
    assert {label: len(models) for label, models in models_in([twice, house]).items()} == (
        dict.fromkeys(SIZES, 1)
    )
    larger = replace(house.instances[0], piece=piece("sofa", (2.4, 1.0, 0.8)))
    assert len(models_in([house, replace(house, instances=(larger,))])["sofa"]) == 2


def test_homes_by_others_are_asked_for_in_one_line():
    with pytest.raises(ConfigError, match=r"their-rooms-0003 needs sweethome3d\.jar; give it by"):
        TrainingHome(Mixture.THEIR_ROOMS, 3).house()


def test_stages_share_no_home_and_none_is_to_judge_by():
    config = WideStageConfig()
    first, second = ({h.name for h in homes_of(config, n, Path("jar"))} for n in (0, 1))
    assert len(first) == len(second) == 160 and not first & second
    with_makers = homes_of(config, 1, Path("jar"), Path("models"))
    assert {home.name for home in with_makers} > second and len(with_makers) == 200
    assert all(home.seed < 400 for n in range(9) for home in homes_of(config, n, Path("jar")))


@pytest.fixture
def poses(monkeypatch):
    """Poses of the camera from which pictures are taken; these show nothing."""
    taken = []

    class Eye:
        def __init__(self, *_):
            pass

        def render(self, T_world_cam):
            taken.append(T_world_cam)
            return np.zeros((480, 640, 3), np.uint8), np.zeros((480, 640), np.float32)

        def segment(self, _):
            return np.full((480, 640), -1, np.int32)

        def close(self):
            pass

    monkeypatch.setattr(views, "Renderer", Eye)
    return taken


def test_near_views_are_taken_from_beside_a_thing(house, poses, monkeypatch):
    monkeypatch.setattr(views, "AIMED", 1.0)
    things = np.array([(it.x, it.y) for it in house.instances])
    shares = []
    for near in (0.0, 1.0):
        poses.clear()
        assert len([*pictures(house, 0, ViewsConfig(pictures=30, near=near))]) == 30
        away = [np.linalg.norm(things - T[:2, 3], axis=1).min() for T in poses]
        shares.append(np.mean(np.array(away) < NEAR + 0.2))
    assert shares[1] == 1.0 > shares[0] + 0.1


def test_where_a_thing_stands_on_the_start_pictures_are_taken_beside_it(house, poses):
    on_a_sofa = replace(house, start=(1.0, 2.5, 0.0))
    assert len([*pictures(on_a_sofa, 0, ViewsConfig(pictures=5))]) == len(poses) == 5
