"""The belief of places: what views of them say together, and what a closed loop changes."""

import numpy as np
import pytest

from mapping.clip.mapped_frames import MappedFrame
from mapping.clip.places.belief import Belief
from mapping.clip.places.evidence import LEAST, MOST, Weights, evidence, features, fitted_weights
from mapping.clip.places.footprint import PLACE, Footprint
from mapping.clip.places.place_rows import PlaceMap
from mapping.clip.places.place_views import PlaceViews
from mapping.clip.places.view_age import LATER
from mapping.clip.scores import NO_PICTURES, Background, Query
from sim_stubs.world.world_plan import D435I_COLOUR
from tests.helpers.bundles import camera
from vizbot.core.geometry import planar

WEIGHTS = Weights(
    np.r_[0.0, 0.0, 2.0, np.zeros(16), -3.0],
    np.r_[0.0, 0.0, 1.0, np.zeros(16), -3.0],
    np.r_[0.0, 0.0, 1.0, np.zeros(5), 0.5, np.zeros(10), -2.0],
)
"""Weights that count the coarsest patch's log odds alone."""
ASKED = Query(np.array([1.0, 0.0], np.float32), (10.0, -5.0))


def shown(*ranges):
    """A footprint of one patch with a place straight ahead at each range."""
    points = np.array([[0.0, 0.0, each] for each in ranges], np.float32)
    patches = np.zeros((len(ranges), 3), np.int16)
    return Footprint(points, patches, np.ones(len(ranges), np.float32))


class Seen:
    """A map that grows by one patch a frame, and a belief of it."""

    def __init__(self):
        self.map = PlaceMap(D435I_COLOUR)
        self.embeddings = np.zeros((0, 2), np.float32)
        self.belief = Belief(ASKED, WEIGHTS)

    def look(self, T_map_cam, likeness, *ranges, keyframe=0, T_keyframe_cam=None, time=0.0):
        row = np.array([[likeness, np.sqrt(1 - likeness**2)]], np.float32)
        T_keyframe_cam = T_map_cam if T_keyframe_cam is None else T_keyframe_cam
        frame = MappedFrame(len(self.map.frames), keyframe, T_keyframe_cam, time)
        self.map.add(frame, T_map_cam, shown(*ranges), len(self.embeddings))
        self.embeddings = np.vstack([self.embeddings, row])

    def now(self, keyframe_poses=None, belief=None, pictures=NO_PICTURES):
        statistics = np.tile(np.float32([0.1, 0.1]), (len(self.embeddings), 1))
        self.placed = self.map.placed(keyframe_poses or {0: np.eye(4)})
        return (belief or self.belief).update(
            self.embeddings, statistics, pictures, self.map.rows, self.placed
        )


def everything(believed):
    """What is believed of each place that was seen, by its column and row on the plan."""
    found = {}
    for row, column in np.argwhere(believed.seen):
        place = tuple((believed.low + np.array([column, row])).tolist())
        likeness, camera_xy = believed.likeness[row, column], believed.seen_from[row, column]
        found[place] = (believed.probabilities[row, column], likeness, *camera_xy)
    return found


def at(believed, x, y):
    column, row = np.floor(np.array([x, y]) / PLACE).astype(int) - believed.low
    return believed.probabilities[row, column]


def test_what_looks_like_it_is_believed_and_what_does_not_is_not():
    seen = Seen()
    seen.look(camera(0, 0), 0.9, 1.1)
    seen.look(camera(0, 3), 0.1, 1.1)
    believed = seen.now()
    assert at(believed, 1.1, 0.1) > 0.8 and at(believed, 1.1, 3.1) < 0.2
    assert believed.probabilities[~believed.seen].max(initial=0.0) == 0.0


def test_looking_from_near_and_not_finding_lowers_what_was_seen_from_afar():
    seen = Seen()
    seen.look(camera(0, 0.1), 0.7, 4.1)
    before = at(seen.now(), 4.1, 0.1)
    seen.look(camera(2.6, 0.1), 0.1, 1.5)
    assert at(seen.now(), 4.1, 0.1) < before


def test_a_belief_grows_with_the_map_to_what_one_of_the_whole_map_is():
    rng = np.random.default_rng(2)
    seen = Seen()
    for _ in range(30):
        x, y, yaw = rng.uniform(-3, 3, 3)
        seen.look(camera(x, y, yaw), rng.uniform(0, 0.95), *rng.uniform(0.5, 4.0, 3))
        step_by_step = seen.now()
    at_once = seen.now(belief=Belief(ASKED, WEIGHTS))
    for name in ("low", "probabilities", "likeness", "seen"):
        assert np.allclose(getattr(step_by_step, name), getattr(at_once, name), atol=1e-5)


class Counting:
    """A question that counts the elements that it is put to."""

    def __init__(self):
        self.elements, self.rivals = [], ()

    def scores(self, embeddings, statistics):
        self.elements.append(len(embeddings))
        return ASKED.scores(embeddings, statistics)

    def tail(self, pictures):
        return 0.0


