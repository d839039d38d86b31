from itertools import pairwise

import numpy as np
import pytest

from sim_stubs.homes.furniture import procedural
from sim_stubs.homes.furniture.appearance import Appearance
from sim_stubs.homes.furniture.paint import painted_in_shades
from sim_stubs.homes.geometry.house import House, Instance, Room
from training.captions.facts import FACTS
from training.captions.house_facts import HouseFacts, piece_facts, related
from training.captions.patch_facts import seen
from vizbot.core.geometry import camera_mount, planar
from vizbot.core.types import Intrinsics

CAMERA = Intrinsics(640, 480, 617.0, 617.0, 319.5, 239.5)
RED = (0.8, 0.05, 0.05, 1.0)
WHOLE = np.array([[80, 0, 560, 480]], np.int32)


def square(x0, y0, x1, y1):
    return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]], float)


HOME = (Room("kitchen", square(-5, -5, 5, 5)),)


def piece(label, rgba=None):
    made = procedural.piece(label, np.random.default_rng(0))
    return made if rgba is None else painted_in_shades(made, rgba)


def house(*instances, rooms=HOME):
    return House(tuple(rooms), (), tuple(instances), np.zeros((1, 3)), (0.0, 0.0, 0.0))


def ahead(label, distance=3.0, aside=0.0, elevation=0.0, number=1, rgba=None, on=""):
    """A piece before a robot at the origin that looks along x; its front looks at the robot."""
    yaw = -np.pi / 2
    return Instance(f"{label}#{number}", piece(label, rgba), distance, aside, yaw, elevation, on)


def look(home, *painted, boxes=WHOLE, distance=3.0):
    """What is seen when instance i fills rows and columns: (i, top, bottom, left, right)."""
    segmentation = np.full((480, 640), -1, np.int32)
    for i, v0, v1, u0, u1 in painted:
        segmentation[v0:v1, u0:u1] = i
    depth = np.full((480, 640), distance, np.float32)
    T_world_cam = planar(0, 0, 0) @ camera_mount(0.4, 0.0, 0.0)
    facts = seen(HouseFacts.from_house(home), segmentation, depth, T_world_cam, CAMERA, boxes)
    found = [
        (FACTS[index].key, float(strength))
        for index, strength in zip(facts.indices, facts.strengths, strict=True)
    ]
    return [dict(found[first:end]) for first, end in pairwise(facts.starts)]


def relations(*instances, rooms=HOME):
    home = house(*instances, rooms=rooms)
    names = [it.name for it in home.instances]
    return {(names[i], what, names[j]): certain for i, j, what, certain in related(home)}


def test_the_more_of_a_patch_a_thing_takes_up_the_more_clearly_it_is_shown():
    home = house(ahead("sofa", 4.0, rgba=RED))
    views = [
        look(home, (0, 150, 150 + 2 * side, 320 - 2 * side, 320 + 2 * side))[0].get("sofa", 0.0)
        for side in (5, 40, 60, 100)
    ]
    assert views[0] == 0.0
    assert 0.0 < views[1] < views[2] < views[3] <= 1.0


@pytest.mark.parametrize(
    ("label", "distance", "painted", "boxes"),
    [
        ("sofa", 9.0, (0, 240, 262, 300, 360), WHOLE),
        ("wardrobe", 1.2, (0, 0, 480, 540, 600), WHOLE),
        ("wardrobe", 2.0, (0, 50, 450, 150, 500), np.array([[260, 180, 370, 290]], np.int32)),
    ],
    ids=["tiny", "a sliver", "a patch within a thing"],
)
def test_what_shows_too_little_of_a_thing_counts_neither_way(label, distance, painted, boxes):
    (patch,) = look(house(ahead(label, distance)), painted, boxes=boxes)
    assert np.isnan(patch[label])


def test_wider_classes_are_shown_and_akin_ones_are_left_open():
    (patch,) = look(house(ahead("office chair")), (0, 150, 330, 250, 390))
    assert patch["office chair"] == patch["chair"] > 0
    assert np.isnan(patch["armchair"])
    assert "sofa" not in patch
    (patch,) = look(house(ahead("washing machine")), (0, 150, 330, 250, 390))
    assert patch["laundry"] > 0


def test_colours_of_a_piece_are_certain_near_ones_open_and_others_wrong():
    (patch,) = look(house(ahead("chair", rgba=RED)), (0, 150, 330, 250, 390))
    assert patch["red chair"] > 0
    assert np.isnan(patch["orange chair"])
    assert np.isnan(patch["red armchair"])
    assert "blue chair" not in patch


def test_a_colour_goes_with_its_own_thing():
    home = house(ahead("chair", rgba=RED), ahead("table lamp", aside=1.0, rgba=(0.05, 0.1, 0.8, 1)))
    (patch,) = look(home, (0, 150, 330, 320, 450), (1, 150, 330, 150, 250))
    assert patch["red chair"] > 0
    assert patch["blue table lamp"] > 0
    assert "blue chair" not in patch
    assert "red table lamp" not in patch


def test_nothing_is_said_of_the_colour_of_a_picture():
    said = piece_facts("picture", Appearance(("black",), None))
    assert said["picture"]
    assert not said["black picture"]
    assert not said["red picture"]


def test_an_unknown_material_is_open_and_a_known_one_excludes_others():
    said = piece_facts("table", Appearance((), None))
    assert said["wooden table"] is False
    assert said["leather table"] is False
    said = piece_facts("table", Appearance(("brown",), "wood"))
    assert said["wooden table"] is True
    assert said["metal table"] is False
    assert "porcelain table" not in said


