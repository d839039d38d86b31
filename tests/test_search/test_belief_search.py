"""The search by belief: what it goes to, when it has arrived, and when it gives up."""

from dataclasses import replace

import numpy as np
import pytest

from mapping.clip.places.belief import PlaceBelief
from mapping.clip.places.footprint import PLACE
from mapping.clip.scores import Query
from nav.frontier import FrontierSearch
from vizbot.config import Config
from vizbot.core.geometry import planar
from vizbot.core.observer import Outcome
from vizbot.core.types import OccupancyGrid
from vizbot.objectnav import reasons, verdicts
from vizbot.objectnav.belief_search import HELD, LOOK_STEPS, MOST_BELIEFS, BeliefSearch
from vizbot.objectnav.exploration import Exploration
from vizbot.objectnav.tasks import Goal

CONFIG = Config()
SEEN_FROM = 3.0, 2.0
"""Where the camera stood when it saw the places of a belief."""
HERE = planar(3.6, 2.0, 0.0)
BEFORE = planar(3.25, 2.0, 0.0)
"""Near what is at 5.1, 2.1, and not yet where the robot stops."""
SOFA, TV = (Goal(text, np.ones(4, np.float32), 0.5) for text in ("sofa", "tv"))

KITCHEN = Goal("kitchen", np.ones(4, np.float32), 0.5, rivals=(np.ones(4, np.float32),))


def room(explored=True, width=6.0):
    """A closed room of that width by 4 m, the west of which may be unseen; its frontiers."""
    occupancy = np.zeros((90, round(width / 0.05) + 10), np.float32)
    occupancy[:5] = occupancy[-5:] = 1.0
    occupancy[:, :5] = occupancy[:, -5:] = 1.0
    grid = OccupancyGrid(occupancy, 0.05, np.array([-0.25, -0.25]))
    frontiers = FrontierSearch(CONFIG.frontier)
    mask = frontiers.explored.mask_on(grid)
    mask[:] = True
    if not explored:
        mask[10:80, 10:60] = False
    return grid, frontiers


def believed(at=None, likeness=0.0, shape=(18, 26), seen_from=SEEN_FROM, height=0.5):
    """A belief with these probabilities at x, y."""
    probabilities = np.zeros(shape)
    for (x, y), probability in (at or {}).items():
        probabilities[int(y / PLACE), int(x / PLACE)] = probability
    return PlaceBelief(
        np.zeros(2, np.int64), probabilities, np.full(shape, likeness, np.float32),
        np.ones(shape, bool), np.full((*shape, 2), seen_from), np.full(shape, height, np.float32),
    )  # fmt: skip


def stepped(search, belief, grid, T_map_base, steps):
    return [search.go(SOFA, belief, grid, T_map_base) for _ in range(steps)][-1]


def walked(search, belief, grid, T_map_base, facing):
    """Decisions, to the end, of a robot that is at the end of each way at once, facing (x, y)."""
    decisions = []
    while not decisions or decisions[-1].ended is None:
        assert len(decisions) < 40
        decisions.append(search.go(SOFA, belief, grid, T_map_base))
        navigation = decisions[-1].navigation
        if navigation is not None and not navigation.arrived:
            x, y = navigation.path[-1]
            T_map_base = planar(x, y, np.arctan2(facing[1] - y, facing[0] - x))
    return decisions


@pytest.fixture
def seen_room():
    return room()


@pytest.fixture
def grid(seen_room):
    return seen_room[0]


@pytest.fixture
def search(seen_room):
    """A search in a room of which all was seen."""
    return BeliefSearch(CONFIG, seen_room[1])


@pytest.fixture
def unseen():
    """A search in a room whose west was not seen, and its grid."""
    grid, frontiers = room(explored=False)
    return BeliefSearch(CONFIG, frontiers), grid


