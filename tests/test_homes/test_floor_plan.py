from collections import Counter
from itertools import combinations

import numpy as np
import pytest

from sim_stubs.homes.floor_plan.floor_plan import all_reached, away_from, floor_plan, free_spots
from sim_stubs.homes.floor_plan.room_layout import AREAS, NARROWEST, WALL, Rectangle, room_layout
from sim_stubs.homes.floor_plan.room_openings import Stretch, doorway, wide_passage
from sim_stubs.homes.floor_plan.walls import build_structure
from sim_stubs.homes.geometry.occupancy_slice import clearance, grid_around, occupied, reachable
from sim_stubs.homes.geometry.solids import triangles
from sim_stubs.homes.textures import surfaces
from sim_stubs.homes.textures.surfaces import SurfaceFinish

SEEDS = range(40)


@pytest.fixture(scope="module")
def plans():
    with pytest.MonkeyPatch.context() as patch:  # nothing here looks at the pictures
        patch.setattr(
            surfaces, "_finish", lambda family, member: SurfaceFinish((0.5, 0.5, 0.5), 1.0)
        )
        return [floor_plan(np.random.default_rng(seed), held_out=seed % 2 == 1) for seed in SEEDS]


def rectangles(plan):
    return [Rectangle(r.name, r.x0, r.y0, r.x1, r.y1) for r in plan.rooms]


def of_kind(plan, kind):
    return [hole for hole in plan.openings if hole.kind == kind]


def rooms_beside(plan, opening):
    hole = Rectangle("", opening.x0, opening.y0, opening.x1, opening.y1)
    return [room for room in rectangles(plan) if max(hole.gap(room)) < 0.01]


@pytest.mark.slow
def test_a_home_has_five_to_nine_rooms_and_those_that_every_home_has(plans):
    counts = set()
    for plan in plans:
        names = Counter(room.name for room in plan.rooms)
        assert all(names[name] == 1 for name in ("living room", "kitchen", "bathroom"))
        assert names["bedroom"] >= 1
        counts.add(1 + sum(names.values()) - names["hallway"])
    assert counts == {5, 6, 7, 8, 9}


def test_rooms_have_the_size_of_their_kind(plans):
    for plan in plans:
        for room in rectangles(plan):
            narrow = min(room.width, room.length)
            if room.name == "hallway":
                assert narrow >= 0.85
                continue
            low, high = AREAS[room.name]
            assert low - 0.05 <= room.area <= high + 0.05, room
            assert narrow >= NARROWEST[room.name] - 0.01, room
        assert min(rectangles(plan)[0].width, rectangles(plan)[0].length) >= 1.2


def test_rooms_do_not_overlap_and_walls_fit_between_them(plans):
    for plan in plans:
        for one, other in combinations(rectangles(plan), 2):
            assert max(one.gap(other)) >= WALL - 0.005


def test_doorways_join_two_rooms_and_are_0_8_to_1_m_wide(plans):
    for plan in plans:
        for hole in of_kind(plan, "doorway"):
            names = {room.name for room in rooms_beside(plan, hole)}
            width = max(hole.x1 - hole.x0, hole.y1 - hole.y0)
            assert len(rooms_beside(plan, hole)) == 2
            if names == {"hallway"}:
                assert hole.head == plan.height
            elif names == {"kitchen", "living room"}:
                assert 0.8 - 1e-3 <= width <= 2.4
            else:
                assert "hallway" in names
                assert 0.8 - 1e-3 <= width <= 1.0


def test_windows_and_the_one_outer_door_lead_outdoors(plans):
    for plan in plans:
        kinds = Counter(hole.kind for hole in plan.openings)
        assert kinds["door"] == 1
        assert kinds["window"] >= 3
        for hole in plan.openings:
            if hole.kind == "doorway":
                continue
            (room,) = rooms_beside(plan, hole)
            assert hole.pane is not None
            assert hole.kind == "window" or room.name == "hallway"
            assert hole.head < plan.height
        lit = {room for hole in of_kind(plan, "window") for room in rooms_beside(plan, hole)}
        for room in rectangles(plan):
            assert room in lit or room.name in ("hallway", "bathroom", "laundry room")


def test_openings_do_not_touch_each_other(plans):
    for plan in plans:
        for one, other in combinations(plan.openings, 2):
            holes = [Rectangle("", h.x0, h.y0, h.x1, h.y1) for h in (one, other)]
            assert max(holes[0].gap(holes[1])) > 0.05


def test_some_place_in_the_hallway_is_far_from_every_window(plans):
    for plan in plans:
        halls = [room for room in rectangles(plan) if room.name == "hallway"]
        spots = free_spots(halls, plan.stairs)
        far = np.stack(
            [
                away_from(spots, hole.x0, hole.y0, hole.x1, hole.y1) > 3.2
                for hole in of_kind(plan, "window")
            ]
        )
        assert far.all(axis=0).any()


