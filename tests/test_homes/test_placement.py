from collections import Counter

import numpy as np
import pytest

from sim_stubs.homes.floor_plan.stairs import Stairs
from sim_stubs.homes.floor_plan.walls import Opening, RectangularRoom
from sim_stubs.homes.furnishing.arrangement import around, on_top, tops
from sim_stubs.homes.furnishing.placement import DOOR_DEPTH, RoomLayout
from sim_stubs.homes.furniture import procedural
from sim_stubs.homes.geometry.bounding_block import Block, facing_of
from sim_stubs.homes.geometry.solids import triangles

GREY = (0.5, 0.5, 0.5)
DOORWAY = Opening(2.0, -0.1, 2.9, 0.0)
SECOND = Opening(-0.1, 2.0, 0.0, 2.9)
WINDOW = Opening(1.0, 4.0, 2.5, 4.2, 0.95, 2.1, GREY, "window")


def room(width=5.0, depth=4.0):
    return RectangularRoom("bedroom", 0, 0, width, depth, GREY, 1.0, GREY)


def layout(seed=0, openings=(DOORWAY, WINDOW), of=None, stairs=None):
    rng = np.random.default_rng(seed)
    return RoomLayout(of or room(), openings, stairs, rng, Counter())


def shape(label, seed=0):
    return procedural.piece(label, np.random.default_rng(seed))


@pytest.mark.parametrize("seed", range(8))
def test_furniture_at_walls_is_inside_apart_and_off_the_doorway(seed):
    plan = layout(seed)
    for label in ("wardrobe", "bed", "bookshelf", "sofa", "desk", "chest of drawers"):
        plan.against_wall(shape(label), front=0.4)
    blocks = [Block.around(it) for it in plan.instances]
    assert len(blocks) >= 3
    before_door = Block(2.0, 0.0, 2.9, DOOR_DEPTH)
    for i, block in enumerate(blocks):
        assert block.inside(Block(0, 0, 5, 4))
        assert not block.overlaps(before_door)
        assert not any(block.overlaps(other) for other in blocks[:i])
        to_walls = (block.x0, block.y0, 5 - block.x1, 4 - block.y1)
        assert min(to_walls) == pytest.approx(0.03)


def test_fronts_look_away_from_the_wall():
    for facing, x, y in (("N", None, 0.03), ("E", 0.03, None)):
        wardrobe = layout().against_wall(shape("wardrobe"), facings=facing)
        block = Block.around(wardrobe)
        assert facing_of(wardrobe) == facing
        assert x is None or block.x0 == pytest.approx(x)
        assert y is None or block.y0 == pytest.approx(y)


def test_tall_furniture_does_not_stand_before_a_window():
    for seed in range(10):
        wardrobe = layout(seed).against_wall(shape("wardrobe"), facings="S")
        block = Block.around(wardrobe)
        assert block.x0 > 2.4 or block.x1 < 1.1
    low = [layout(seed).against_wall(shape("nightstand"), facings="S").x for seed in range(30)]
    assert any(1.1 < x < 2.4 for x in low)


def test_nothing_bars_the_way_from_doorway_to_doorway():
    narrow = room(1.4, 4.0)
    doors = (Opening(0.2, -0.1, 1.1, 0.0), Opening(0.2, 4.0, 1.1, 4.1))
    plan = layout(of=narrow, openings=doors)
    assert plan.passable()
    assert plan.against_wall(shape("bed")) is None
    assert plan.against_wall(shape("picture"), elevation=1.2) is not None
    assert not plan.passable([Block(0.0, 1.5, 1.0, 2.0, 0.0, 0.5)])
    assert plan.passable([Block(0.0, 1.5, 0.5, 2.0, 0.0, 0.5)])


def test_a_row_stands_side_by_side_in_order():
    pieces = [shape(label) for label in ("refrigerator", "kitchen cabinet", "oven")]
    row = layout(openings=(DOORWAY,)).row(pieces, facings="S")
    ends = [(Block.around(it).x0, Block.around(it).x1) for it in row]
    assert [it.label for it in row] == ["refrigerator", "kitchen cabinet", "oven"]
    assert ends[0][1] == pytest.approx(ends[1][0])
    assert ends[1][1] == pytest.approx(ends[2][0])
    assert ends[0][0] < ends[2][0]


def test_chairs_look_at_their_table():
    plan = layout(openings=(DOORWAY,), of=room(6.0, 5.0))
    table = plan.in_the_open(shape("dining table"), 0.75)
    chairs = around(plan, table, shape("chair"), 4)
    assert len(chairs) >= 2
    for chair in chairs:
        ahead = np.array([np.sin(chair.yaw), -np.cos(chair.yaw)])
        to_table = np.array([table.x - chair.x, table.y - chair.y])
        assert ahead @ to_table > 0.3
        assert not Block.around(chair).overlaps(Block.around(table))


def test_what_stands_on_a_thing_rests_on_its_surface():
    plan = layout()
    table = plan.against_wall(shape("dining table"))
    lamp = on_top(plan, table, shape("table lamp"))
    assert lamp.on == table.name == "dining table#1"
    assert lamp.elevation == pytest.approx(table.piece.size[2], abs=1e-5)
    assert Block.around(lamp).inside(Block.around(table))


def test_nothing_is_put_where_the_surface_is_uneven_or_missing():
    plan = layout()
    chair = plan.against_wall(shape("chair"))
    assert on_top(plan, chair, shape("table lamp"), spot="middle") is None or all(
        it.elevation < 0.5 for it in plan.instances
    )
    table = shape("dining table")
    corners = triangles(table.parts)
    assert tops(corners, Block(-0.1, -0.1, 0.1, 0.1)) == pytest.approx(table.size[2])
    assert np.isneginf(tops(corners, Block(2.0, 2.0, 2.2, 2.2))).all()


def test_stairs_and_the_floor_before_them_stay_free():
    stairs = Stairs("down", "straight", 1.0, 3.0, "S", 1.0, 2.0)
    plan = layout(openings=(DOORWAY,), stairs=stairs)
    for label in ("bed", "wardrobe", "desk", "bookshelf", "sofa"):
        plan.against_wall(shape(label))
    for instance in plan.instances:
        assert not Block.around(instance).overlaps(Block(*stairs.bounds))
        assert not Block.around(instance).overlaps(Block(*stairs.approach))


def test_a_carpet_lies_on_free_floor_and_hinders_nobody():
    plan = layout(openings=(DOORWAY, SECOND))
    carpet = plan.on_floor(shape("carpet"))
    assert carpet is not None and plan.passable()
    assert plan.against_wall(shape("wardrobe")) is None or not any(
        Block.around(it).overlaps(Block.around(carpet)) for it in plan.instances[1:]
    )