def test_it_goes_to_what_is_likely_rather_than_into_the_unknown(unseen):
    search, grid = unseen
    decision = search.go(SOFA, believed(at={(5.0, 2.0): 0.7}), grid, planar(3.6, 2.0, 0.0))
    assert not decision.exploring
    assert np.linalg.norm(decision.navigation.goal_xy - (5.0, 2.0)) < PLACE


def test_it_tells_what_it_searches_for_and_did_last(search, grid):
    assert search.goal is None
    for goal in (SOFA, TV):
        search.go(goal, believed(at={(1.0, 2.0): 0.9}), grid, HERE)
        assert search.goal is goal


@pytest.mark.parametrize("probability", [0.04, 0.1])
def test_it_looks_into_the_unknown_rather_than_at_what_is_unlikely(unseen, probability):
    """Though what is unlikely is right before it."""
    search, grid = unseen
    decision = search.go(SOFA, believed(at={(5.5, 2.0): probability}), grid, HERE)
    assert decision.exploring and decision.navigation.goal_xy[0] < 3.2


@pytest.mark.parametrize(("probability", "outcome"), [(0.95, Outcome.ARRIVED), (0.1, None)])
def test_it_has_arrived_where_it_stands_before_what_it_believes(search, grid, probability, outcome):
    before = planar(4.3, 2.1, 0.0)
    belief = believed(at={(5.1, 2.1): probability})
    decision = stepped(search, belief, grid, before, LOOK_STEPS)
    assert decision.ended is None
    ended = search.go(SOFA, belief, grid, before).ended
    assert (None if ended is None else ended[0]) in (outcome, Outcome.NOT_FOUND)
    assert (ended is not None and ended[0] is Outcome.ARRIVED) is (outcome is Outcome.ARRIVED)


def test_what_was_looked_at_and_not_believed_waits_behind_other_places(search, grid):
    belief = believed(at={(5.1, 2.1): 0.5, (1.1, 3.1): 0.3})
    decision = stepped(search, belief, grid, planar(4.0, 2.0, 0.0), LOOK_STEPS + 1)
    assert np.linalg.norm(decision.navigation.goal_xy - (1.1, 3.1)) < PLACE


def test_it_gives_up_where_all_was_seen_and_nothing_is_likely(search, grid):
    decision = search.go(SOFA, believed(), grid, planar(3.0, 2.0, 0.0))
    assert decision.ended is not None and decision.ended[0] is Outcome.NOT_FOUND


def test_late_in_a_search_less_is_enough(search, grid):
    belief, before = believed(at={(5.1, 2.1): 0.7}), planar(4.3, 2.1, 0.0)
    search.go(SOFA, believed(at={(1.1, 3.1): 0.3}), grid, before)
    search._steps = 10_000
    decision = stepped(search, belief, grid, before, LOOK_STEPS + 1)
    assert decision.ended is not None and decision.ended[0] is Outcome.ARRIVED


@pytest.mark.parametrize(
    ("times_of_patience", "enough"),
    [(0.0, 0.8), (0.5, 0.7), (1.0, 0.6), (1.5, 0.5), (2.0, 0.4), (3.0, 0.4)],
)
def test_what_is_enough_falls_with_the_time_spent(times_of_patience, enough):
    """From `sure` over `settled` to `last`, though much is left to see."""
    grid, frontiers = room(explored=False)
    for probability in (enough + 0.01, enough - 0.01):
        search = BeliefSearch(CONFIG, frontiers)
        search.go(SOFA, believed(), grid, HERE)
        search._steps = round(times_of_patience * CONFIG.objectnav.search.late_after_steps)
        decision = search.go(SOFA, believed(at={(5.1, 2.1): probability}), grid, BEFORE)
        assert decision.threshold == pytest.approx(enough, abs=0.005)
        assert (decision.activity == "closing in") == (probability > enough)