def test_the_robot_gets_through_the_built_structure_into_every_room(plans):
    for plan in plans[::6]:
        structure = triangles(build_structure(plan.rooms, plan.openings, plan.height, plan.stairs))
        grid = grid_around(structure, 0.04)
        walls = occupied(structure, 0.02, 0.65, grid)
        if plan.stairs is not None:
            x0, y0, x1, y1 = plan.stairs.bounds
            low, high = grid.cell_of(x0, y0), grid.cell_of(x1, y1)
            walls[low[0] : high[0] + 1, low[1] : high[1] + 1] = True
        free = clearance(walls, grid) > 0.2
        points = free_spots([rectangles(plan)[0]], plan.stairs)
        start = next(cell for p in points if free[cell := grid.cell_of(*p)])
        rows, columns = np.nonzero(reachable(free, start))
        xy = grid.pixels_to_xy(np.column_stack([columns, rows]))
        for room in plan.rooms:
            inside = (xy > (room.x0, room.y0)) & (xy < (room.x1, room.y1))
            area = (room.x1 - room.x0) * (room.y1 - room.y0)
            if room.name != "hallway":
                assert inside.all(axis=1).sum() * 0.04**2 > 0.3 * area, room.name


def test_a_plan_without_a_doorway_is_told_from_one_with_it(plans):
    rooms = rectangles(plans[0])
    ways = of_kind(plans[0], "doorway")
    assert all_reached(rooms, ways, plans[0].stairs)
    bath = next(room for room in rooms if room.name == "bathroom")
    to_bath = next(hole for hole in ways if bath in rooms_beside(plans[0], hole))
    assert not all_reached(rooms, [hole for hole in ways if hole != to_bath], plans[0].stairs)


def test_about_60_percent_of_homes_have_stairs_and_both_kinds_come(plans):
    stairs = [plan.stairs for plan in plans if plan.stairs is not None]
    assert 0.4 <= len(stairs) / len(plans) <= 0.8
    assert {it.kind for it in stairs} == {"up", "down"}


def test_stairs_lie_in_one_room_whose_floor_goes_on_before_them(plans):
    for plan in plans:
        if plan.stairs is None:
            continue
        x0, y0, x1, y1 = plan.stairs.bounds
        rooms = [
            r
            for r in plan.rooms
            if r.x0 - 0.01 <= x0 and x1 <= r.x1 + 0.01 and r.y0 - 0.01 <= y0 and y1 <= r.y1 + 0.01
        ]
        assert [room.name for room in rooms] in (["hallway"], ["living room"])
        place = Rectangle("", *plan.stairs.bounds)
        for hole in plan.openings:
            gap = place.gap(Rectangle("", hole.x0, hole.y0, hole.x1, hole.y1))
            assert max(gap) > 0.05


@pytest.mark.slow
def test_hallways_come_straight_bent_and_branched():
    names = ["living room", "kitchen", "bathroom", "bedroom", "study", "kid's room", "bedroom"]
    shapes = Counter()
    for seed in range(30):
        rooms = room_layout(np.random.default_rng(seed), names, None)
        if rooms is None:
            continue
        main, *legs = [room for room in rooms if room.name == "hallway"]
        if not legs:
            shapes["straight"] += 1
            continue
        (leg,) = legs
        along = "x" if main.width > main.length else "y"
        ends = (
            (leg.x0 - main.x0, main.x1 - leg.x1)
            if along == "x"
            else (leg.y0 - main.y0, main.y1 - leg.y1)
        )
        shapes["L" if min(ends) < 0.01 else "T"] += 1
    assert set(shapes) == {"straight", "L", "T"}


@pytest.mark.parametrize("opening", [doorway, wide_passage])
def test_walls_as_long_as_an_opening_and_two_corners_take_one_for_all_rounding(opening):
    for millimetres in range(1600, 2700):
        wall = Stretch(0.0, 0.0, millimetres / 1000, 0.1, "x")
        hole = opening(np.random.default_rng(0), wall, [])
        assert hole is not None
        assert hole.x0 > 0.13 and hole.x1 < wall.x1 - 0.13


def test_a_plan_that_never_works_out_is_none(monkeypatch):
    monkeypatch.setattr("sim_stubs.homes.floor_plan.floor_plan._drawn", lambda rng, held_out: None)
    assert floor_plan(np.random.default_rng(0), held_out=True) is None


def test_a_seed_draws_the_same_plan_twice():
    first, again, other = (floor_plan(np.random.default_rng(seed), True) for seed in (5, 5, 7))
    assert first == again
    assert first != other


@pytest.mark.slow
def test_benchmark_homes_share_no_surface_with_training_homes():
    looks = []
    for held_out in (False, True):
        plans = [floor_plan(np.random.default_rng(seed), held_out) for seed in range(4)]
        rooms = [room for plan in plans for room in plan.rooms]
        surfaces_of = {s for room in rooms for s in (room.floor, room.wall, room.ceiling)}
        panes = {hole.pane for plan in plans for hole in plan.openings if hole.pane is not None}
        looks.append(surfaces_of | panes)
    assert min(len(side) for side in looks) > 20
    assert not looks[0] & looks[1]
