"""Which views of places count no longer."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mapping.clip.mapped_frames import MappedFrame
from mapping.clip.places.footprint import Footprint
from mapping.clip.places.place_rows import PlaceMap
from mapping.clip.places.view_age import LATER
from sim_stubs.world.world_plan import D435I_COLOUR
from tests.helpers.bundles import camera
from vizbot.core.geometry import invert, planar, transform

THING = np.array([0.1, 0.1, 0.0])


class Visited:
    """A map of a thing at `THING`, as high as the level camera."""

    def __init__(self):
        self.map = PlaceMap(D435I_COLOUR)

    def look(self, T_map_cam, time, point=THING, keyframe=0):
        points_cam = transform(invert(T_map_cam), np.asarray(point)[None]).astype(np.float32)
        shown = Footprint(points_cam, np.zeros((1, 3), np.int16), np.ones(1, np.float32))
        frame = MappedFrame(len(self.map.frames), keyframe, T_map_cam, time)
        self.map.add(frame, T_map_cam, shown, len(self.map))

    def outdated(self, poses=None):
        age = self.map.placed(poses or {0: np.eye(4)}).age
        return (age.retaken | age.doubted).tolist()


FROM_LEFT, FROM_FRONT = camera(-1.9, 0.1), camera(0.1, -1.9, np.pi / 2)


def visited(*looks):
    """Which count less after looks: where from, when and, where it is not the thing, at what."""
    home = Visited()
    for look in looks:
        home.look(*look)
    return home.outdated()


def test_two_later_looks_from_near_stand_for_what_was_seen_before():
    before, behind = (camera(2.1, 0.1, np.pi), 0.0), (camera(-3.4, 0.1), 1.0)
    looks = (FROM_LEFT, LATER + 1.0), (FROM_FRONT, LATER + 2.0)
    assert visited(before, behind, *looks) == [True, True, False, False]
    assert visited(before, behind, looks[0]) == [False, False, False]


def test_looks_soon_after_are_no_news():
    assert visited((camera(2.1, 0.1, np.pi), 0.0), (FROM_LEFT, 1.0), (FROM_FRONT, 2.0)) == [
        False,
        False,
        False,
    ]


def test_looks_from_afar_are_no_news():
    far = [(camera(-3.4, y, 0.0), LATER + y) for y in (1.1, 1.7, 2.3)]
    assert not any(visited((camera(2.1, 0.1, np.pi), 0.0), *far))


def test_what_is_out_of_the_picture_is_not_outdated():
    """Two looks at the foot of a shelf say nothing of what hangs above it."""
    high = (0.1, 0.1, 1.3)
    looks = (FROM_LEFT, LATER + 1.0), (FROM_FRONT, LATER + 2.0)
    assert visited((camera(2.6, 0.1, np.pi), 0.0, high), *looks) == [False, False, False]


def test_a_picture_gives_way_to_the_same_one_later():
    assert visited((camera(-3.4, 0.1), 0.0), (camera(-3.3, 0.2, 0.1), LATER)) == [True, False]
    assert visited((camera(-3.4, 0.1), 0.0), (camera(-3.3, 0.2, 0.1), LATER - 1)) == [False, False]


@given(st.integers(0, 2**32 - 1))
def test_after_a_loop_closure_the_same_is_outdated_as_in_a_map_made_anew(seed):
    rng = np.random.default_rng(seed)
    poses, home = {0: np.eye(4), 1: np.eye(4)}, Visited()
    for visit in range(2):
        for _ in range(12):
            x, y, yaw = rng.uniform(-1.5, 1.5, 3)
            home.look(camera(x, y, 2 * yaw), visit * 2 * LATER, rng.uniform(-1, 1, 3), visit)
            home.outdated(poses)
    poses = {0: np.eye(4), 1: planar(*rng.uniform(-0.4, 0.4, 3))}
    anew = PlaceMap(D435I_COLOUR, home.map.rows, home.map.frames).placed(poses)
    assert home.outdated(poses) == (anew.age.retaken | anew.age.doubted).tolist()