def test_what_is_believed_near_by_is_gone_up_to_before_anything_else(unseen):
    search, grid = unseen
    belief = believed(at={(5.1, 2.1): 0.95, (2.6, 2.1): 0.7})
    decision = search.go(SOFA, belief, grid, planar(3.3, 2.1, 0.0))
    assert decision.activity == "closing in"
    assert np.linalg.norm(decision.navigation.goal_xy - (5.1, 2.1)) < PLACE
    ended = stepped(search, belief, grid, planar(4.3, 2.1, 0.0), LOOK_STEPS + 1).ended
    assert ended is not None and ended[0] is Outcome.ARRIVED
    assert np.linalg.norm(search.answer_xy - (5.1, 2.1)) < PLACE


@pytest.mark.parametrize(
    ("apart", "likelier", "goes_on"), [(1.5, 0.95, True), (1.5, 0.9, False), (1.75, 0.95, False)]
)
def test_of_what_one_patch_may_show_the_likeliest_is_gone_up_to(
    search, grid, apart, likelier, goes_on
):
    """What stands before a sofa is believed for its sake: 1.8 m from there is too far from it."""
    before, sofa = (3.6, 2.1), (3.6 + apart, 2.1)
    belief = believed(at={before: 0.85, sofa: likelier})
    walked(search, belief, grid, planar(2.4, 2.1, 0.0), sofa)
    assert np.linalg.norm(search.answer_xy - (sofa if goes_on else before)) < PLACE


def test_a_likelier_place_behind_a_wall_is_no_way_around_it(search, grid):
    grid.occupancy[: int(3.9 / 0.05), int(4.6 / 0.05) : int(4.7 / 0.05)] = 1.0
    belief = believed(at={(3.6, 1.1): 0.85, (5.1, 1.1): 0.95})
    walked(search, belief, grid, planar(2.4, 1.1, 0.0), (5.1, 1.1))
    assert np.linalg.norm(search.answer_xy - (3.6, 1.1)) < PLACE


def test_of_a_room_the_place_in_sight_is_gone_up_to_as_it_is(search, grid):
    belief = believed(at={(3.6, 2.1): 0.85, (5.1, 2.1): 0.95})
    decision = search.go(KITCHEN, belief, grid, planar(2.4, 2.1, 0.0))
    assert np.linalg.norm(decision.navigation.goal_xy - (3.6, 2.1)) < PLACE


@pytest.mark.parametrize(("left", "arrives"), [(1.02 * HELD, True), (0.9 * HELD, False)])
def test_a_believed_place_may_lose_some_of_its_probability_on_the_way(search, grid, left, arrives):
    assert search._search.arrival_probability_early * left > search._search.arrival_probability_last
    believed_at_first = believed(at={(5.1, 2.1): search._search.arrival_probability_early + 0.01})
    search.go(SOFA, believed_at_first, grid, planar(3.3, 2.1, 0.0))
    less = believed(
        at={(5.1, 2.1): search._search.arrival_probability_early * left, (1.1, 3.1): 0.3}
    )
    ended = stepped(search, less, grid, planar(4.3, 2.1, 0.0), LOOK_STEPS + 1).ended
    assert (ended is not None and ended[0] is Outcome.ARRIVED) is arrives


def in_kitchen(search, grid, probabilities):
    """Activities of a robot that turns as it is told before a place that is believed so."""
    activities, yaw = [], 0.0
    for step in range(60):
        belief = believed(at={(5.1, 2.1): probabilities(step), (1.1, 3.1): 0.3})
        decision = search.go(KITCHEN, belief, grid, planar(4.6, 2.1, yaw))
        activities.append(decision.activity)
        if decision.activity == "looking around":  # the probability may fall meanwhile
            assert decision.threshold == CONFIG.objectnav.search.arrival_probability_early
        if decision.ended is not None or decision.activity == "looking closer":
            return activities
        yaw += 0.29 * decision.twist.angular
    raise AssertionError("it neither arrives nor drives elsewhere")


def test_in_a_room_it_turns_around_once_before_it_says_that_it_has_arrived(search, grid):
    activities = in_kitchen(search, grid, lambda step: 0.95)
    assert activities[0] == "looking around" and activities[-1] == "arrived"
    assert 15 < activities.count("looking around") < 25
    search.refute()
    search._verdicts = verdicts.Verdicts()
    assert "looking around" not in in_kitchen(search, grid, lambda step: 0.95)