def test_a_running_question_is_put_to_what_is_new_alone_after_a_loop_closure_too():
    seen, question = Seen(), Counting()
    belief = Belief(question, WEIGHTS)
    for i in range(4):
        seen.look(camera(0, 0.1, 0.6 * i), 0.5, 1.1)
        seen.now(belief=belief)
    seen.now({0: planar(0.5, 1.0, 0.2)}, belief)
    assert question.elements == [1, 1, 1, 1, 0]


@pytest.mark.parametrize(("a", "b"), [(0.4, 0.15), (0.9, 0.02)])
@pytest.mark.parametrize("log_odds", [(13.0, -5.0), None])
def test_an_encoder_with_other_cosines_in_the_same_order_gives_the_same_probabilities(
    a, b, log_odds
):
    rng = np.random.default_rng(4)
    drawn = rng.normal(size=(231, 32))
    rows = (drawn / np.linalg.norm(drawn, axis=1)[:, None]).astype(np.float32)
    scaled = np.column_stack([rows * np.float32(np.sqrt(a)), np.full(231, np.sqrt(b), np.float32)])
    undone = log_odds and (log_odds[0] / a, log_odds[1] - log_odds[0] * b / a)
    places = PlaceMap(D435I_COLOUR)
    for i in range(30):
        x, y, yaw = rng.uniform(-3, 3, 3)
        frame = MappedFrame(i, 0, camera(x, y, yaw), 0.0)
        places.add(frame, camera(x, y, yaw), shown(*rng.uniform(0.5, 4.0, 3)), i)
    believed = []
    for space, known in ((rows, log_odds), (scaled, undone)):
        elements, phrases, question = space[:30], space[30:230], space[230]
        background = Background(phrases, space[100:200])
        believed.append(
            Belief(Query(question, known), fitted_weights()).update(
                elements,
                background.statistics(elements),
                background.pictures,
                places.rows,
                places.placed({0: np.eye(4)}),
            )
        )
    assert np.ptp(believed[0].probabilities[believed[0].seen]) > 0.01
    np.testing.assert_allclose(believed[1].probabilities, believed[0].probabilities, rtol=2e-3)


def test_after_a_loop_closure_a_belief_is_what_a_new_one_is():
    poses = {0: np.eye(4), 1: np.eye(4)}
    seen = Seen()
    seen.look(camera(0, 0.1), 0.9, 1.1, keyframe=0)
    seen.look(camera(0, 0.1, 1.0), 0.5, 2.1, 2.4, keyframe=1)
    before = seen.now(poses)
    assert at(before, 1.1, 0.1) > 0.8
    poses = {0: planar(0.5, 1.0, 0.2), 1: poses[1]}
    closed, new = seen.now(poses), seen.now(poses, Belief(ASKED, WEIGHTS))
    assert np.array_equal(closed.low, new.low) or closed.seen.sum() == new.seen.sum()
    rows, columns = np.nonzero(closed.seen)
    for x, y in closed.xy(rows, columns):
        assert at(closed, x, y) == pytest.approx(at(new, x, y), abs=1e-6)
    x, y = (poses[0] @ [1.1, 0.1, 0.0, 1.0])[:2]
    assert at(closed, x, y) > 0.8


@pytest.mark.parametrize("room", [False, True])
def test_a_belief_that_grew_with_the_map_is_after_a_loop_closure_what_a_new_one_is(room):
    rng = np.random.default_rng(7)
    seen, poses = Seen(), {0: np.eye(4), 1: np.eye(4)}
    seen.belief = Belief(ASKED, fitted_weights(), room=room)
    for look in range(40):
        x, y, yaw = rng.uniform((-2, -2, -3), (2, 2, 3))
        ranges = rng.uniform(0.5, 5.0, 4)
        seen.look(camera(x, y, yaw), rng.uniform(0.1, 0.9), *ranges, keyframe=look % 2)
        before = seen.now(poses)
    poses[1] = planar(0.5, 1.0, 0.2)
    closed, new = (
        seen.now(poses, belief)
        for belief in (seen.belief, Belief(ASKED, fitted_weights(), room=room))
    )
    of_closed, of_new = everything(closed), everything(new)
    assert of_closed.keys() == of_new.keys() != everything(before).keys()
    assert np.ptp([each[0] for each in of_new.values()]) > 0.01
    for place, values in of_new.items():
        assert of_closed[place] == pytest.approx(values, abs=1e-6)


def test_a_view_counts_once_for_each_spot_and_heading():
    seen = Seen()
    assert seen.map.is_new_view(camera(0.1, 0.1), 0.0)
    seen.look(camera(0.1, 0.1), 0.9, 1.1)
    assert not seen.map.is_new_view(camera(0.2, 0.2, 0.1), 0.0)
    assert seen.map.is_new_view(camera(0.2, 0.2, 0.6), 0.0)
    assert seen.map.is_new_view(camera(0.6, 0.1), 0.0)


