"""What pose estimation makes of a way that no image was believed on, once there is light again."""

from dataclasses import replace

import numpy as np
import pytest

from mapping.keyframes.anchors import Keyframes, KeyframeViews
from mapping.slam.config import SlamConfig
from mapping.slam.slam import Slam
from tests.helpers.box_room import CAMERA, T_BASE_CAM, dead_reckoning, errors, follow, lap, render
from vizbot.core.errors import MapError
from vizbot.core.geometry import invert, planar, yaw_of
from vizbot.core.types import SE3, ImuSamples, PoseEstimate, Tracking

pytestmark = pytest.mark.slow


def slipping(Ts_map_base: list[SE3], dark: range, slip: SE3) -> list[SE3]:
    """Wheels that are right in the light and tell of `slip` more with each frame in the dark."""
    Ts_odom_base = [Ts_map_base[0]]
    for i in range(1, len(Ts_map_base)):
        step = invert(Ts_map_base[i - 1]) @ Ts_map_base[i]
        Ts_odom_base.append(Ts_odom_base[-1] @ step @ (slip if i in dark else np.eye(4)))
    return Ts_odom_base


def turning(rate: float, stamp: float) -> ImuSamples:
    """What a gyroscope reads of a base that turns at a `rate` [rad/s] in the 0.2 s before."""
    stamps = stamp - np.arange(40)[::-1] / 200.0
    rates = np.tile(np.array([0.0, 0.0, rate]) @ T_BASE_CAM[:3, :3], (40, 1))
    return ImuSamples(stamps, rates, np.zeros(0), np.zeros((0, 3)))


@pytest.mark.parametrize("slip", [planar(0.06, 0, 0), planar(0, 0, 0.03)], ids=["2 m", "1.5 rad"])
def test_wheels_that_spun_in_the_dark_are_found_out_where_the_light_shows_a_known_place(
    slip: SE3,
) -> None:
    spins = range(99, 149)
    Ts_map_base = lap(100)[:99] * 3
    slam, estimates = follow(Ts_map_base, slipping(Ts_map_base, spins, slip), spins)
    off = errors(estimates, Ts_map_base)
    assert off[spins.stop - 1].max() > 1.4
    assert off[spins.stop + 40 :].max() < 0.05
    assert len(slam.keyframe_poses()) < 60, "no room is mapped twice"


@pytest.mark.parametrize(
    "turns",
    [
        pytest.param(0, id="straight"),
        pytest.param(60, id="turning at its end", marks=pytest.mark.long),
    ],
)
def test_the_next_of_two_rooms_that_look_the_same_is_not_taken_for_the_first(turns: int) -> None:
    room, T_room_next = [planar(0, -0.9, 0)] * 6 + lap(100)[:99], planar(3.0, 0, 0)
    corridor = [room[0] @ planar(0.05 * i, 0, 0) for i in range(60)]
    corridor += [room[0] @ planar(3.0, 0, 2 * np.pi * i / 60) for i in range(turns)]
    dark = range(len(room), len(room) + len(corridor))
    T_next = room[0] @ T_room_next @ invert(room[0])
    Ts_map_base = room + corridor + [T_next @ T for T in room]
    slam = Slam(CAMERA, T_BASE_CAM, SlamConfig())
    estimates = list[PoseEstimate]()
    for i, T_room_base in enumerate(room + corridor + room):
        frame = render(T_room_base, 0.2 * i, dark=i in dark)
        rate = yaw_of(invert(Ts_map_base[max(i - 1, 0)]) @ Ts_map_base[i]) / 0.2
        frame = replace(frame, imu=turning(rate, frame.stamp))
        estimates.append(slam.track(frame, Ts_map_base[i]))
    assert errors(estimates, Ts_map_base)[:, 0].max() < 0.1
    first = {e.keyframe for e in estimates[: dark.start]}
    assert first.isdisjoint(e.keyframe for e in estimates[dark.stop :])