def test_a_room_that_is_less_likely_once_all_around_was_seen_is_left(search, grid):
    sure = CONFIG.objectnav.search.arrival_probability_early
    activities = in_kitchen(search, grid, lambda step: 0.95 if step < 10 else 0.97 * sure)
    assert activities[-1] == "looking closer" and "making sure" not in activities
    assert activities.count("looking around") > 15


def test_what_is_enough_for_a_room_does_not_fall_until_nothing_is_left_to_try(search, grid):
    before = planar(4.6, 2.1, 0.0)
    search.go(KITCHEN, believed(at={(1.1, 3.1): 0.3}), grid, before)
    search._steps = CONFIG.objectnav.search.late_after_steps
    belief = believed(at={(5.1, 2.1): 0.7, (1.1, 3.1): 0.3})
    assert (
        search.go(KITCHEN, belief, grid, before).threshold
        == CONFIG.objectnav.search.arrival_probability_early
    )
    search.go(SOFA, belief, grid, before)
    search._steps = CONFIG.objectnav.search.late_after_steps
    assert (
        search.go(SOFA, belief, grid, before).threshold
        < CONFIG.objectnav.search.arrival_probability_early
    )


def test_at_the_end_a_room_is_arrived_at_by_what_is_enough_then(search, grid):
    belief, place = believed(at={(5.1, 2.1): 0.7}), (5.1, 2.1)
    (x, y), yaw = (4.6, 2.1), 0.0
    for _ in range(120):
        decision = search.go(KITCHEN, belief, grid, planar(x, y, yaw))
        if decision.ended is not None:
            break
        yaw += 0.29 * decision.twist.angular
        if decision.navigation.distance > 0.0:
            x, y = decision.navigation.path[-1]
            yaw = np.arctan2(place[1] - y, place[0] - x)
    assert decision.ended[0] is Outcome.ARRIVED


def test_the_last_place_is_shown_beside_what_is_enough_at_the_end(search, grid):
    settings, place, before = CONFIG.objectnav.search, (5.1, 2.1), planar(1.5, 2.1, 0.0)
    belief = believed(at={place: settings.arrival_probability_last + 0.05})
    *looking, last = walked(search, belief, grid, before, place)
    assert last.ended is not None and last.ended[0] is Outcome.ARRIVED
    assert looking[0].activity == "looking closer"
    assert looking[0].threshold == pytest.approx(settings.arrival_probability_early, abs=0.01)
    held = [decision.threshold for decision in looking if decision.activity == "making sure"][-1]
    assert (
        held == last.threshold == search.threshold(SOFA) == HELD * settings.arrival_probability_last
    )
    assert search.threshold(TV) == settings.arrival_probability_early


def test_every_step_says_why_until_the_search_ends():
    grid, frontiers = room()
    place = (5.1, 2.1)
    sure, belief = (believed(at={place: probability}) for probability in (0.85, 0.45))
    decisions = [
        decision
        for each in (belief, sure)
        for decision in walked(BeliefSearch(CONFIG, frontiers), each, grid, BEFORE, place)[:-1]
    ]
    whys = {decision.activity: decision.why for decision in decisions}
    assert {*whys} == {"looking closer", "making sure", "closing in"}
    assert all(decision.why for decision in decisions)
    assert whys["closing in"] == reasons.SURE.format(chance="85%")
    late = BeliefSearch(CONFIG, frontiers)
    stepped(late, belief, grid, planar(4.3, 2.1, 0.0), LOOK_STEPS + 1)
    decision = late.go(SOFA, belief, grid, planar(1.1, 2.1, 0.0))
    may_be = reasons.MAY_BE.format(away=4, chance="45%")
    assert (decision.activity, decision.why) == ("going back", f"{reasons.ALL_TRIED}; {may_be}")


