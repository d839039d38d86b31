"""Homes that change between two visits."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.episodes.calibration_error import EXACT
from benchmarks.harness.bench_plan import UNATTENDED
from benchmarks.moved.bench import moved_result
from benchmarks.moved.changes import AWAY, CHANGES, Change, draw_changes, movable
from benchmarks.moved.visits import (
    ChangeWatcher,
    MovedAnswer,
    _Asked,
    _is_changed_class,
    shows_again,
)
from sim_stubs.homes.furniture import procedural
from sim_stubs.homes.geometry.bounding_block import Block
from sim_stubs.homes.geometry.house import Instance
from sim_stubs.homes.geometry.occupancy_slice import FreeSpace
from sim_stubs.homes.home import home
from tests.test_benchmarks.episodes.one_room import kitchen_with_sofa
from vizbot.core.geometry import planar


@pytest.fixture(scope="module")
def drawn():
    house = home(1110)
    answered = [each.label for each in movable(house)]
    return house, *draw_changes(house, answered, np.random.default_rng(3))


def test_one_thing_moves_in_its_room_one_to_another_room_and_one_is_gone(drawn):
    house, changes, changed = drawn
    assert tuple(each.kind for each in changes) == CHANGES
    within, across, gone = changes
    for change in (within, across):
        old, new = change.before, change.after
        assert np.hypot(new.x - old.x, new.y - old.y) >= AWAY
        same = house.room_at(old.x, old.y) is house.room_at(new.x, new.y)
        assert same == (change is within) and new in changed.instances
        others = [each for each in changed.instances if each is not new and each.label != "carpet"]
        assert not any(Block.around(new).overlaps(Block.around(each)) for each in others)
    assert gone.after is None and gone.text not in {each.label for each in changed.instances}
    assert len(changed.instances) == len(house.instances) - 1
    before, after = (
        FreeSpace.from_house(each).reached(*house.start[:2]) for each in (house, changed)
    )
    assert np.count_nonzero(before & after) > 0.9 * np.count_nonzero(before)


def test_the_rule_draws_the_same_again_and_only_from_what_was_answered(drawn):
    house, changes, _ = drawn
    answered = [each.label for each in movable(house)]
    again, _ = draw_changes(house, answered, np.random.default_rng(3))
    assert [(each.text, each.after and each.after.x) for each in again] == [
        (each.text, each.after and each.after.x) for each in changes
    ]
    fewer, _ = draw_changes(house, answered[:2], np.random.default_rng(3))
    assert len(fewer) == 2 and {each.text for each in fewer} <= set(answered[:2])


@pytest.fixture
def room():
    """A kitchen of 6 x 4 m whose sofa stood at 4 m, and is gone."""
    house = kitchen_with_sofa(6, 4, 4.0, (1.5, 2.0, 0.0))
    [sofa] = house.instances
    with EXACT.world(replace(house, instances=()), UNATTENDED, 1100) as world:
        yield world, sofa


def test_an_old_place_was_looked_at_again_where_a_near_picture_shows_half_of_it(room):
    world, sofa = room
    assert shows_again(world, planar(1.5, 2.0, 0.0), sofa)
    assert not shows_again(world, planar(1.5, 2.0, np.pi), sofa), "it looks away"
    assert not shows_again(world, planar(0.6, 2.0, 0.0), sofa), "it is farther than 3 m"


def test_what_hides_an_old_place_keeps_it_from_being_looked_at(room):
    _, sofa = room
    wardrobe = procedural.piece("wardrobe", np.random.default_rng(0))
    screen = Instance("wardrobe#1", wardrobe, 2.6, 2.0, -np.pi / 2)
    house = replace(kitchen_with_sofa(6, 4, 4.0, (1.5, 2.0, 0.0)), instances=(screen,))
    with EXACT.world(house, UNATTENDED, 1100) as world:
        assert not shows_again(world, planar(1.2, 2.0, 0.0), sofa)


def test_a_new_place_is_seen_where_the_picture_shows_the_thing(room):
    _, sofa = room
    house = kitchen_with_sofa(6, 4, 4.0, (1.5, 2.0, 0.0))
    away = replace(sofa, x=1.0)
    change = Change("sofa", "within its room", away, house.instances[0])
    with EXACT.world(house, UNATTENDED, 1100) as world:
        watcher = ChangeWatcher(world, [change])
        watcher.on_step(None)
        assert watcher.seen == {"sofa"} and watcher.looked_again == set()


def test_a_class_of_which_one_has_moved_is_not_asked_for(room):
    house = kitchen_with_sofa(6, 4, 4.0, (1.5, 2.0, 0.0))
    change = Change("sofa", "gone", house.instances[0], None)
    with EXACT.world(house, UNATTENDED, 1100) as world:
        assert not _is_changed_class(world, "sofa", [change])
        assert _is_changed_class(world, "couch", [change])
        assert not _is_changed_class(world, "kitchen", [change])


def test_an_answer_that_is_not_claimed_is_not_right(room):
    house = kitchen_with_sofa(6, 4, 4.0, (1.5, 2.0, 0.0))
    with EXACT.world(house, UNATTENDED, 1100) as world:
        at_sofa, nowhere = np.array([4.0, 2.0]), np.zeros((0, 2))
        assert _Asked("sofa", True, at_sofa[None], at_sofa, 0.8).right_in(world)
        assert not _Asked("sofa", False, nowhere, at_sofa, 0.3).right_in(world)
        assert not _Asked("sofa", True, nowhere, np.array([1.0, 2.0]), 0.8).right_in(world)
        assert not _Asked("sofa", False, nowhere, None, 0.0).right_in(world)


def test_the_figures_count_each_thing_once():
    number = itertools.count()

    def answer(kind, right, *, before=True, old=False, again=True, seen=True):
        text = f"thing {next(number)}"
        return MovedAnswer(1110, text, kind, before, right, old, again, seen, 0.8)

    answers = [
        answer("within its room", True),
        answer("to another room", False, old=True),
        answer("to another room", False, old=True, again=False, seen=False),
        answer("gone", True),
        answer("unmoved", True),
        answer("unmoved", False),
        answer("unmoved", True, before=False),
        answer("unmoved", False, before=False),
    ]
    result = moved_result({"default": answers, "nothing forgotten": answers[:1]})
    figures = result.summary
    assert figures["moved"] == 3 and figures["found_at_new_place"] == pytest.approx(1 / 3)
    assert figures["claimed_at_old_place"] == pytest.approx(1 / 3), "of those looked at again"
    assert figures["gone_refused"] == 1.0 and figures["gone"] == 1
    assert figures["unmoved"] == 2 and figures["lost_unmoved"] == 0.5
    assert figures["lost_unmoved_p"] == 1.0
    assert [row["row"] for row in result.rows] == ["default", "nothing forgotten"]
    assert "1 the first, 1 the second" in result.text