def test_wheels_that_spun_are_found_out_later_if_the_light_shows_a_new_place_first() -> None:
    spins = range(99, 159)
    out = lap(100)[:99] + lap(100)[:60]
    turns = [out[-1] @ planar(0, 0, 0.1 * i) for i in range(80)]
    Ts_map_base = out + turns
    dark = range(spins.start, spins.stop + 15)
    Ts_odom_base = slipping(Ts_map_base, spins, planar(0.05, 0, 0))
    slam, estimates = follow(Ts_map_base, Ts_odom_base, dark)
    off = errors(estimates, Ts_map_base)
    assert off[dark.stop :, 0].max() > 1.4, "nobody can know at once"
    assert off[-5:].max() < 0.06
    Ts_final = slam.keyframe_poses()
    for i, estimate in enumerate(estimates):
        if estimate.is_keyframe and i not in dark:
            T_true = invert(Ts_map_base[0]) @ Ts_map_base[i] @ T_BASE_CAM
            assert np.linalg.norm((invert(T_true) @ Ts_final[estimate.keyframe])[:3, 3]) < 0.1, i


def test_what_was_mapped_in_the_dark_moves_once_the_robot_knows_its_place_again() -> None:
    Ts_map_base = lap(100)[:99] + lap(100)[:99] + lap(100)[:80]
    dark = range(115, 170)
    Ts_odom_base = dead_reckoning(Ts_map_base, scale=1.2, drift=0.15)
    slam, estimates = follow(Ts_map_base, Ts_odom_base, dark)
    online = errors(estimates, Ts_map_base)[:, 0]
    assert online[dark.stop - 1] > 0.3
    Ts_final = slam.keyframe_poses()
    off = [
        np.linalg.norm(
            (invert(Ts_map_base[0] @ T_BASE_CAM) @ Ts_map_base[i] @ T_BASE_CAM)[:3, 3]
            - (invert(T_BASE_CAM) @ Ts_final[e.keyframe] @ e.T_keyframe_cam)[:3, 3]
        )
        for i, e in enumerate(estimates)
    ]
    assert max(off[i] for i in dark) < 0.7 * online[dark].max()


def test_what_was_mapped_between_two_dark_ways_is_held_at_both_ends() -> None:
    Ts_map_base = [planar(0, 0, 0.1 * i) for i in range(75)]
    first, second = range(16, 26), range(45, 62)
    slam = Slam(CAMERA, T_BASE_CAM, SlamConfig())
    estimates = [
        slam.track(render(T, 0.2 * i, dark=i in first or i in second), T_odom_base)
        for i, (T, T_odom_base) in enumerate(
            zip(Ts_map_base, slipping(Ts_map_base, first, planar(0, 0, 0.02)), strict=True)
        )
    ]
    assert estimates[-1].tracking is Tracking.TRACKING
    online = errors(estimates, Ts_map_base)
    assert online[first.stop : second.start, 1].min() > 0.15
    final = [
        replace(e, T_map_cam=slam.keyframe_poses()[e.keyframe] @ e.T_keyframe_cam)
        for e in estimates
    ]
    off = errors(final, Ts_map_base)
    assert (off < 0.75 * online)[first.stop : second.start, 1].all()
    assert off[-5:].max() < 0.05


def test_in_the_dark_the_graph_does_not_grow_with_time() -> None:
    Ts_map_base = [lap(100)[i % 99] for i in range(250)]
    slam, estimates = follow(Ts_map_base, Ts_map_base, range(20, 250))
    assert estimates[-1].tracking is Tracking.WHEELS_ONLY
    assert len(slam.keyframe_poses()) < 20


def test_a_saved_map_that_shows_nothing_is_no_place() -> None:
    keyframes = Keyframes(np.zeros(1, np.int32), np.zeros(1), np.eye(4)[None])
    slam = Slam(CAMERA, T_BASE_CAM, SlamConfig())
    slam.start_in_map(keyframes, KeyframeViews.empty())
    for i in range(5):
        estimate = slam.track(render(lap(100)[40], 0.2 * i), planar(0, 0, 0))
        assert estimate.tracking is Tracking.LOST and not estimate.is_keyframe


def test_a_saved_map_without_keyframes_is_refused() -> None:
    nothing = Keyframes(np.zeros(0, np.int32), np.zeros(0), np.zeros((0, 4, 4)))
    with pytest.raises(MapError, match="no keyframe"):
        Slam(CAMERA, T_BASE_CAM, SlamConfig()).start_in_map(nothing, KeyframeViews.empty())


def test_before_the_first_frame_nothing_is_shown() -> None:
    assert Slam(CAMERA, T_BASE_CAM, SlamConfig()).features() == {}