def test_why_it_goes_to_a_frontier_is_said_by_what_is_there_until_it_goes_elsewhere():
    grid, frontiers = room(explored=False)
    search = BeliefSearch(CONFIG, frontiers)
    first = search.go(SOFA, believed(), grid, HERE)
    assert first.exploring and first.why == f"{reasons.LITTLE_LEFT}; {reasons.NOTHING_SEEN}"
    exploration = Exploration(CONFIG)
    exploration.frontiers = frontiers
    assert exploration.decide(grid, HERE).why == reasons.MOST_FOR_THE_WAY
    later = search.go(SOFA, believed(at={(5.1, 2.1): 0.04}), grid, HERE)
    less_worth = reasons.LESS_WORTH.format(chance="4%")
    assert later.why == f"{reasons.LITTLE_LEFT}; {less_worth}"


def test_the_end_in_vain_is_shown_beside_what_would_have_been_enough(search, grid):
    settings, place, before = CONFIG.objectnav.search, (5.1, 2.1), planar(1.5, 2.1, 0.0)
    belief = believed(at={place: settings.arrival_probability_last - 0.05})
    decisions = walked(search, belief, grid, before, place)
    assert decisions[-1].ended[0] is Outcome.NOT_FOUND
    assert decisions[-1].threshold == settings.arrival_probability_last


def test_the_score_of_what_it_goes_up_to_is_told_though_another_place_is_likelier(search, grid):
    belief, before = believed(at={(5.1, 2.1): 0.85, (1.1, 3.1): 0.95}), planar(4.3, 2.1, 0.0)
    decisions = [search.go(SOFA, belief, grid, before) for _ in range(LOOK_STEPS + 1)]
    assert {decision.score for decision in decisions} == {0.85}
    assert decisions[-1].ended == (Outcome.ARRIVED, "85% sure, from near by")


def test_a_held_aim_is_shown_beside_what_it_may_fall_to(search, grid):
    sure, before, at = (
        CONFIG.objectnav.search.arrival_probability_early,
        planar(3.3, 2.1, 0.0),
        planar(4.3, 2.1, 0.0),
    )
    first = search.go(SOFA, believed(at={(5.1, 2.1): sure + 0.01}), grid, before)
    assert (first.activity, first.threshold) == ("closing in", search._sure)
    less = believed(at={(5.1, 2.1): 1.02 * HELD * sure})
    held = [search.go(SOFA, less, grid, at) for _ in range(LOOK_STEPS)]
    assert {decision.activity for decision in held} == {"making sure"}
    assert all(decision.threshold < less.probabilities.max() < search._sure for decision in held)
    assert held[-1].threshold == HELD * search._sure
    arrived = search.go(SOFA, less, grid, at)
    assert arrived.ended[0] is Outcome.ARRIVED and arrived.threshold == search.threshold(SOFA)


def test_what_was_seen_on_the_other_side_of_a_wall_is_reached_there():
    grid, frontiers = room()
    grid.occupancy[30:, 58:61] = 1.0  # at x = 2.7 m, with a door in the south
    grid.occupancy[60:75, 61:69] = 1.0  # what stands behind it
    search = BeliefSearch(CONFIG, frontiers)
    place, before = (3.1, 3.1), planar(2.2, 3.1, 0.0)
    belief = replace(believed(at={place: 0.95}), seen_from=np.full((18, 26, 2), (4.5, 3.1)))
    decision = search.go(SOFA, belief, grid, before)
    assert decision.activity == "looking closer" and decision.navigation.path[-1][0] > 3.1
    ended = walked(search, belief, grid, before, place)[-1].ended
    assert ended is not None and ended[0] is Outcome.ARRIVED
    from_the_west = replace(belief, seen_from=np.full((18, 26, 2), (1.5, 3.1)))
    search = BeliefSearch(CONFIG, frontiers)
    assert search.go(SOFA, from_the_west, grid, before).activity == "making sure"