@pytest.mark.parametrize(("count", "two", "several"), [(1, 0, 0), (2, 1, 0), (3, None, 1)])
def test_things_are_counted(count, two, several):
    home = house(*(ahead("chair", aside=1 - i, number=i + 1) for i in range(count)))
    (patch,) = look(home, *((i, 150, 330, 100 + 150 * i, 200 + 150 * i) for i in range(count)))
    assert patch["chair"] > 0
    for key, expected in (("two chair", two), ("several chair", several)):
        strength = patch.get(key, 0.0)
        assert np.isnan(strength) if expected is None else (strength > 0) == bool(expected)


def test_a_relation_is_shown_where_both_things_are():
    table = ahead("dining table")
    home = house(table, ahead("table lamp", elevation=float(table.piece.size[2]), on=table.name))
    below, above = (0, 240, 380, 200, 440), (1, 140, 240, 290, 350)
    assert look(home, below, above)[0]["table lamp on table"] > 0
    assert look(home, below, above)[0]["lamp on dining table"] > 0
    assert "table lamp on table" not in look(home, below)[0]
    assert "table lamp on table" not in look(home, above)[0]
    assert np.isnan(look(home, below, (1, 215, 240, 300, 340))[0]["table lamp on table"])


def test_things_stand_next_to_each_other_unless_they_are_apart_or_a_wall_is_between():
    bed = ahead("bed")
    near = {gap: relations(bed, ahead("nightstand", aside=1.1 + gap)) for gap in (0.1, 0.9, 3.0)}
    key = (bed.name, "next to", "nightstand#1")
    assert near[0.1][key] is True
    assert near[0.9][key] is False
    assert key not in near[3.0]
    rooms = [Room("bedroom", square(-5, -5, 5, 0.9)), Room("study", square(-5, 0.9, 5, 5))]
    assert key not in relations(bed, ahead("nightstand", aside=1.2), rooms=rooms)


def test_what_stands_on_something_is_neither_next_to_it_nor_above_it():
    desk = ahead("desk")
    found = relations(desk, ahead("computer", elevation=float(desk.piece.size[2])))
    assert found["computer#1", "on", "desk#1"]
    assert not found.get(("desk#1", "next to", "computer#1"), False)
    assert ("computer#1", "above", "desk#1") not in found


@pytest.mark.parametrize(
    ("base", "other", "what"),
    [
        ("sofa", ahead("picture", distance=3.3, elevation=1.4), "above"),
        ("sofa", ahead("coffee table", distance=2.0), "in front of"),
        ("carpet", ahead("coffee table"), "on"),
    ],
)
def test_one_thing_is_above_in_front_of_or_on_another_and_not_the_other_way_round(
    base, other, what
):
    found = relations(ahead(base), other)
    assert found[other.name, what, f"{base}#1"]
    assert not found.get((f"{base}#1", what, other.name), False)


PATCHES = np.array([[80, 0, 560, 480], [200, 100, 424, 324], [264, 200, 376, 312]], np.int32)


def test_a_room_is_told_by_large_patches_with_what_it_is_known_by():
    kitchen = house(ahead("refrigerator"))
    large, medium, small = look(kitchen, (0, 100, 400, 250, 390), boxes=PATCHES)
    assert large["kitchen"] > medium["kitchen"] > 0
    assert np.isnan(small["kitchen"])
    assert "bathroom" not in large
    bare = look(kitchen, boxes=PATCHES)
    assert all(np.isnan(patch["kitchen"]) for patch in bare)


def test_a_room_beyond_is_not_shown_and_a_hallway_is_told_by_its_length():
    rooms = [Room("hallway", square(-1, -1, 4, 1)), Room("kitchen", square(4, -1, 8, 1))]
    home = house(rooms=rooms)
    wall, near, along = (look(home, distance=d)[0] for d in (1.0, 2.0, 3.5))
    assert "hallway" not in wall
    assert np.isnan(near["hallway"])
    assert along["hallway"] > 0
    assert "kitchen" not in wall and "kitchen" not in near


def test_a_colour_is_told_where_enough_of_the_thing_is_seen():
    home = house(ahead("sofa", 4.0, rgba=RED))
    much = look(home, (0, 100, 380, 160, 480))[0]
    assert much["red sofa"] == much["sofa"] > 0.5
    little = look(home, (0, 230, 290, 160, 290))[0]
    assert 0 < little["sofa"] < 0.5
    assert np.isnan(little["red sofa"])


def test_a_colour_that_some_part_has_is_open():
    look_of = Appearance(("white",), None, ("white", "red"))
    said = piece_facts("chair", look_of)
    assert said["white chair"] and not said["red chair"]
    assert "green chair" not in said


def test_a_carpet_that_the_robot_stands_on_is_seen():
    (patch,) = look(house(ahead("carpet", 0.5)), (0, 300, 480, 80, 560))
    assert patch["carpet"] > 0


def test_a_kids_room_may_be_called_a_bedroom():
    home = house(ahead("bed"), rooms=[Room("kid's room", square(-5, -5, 5, 5))])
    assert np.isnan(look(home, (0, 100, 400, 100, 500))[0]["bedroom"])


def test_an_empty_house_shows_nothing():
    (patch,) = look(house(rooms=()))
    assert {key for key, strength in patch.items() if not np.isnan(strength)} <= {"room"}