def test_a_question_that_is_like_many_pictures_is_believed_the_less():
    seen, believed = Seen(), []
    seen.look(camera(0, 0.1), 0.4, 1.1)
    for cosine in (0.4, 0.6):
        pictures = np.tile(np.float32([cosine, np.sqrt(1 - cosine**2)]), (8, 1))
        now = seen.now(belief=Belief(ASKED, fitted_weights()), pictures=pictures)
        believed.append(at(now, 1.1, 0.1))
    assert 0.0 < believed[1] < 0.9 * believed[0]


def test_more_places_are_a_room_than_a_thing():
    seen = Seen()
    seen.look(camera(0, 0.1), 0.4, 1.1)
    thing = at(seen.now(belief=Belief(ASKED, fitted_weights())), 1.1, 0.1)
    room = at(seen.now(belief=Belief(ASKED, fitted_weights(), room=True)), 1.1, 0.1)
    assert room > thing


def test_evidence_of_one_view_is_bounded():
    scores = np.array([[100.0, 50.0], [-100.0, -50.0]], np.float32)
    patches, ranges = np.array([[0, 0, 0], [1, 1, 1]]), np.float32([1.0, 1.0])
    found = features(scores, patches, ranges, np.ones(2, np.float32), tail=0.5)
    assert found.shape == (2, 20)
    assert evidence(found, ranges, WEIGHTS.near, WEIGHTS.far).tolist() == [MOST, LEAST]


def test_the_best_views_of_a_place_are_kept_in_order():
    views = PlaceViews()
    odds = np.float32([0.5, 2.0, -1.0, 1.0])
    places = np.tile(np.array([[7, -3]]), (4, 1))
    spots = np.array([0, 0, 1, 2])
    cameras = np.float32([[0, 0], [1, 0], [2, 0], [3, 0]])
    none, heights = np.zeros(4, np.float32), np.float32([0.1, 0.2, 0.3, 0.4])
    views.add(places, odds, none, np.full(4, 1.0, np.float32), spots, cameras, heights)
    assert views.seen_from[0, 0].tolist() == [1, 0], "where the best view was taken"
    near, top, mean, spots_told, *_ = views.features(room=False)[0, 0]
    assert (near, top, mean) == pytest.approx((1.0, (2.0 + 1.0 + 0.5) / 3, 2.5 / 4))
    assert spots_told == pytest.approx(np.log1p(3)) and views.low.tolist() == [7, -3]
    afar = np.float32([5.0]), spots[:1], np.float32([[9, 9]]), np.float32([1.5])
    views.add(np.array([[6, -2]]), odds[:1], odds[:1], *afar)
    views.add(np.array([[7, -3]]), np.float32([5.0]), odds[:1], *afar)
    assert views.shape == (2, 2) and views.features(room=False)[0, 1, 1] == pytest.approx(3.5 / 3)
    assert views.seen[1, 0] and not views.seen[0, 0]
    assert views.seen_from[1, 0].tolist() == [9, 9]
    assert views.heights[[0, 1], [1, 0]] == pytest.approx([0.2, 1.5]), "of the best views"
    assert views.seen_from[0, 1].tolist() == [1, 0], "views from near count before those from afar"


def test_before_anything_was_seen_nothing_is_believed():
    believed = Seen().now()
    assert believed.probabilities.shape == believed.seen.shape == (0, 0)


def test_places_refer_to_the_elements_of_a_large_map():
    places = PlaceMap(D435I_COLOUR)
    places.add(MappedFrame(0, 0, np.eye(4), 0.0), camera(0, 0), shown(1.0, 2.0), 1_000_000)
    assert (places.rows.elements == 1_000_000).all()


def test_a_view_that_showed_no_place_is_still_to_be_taken():
    places = PlaceMap(D435I_COLOUR)
    places.add(MappedFrame(0, 0, np.eye(4), 0.0), camera(0, 0), Footprint.nothing(), 0)
    assert places.is_new_view(camera(0, 0), 1.0)
    places.add(MappedFrame(1, 0, np.eye(4), 1.0), camera(0, 0), shown(1.0), 0)
    assert not places.is_new_view(camera(0, 0), 1.0 + LATER - 1.0)
    assert places.is_new_view(camera(0, 0), 1.0 + LATER)


def test_a_place_is_believed_less_where_it_is_more_probably_another_room():
    kitchen, bathroom = np.float32([1.0, 0.0]), np.float32([0.0, 1.0])
    believed = []
    for likeness, rivals in ((0.9, ()), (0.9, (bathroom,)), (0.6, ()), (0.6, (bathroom,))):
        seen = Seen()
        seen.look(camera(0, 0.1), likeness, 1.1)
        belief = Belief(Query(kitchen, (10.0, -5.0), rivals), WEIGHTS)
        believed.append(at(seen.now(belief=belief), 1.1, 0.1))
    assert believed[1] == believed[0], "it is the likelier one"
    assert 0.0 < believed[3] < 0.8 * believed[2]