def test_a_place_that_was_looked_at_in_vain_is_left(search, grid):
    belief, first = believed(at={(3.1, 2.1): 0.3}), planar(2.0, 2.1, 0.0)
    assert stepped(search, belief, grid, first, LOOK_STEPS).activity == "making sure"
    assert stepped(search, belief, grid, first, 1).ended[0] is Outcome.NOT_FOUND


def test_another_goal_begins_anew_and_its_belief_is_kept(search, grid):
    belief, before = believed(at={(5.1, 2.1): 0.3}), planar(4.0, 2.0, 0.0)
    assert stepped(search, belief, grid, before, LOOK_STEPS).activity == "making sure"
    assert stepped(search, belief, grid, before, 1).ended is not None
    assert search.go(TV, belief, grid, before).activity == "making sure"
    question = Query(TV.embedding, None)
    assert search.belief_of(TV, question) is search.belief_of(replace(TV), question)
    assert search.belief_of(SOFA, question) is not search.belief_of(TV, question)


def test_what_somebody_says_is_not_it_is_left_and_the_search_goes_on(search, grid):
    belief, before = believed(at={(5.1, 2.1): 0.95, (1.1, 3.1): 0.5}), planar(4.3, 2.1, 0.0)
    assert stepped(search, belief, grid, before, LOOK_STEPS + 1).ended is not None
    search.refute()
    assert search.answer_xy is None
    decision = search.go(SOFA, search.as_judged(SOFA, belief), grid, before)
    assert decision.ended is None
    assert np.linalg.norm(decision.navigation.goal_xy - (1.1, 3.1)) < PLACE
    others = search.as_judged(TV, belief)
    assert search.go(TV, others, grid, before).activity == "making sure"
    asked_again = stepped(search, search.as_judged(SOFA, belief), grid, before, LOOK_STEPS + 1)
    assert asked_again.ended is None


def test_a_place_that_is_exactly_as_likely_as_is_enough_is_believed():
    grid, frontiers = room()
    settings = CONFIG.objectnav.search
    steady = settings.model_copy(
        update={
            "arrival_probability_late": settings.arrival_probability_early,
            "arrival_probability_last": settings.arrival_probability_early,
        }
    )
    objectnav = CONFIG.objectnav.model_copy(update={"search": steady})
    search = BeliefSearch(CONFIG.model_copy(update={"objectnav": objectnav}), frontiers)
    belief = believed(at={(5.1, 2.1): settings.arrival_probability_early})
    assert search.go(SOFA, belief, grid, planar(3.3, 2.1, 0.0)).activity == "closing in"


@pytest.mark.parametrize(
    ("goal", "place", "away", "believed_less"),
    [
        (SOFA, (5.1, 2.1), 0.75, True),
        (SOFA, (5.1, 2.1), 0.76, False),
        (KITCHEN, (5.125, 2.125), 2.0, True),
        (KITCHEN, (5.125, 2.125), 2.01, False),
    ],
)
def test_no_takes_belief_from_all_that_is_as_near_as_one_place_or_from_the_floor_of_a_room(
    search, grid, goal, place, away, believed_less, monkeypatch
):
    monkeypatch.setattr(verdicts, "APART", 0.75)  # a binary number: the edge is exact
    belief = believed(at={place: 0.8})
    search.go(goal, belief, grid, HERE)
    rows, columns = np.nonzero(belief.probabilities)
    answer_xy = belief.xy(rows, columns)[0] - (away, 0.0)
    if goal is SOFA:
        search.answer_xy = answer_xy
        search.refute()
    else:
        search.refute(answer_xy)
    left = search.as_judged(goal, belief).probabilities[rows, columns]
    assert (left < 0.8) == believed_less


