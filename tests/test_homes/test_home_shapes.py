from collections import Counter

import numpy as np
import pytest

from sim_stubs.homes.floor_plan.stairs import Stairs
from sim_stubs.homes.furniture.appearance import appearance
from sim_stubs.homes.furniture.catalogue import read_catalogue
from sim_stubs.homes.furniture.procedural import IN_TURN, HomeShapes, in_turn
from sim_stubs.homes.furniture.source import furniture_source
from sim_stubs.homes.geometry.solids import triangles
from sim_stubs.homes.home import home
from vizbot.core.errors import ConfigError

RNG = np.random.default_rng(0)
PLACE = Stairs("up", "straight", 2.5, 3.0, "S", 0.95, 3.0)


def models(label, rng):
    raise AssertionError("not asked")


def shapes(label, rng):
    raise AssertionError("not asked")


def meshes(*of_shapes):
    return {triangles(piece.parts).tobytes() for piece in of_shapes}


def test_what_counts_as_a_goal_of_the_paper_takes_turns():
    assert {"bed", "single bed", "armchair", "dryer", "stairs", "window"} <= IN_TURN
    assert not {"desk", "door", "piano", "bookshelf"} & IN_TURN


@pytest.mark.parametrize("label", sorted(IN_TURN))
def test_models_and_shapes_alternate_in_a_home_and_the_next_home_begins_with_the_other(label):
    begun = []
    for seed in (1100, 1101):
        source_of = in_turn(seed, models, shapes)
        drawn = [source_of(label) for _ in range(4)]
        assert drawn[0] is not drawn[1]
        assert drawn[:2] == drawn[2:]
        begun.append(drawn[0])
    assert set(begun) == {models, shapes}


def test_classes_begin_with_a_model_or_a_shape_apart_from_each_other():
    begun = {
        tuple(in_turn(seed, models, shapes)(label) is shapes for label in sorted(IN_TURN))
        for seed in range(1100, 1120)
    }
    assert len(begun) == 20
    assert all(0 < sum(home) < len(IN_TURN) for home in begun)


def test_what_is_no_goal_comes_from_one_source():
    source_of = in_turn(1100, models, shapes)
    assert {source_of("desk") for _ in range(4)} == {models}


def test_a_shape_is_named_and_drawn_by_home_draw_class_and_number():
    one, again = HomeShapes(1100, 0), HomeShapes(1100, 0)
    first, second = one.piece("bed", RNG), one.piece("bed", RNG)
    assert (first.shape, second.shape) == (
        "bed 1100-0-0 of development",
        "bed 1100-0-1 of development",
    )
    again.piece("sofa", RNG)  # another class does not count
    assert meshes(first) == meshes(again.piece("bed", RNG))
    others = [HomeShapes(1101, 0).piece("bed", RNG), HomeShapes(1100, 1).piece("bed", RNG)]
    assert len(meshes(first, second, *others)) == 4


def test_homes_for_development_and_boards_draw_from_different_ranges(monkeypatch):
    of_development = HomeShapes(1100, 0).piece("bed", RNG)
    monkeypatch.setattr("sim_stubs.homes.furniture.procedural.DEVELOPMENT", range(0))
    of_boards = HomeShapes(1100, 0).piece("bed", RNG)
    assert of_boards.shape.endswith(" of boards")
    assert not meshes(of_development) & meshes(of_boards)


def test_a_seed_of_a_shape_is_no_plain_number(monkeypatch):
    """Shapes for training have plain numbers for seeds, under 2 ** 41."""
    made = []
    sequence = np.random.SeedSequence
    monkeypatch.setattr(
        np.random,
        "SeedSequence",
        lambda *args, **kw: made.append(sequence(*args, **kw)) or made[-1],
    )
    HomeShapes(1100, 0).piece("bed", RNG)
    (own,) = made
    assert own.spawn_key and own.entropy == 1100
    assert not np.array_equal(own.generate_state(4), sequence(1100).generate_state(4))


def test_stairs_are_built_in_their_place_alone():
    own = HomeShapes(1100, 0)
    with pytest.raises(ConfigError, match="stairs"):
        own.piece("stairs", RNG)
    stairs = own.staircase(PLACE, 2.5)
    assert (stairs.x, stairs.y) == (2.5, 3.0)
    assert stairs.piece.shape == "stairs 1100-0-0 of development"
    assert meshes(stairs.piece) != meshes(own.staircase(PLACE, 2.5).piece)


def test_no_chair_of_our_own_is_yellow_either():
    source = furniture_source((), held_out=True, shapes=HomeShapes(1100, 0).piece)
    chairs = [source("chair", RNG) for _ in range(40)]
    assert len({chair.shape for chair in chairs}) == 40
    assert "yellow" not in {colour for chair in chairs for colour in appearance(chair).colours}


@pytest.mark.slow
@pytest.mark.skipif(not read_catalogue(), reason="Debian's sweethome3d-furniture is not installed")
def test_homes_from_1020_on_have_models_and_shapes_of_goals():
    sides = Counter()
    for seed in (1100, 1101):
        for it in home(seed).instances:
            assert bool(it.piece.attribution) != bool(it.piece.shape), it.name
            if it.piece.shape:
                assert f" {seed}-" in it.piece.shape
            if it.label in ("toilet", "tv"):
                sides[it.label, bool(it.piece.shape)] += 1
    assert all(sides[label, own] for label in ("toilet", "tv") for own in (0, 1))