def test_what_the_robot_goes_up_to_is_left_once_somebody_says_that_it_is_not_it(search, grid):
    belief, before = believed(at={(5.1, 2.1): 0.5, (1.1, 3.1): 0.4}), planar(3.3, 2.1, 0.0)
    seen = search.place_of(search.go(SOFA, belief, grid, before).navigation)
    assert np.linalg.norm(seen - (5.1, 2.1)) < PLACE
    search.refute(seen)
    decision = search.go(SOFA, search.as_judged(SOFA, belief), grid, before)
    assert decision.ended is None and not decision.exploring
    assert np.linalg.norm(search.place_of(decision.navigation) - (1.1, 3.1)) < PLACE
    again = replace(SOFA)
    decision = search.go(again, search.as_judged(again, belief), grid, before)
    assert np.linalg.norm(search.place_of(decision.navigation) - (1.1, 3.1)) < PLACE, "kept"


def test_where_somebody_says_that_it_is_the_robot_goes_and_stops(unseen):
    search, grid = unseen
    belief, before = believed(at={(5.1, 2.1): 0.2, (3.3, 3.4): 0.6}), planar(3.3, 2.1, 0.0)
    by_itself = search.go(SOFA, belief, grid, before)
    assert np.linalg.norm(by_itself.navigation.goal_xy - (3.3, 3.4)) < PLACE

    search.affirm(np.array([5.1, 2.1]))
    judged = search.as_judged(SOFA, belief)
    assert judged.probabilities.max() == 1.0
    decisions = walked(search, judged, grid, before, (5.1, 2.1))
    assert {decision.why for decision in decisions} <= {reasons.AFFIRMED, ""}
    assert decisions[-1].ended == (Outcome.ARRIVED, reasons.AFFIRMED)
    assert np.linalg.norm(search.answer_xy - (5.1, 2.1)) < PLACE

    search.refute()
    left = search.as_judged(SOFA, belief).probabilities
    assert left.max() == 0.6 and 0.0 < left[8, 20] < 0.02
    search.affirm(np.array([5.1, 2.1]))
    assert search.as_judged(replace(SOFA), belief).probabilities.max() == 0.6, "of one search"


def test_a_place_that_was_never_seen_cannot_be_made_certain(search, grid):
    belief = believed(at={(5.1, 2.1): 0.5})
    search.go(SOFA, belief, grid, planar(3.3, 2.1, 0.0))
    search.affirm(np.array([1.1, 1.1]))
    assert search.as_judged(SOFA, belief).probabilities.max() == 0.5


def test_what_is_not_worth_its_way_is_not_tried_and_the_end_says_how_much_was_seen():
    grid, frontiers = room(explored=False)
    before, belief = planar(4.3, 2.1, 0.0), believed(at={(5.1, 2.1): 0.1})
    settings = CONFIG.objectnav.search.model_copy(update={"min_probability_per_metre": 10.0})
    choosy = CONFIG.objectnav.model_copy(update={"search": settings})
    search = BeliefSearch(CONFIG.model_copy(update={"objectnav": choosy}), frontiers)
    assert search.go(SOFA, belief, grid, before).ended is None, "early, anything is tried"
    search._steps = 2 * settings.late_after_steps
    ended = search.go(SOFA, belief, grid, before).ended
    assert ended is not None and ended[0] is Outcome.NOT_FOUND
    share = int(ended[1].split("%")[0])
    assert 40 < share < 95


def test_the_same_goal_asked_for_again_is_a_new_search(search, grid):
    before, belief = planar(4.3, 2.1, 0.0), believed(at={(5.1, 2.1): 0.7})
    search.go(SOFA, belief, grid, before)
    search._steps = 10_000
    assert search.go(replace(SOFA), belief, grid, before).activity == "making sure"
    assert search._steps == 1


def test_the_goal_that_was_asked_for_least_recently_is_forgotten_first():
    search = BeliefSearch(CONFIG, FrontierSearch(CONFIG.frontier))
    question = Query(SOFA.embedding, (1.0, 0.0))
    goals = [Goal(f"thing {number}", SOFA.embedding, 0.5) for number in range(MOST_BELIEFS)]
    first, second, *_ = [search.belief_of(goal, question) for goal in goals]
    assert search.belief_of(goals[0], question) is first
    search.belief_of(SOFA, question)
    assert search.belief_of(goals[0], question) is first
    assert search.belief_of(goals[1], question) is not second
