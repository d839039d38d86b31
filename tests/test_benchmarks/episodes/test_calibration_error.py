"""The true robot of an episode differs from what it believes by just the drawn error."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks.episodes import run as runs
from benchmarks.episodes.calibration_error import EXACT, CalibrationError
from benchmarks.episodes.episode import Episode, Variant
from benchmarks.episodes.run import SeenFloor, TruthRecorder, run_episode
from sim_stubs.realsense.camera import SimulatedRealSense
from sim_stubs.world.world import World
from sim_stubs.world.world_plan import D435I_COLOUR
from tests.test_benchmarks.episodes.one_room import kitchen_with_far_sofa
from vizbot.config import Config
from vizbot.core.geometry import invert, planar, yaw_of
from vizbot.core.simulated_clock import SimulatedClock
from vizbot.pipeline import Pipeline
from vizbot.rehearsal.config import RehearsalConfig
from vizbot.rehearsal.rig import Rig

EPISODES = [Episode(home, (goal,), number)
            for home in (1100, 1101) for goal in ("sofa", "bed") for number in (0, 1)]  # fmt: skip
SOFA = EPISODES[0]


@pytest.fixture(scope="module")
def house():
    return kitchen_with_far_sofa()


@pytest.mark.parametrize("episode", EPISODES)
def test_sizes_are_what_a_calibration_leaves(episode):
    error = CalibrationError.drawn(episode)
    assert np.degrees(np.linalg.norm(error.rotation)) == pytest.approx(0.4)
    assert np.linalg.norm(error.offset) == pytest.approx(0.005)
    assert abs(error.wheel_base) == abs(error.wheel_scale) == 0.007
    assert abs(error.focal_length) == 0.005


def test_an_episode_has_the_same_error_twice_and_others_have_others():
    errors = [CalibrationError.drawn(episode) for episode in EPISODES]
    assert errors == [CalibrationError.drawn(episode) for episode in EPISODES]
    assert len(set(errors)) == len(EPISODES)
    later = replace(SOFA, goals=("sofa", "bed"))
    assert CalibrationError.drawn(later) == errors[0]  # the first goal alone decides
    many = [CalibrationError.drawn(Episode(home, ("tv",))) for home in range(40)]
    for name in ("wheel_base", "wheel_scale", "focal_length"):
        assert 8 < sum(getattr(error, name) > 0 for error in many) < 32
    for name in ("rotation", "offset"):
        directions = np.array([getattr(error, name) for error in many])
        middle = directions / np.linalg.norm(directions, axis=1)[:, None]
        assert np.linalg.norm(middle.mean(axis=0)) < 0.45


def test_the_world_differs_from_the_belief_by_the_error(house):
    config, error = Config(), CalibrationError.drawn(SOFA)
    believed = config.mount.T_base_cam
    with error.world(house, config, 3) as world:
        T = invert(believed) @ world.T_base_cam
        turned = Rotation.from_matrix(T[:3, :3]).as_rotvec()
        assert turned == pytest.approx(error.rotation, abs=1e-9)
        assert world.T_base_cam[:3, 3] - believed[:3, 3] == pytest.approx(error.offset)
        for name in ("fx", "fy"):
            ratio = getattr(world.intrinsics, name) / getattr(D435I_COLOUR, name)
            assert ratio == pytest.approx(1.0 + error.focal_length)
        with SimulatedRealSense(world, SimulatedClock(), RehearsalConfig().sim_camera) as camera:
            assert camera.intrinsics == camera.read().intrinsics == D435I_COLOUR


def test_a_robot_with_a_longer_lens_sees_things_larger(house):
    config = Config()
    long_lens = CalibrationError(focal_length=0.05)
    with EXACT.world(house, config, 3) as exact, long_lens.world(house, config, 3) as longer:
        sizes = [np.count_nonzero(world.segment() == 0) for world in (exact, longer)]
    assert sizes[1] / sizes[0] == pytest.approx(1.05**2, rel=0.02)


@pytest.mark.parametrize(
    ("error", "speeds", "ratio"),
    [
        (CalibrationError(wheel_scale=0.007), (0.2, 0.2), 1.007),
        (CalibrationError(wheel_base=0.007), (-0.1, 0.1), 1 / 1.007),
        (CalibrationError(wheel_scale=-0.007, wheel_base=0.007), (-0.1, 0.1), 0.993 / 1.007),
    ],
)
def test_wheels_roll_and_turn_as_far_as_the_error_says(house, error, speeds, ratio):
    body = {"wheel_scale_noise": 0.0, "slip_noise": 0.0}
    config = Config.model_validate({"world": body})
    moved = []
    for each in (EXACT, error):
        with each.world(house, config, 3) as world:
            start = world.T_world_base
            world.set_wheel_speeds(*speeds)
            world.advance(2.0)
            T = invert(start) @ world.T_world_base
            moved.append(yaw_of(T) if speeds[0] < 0 else T[0, 3])
    assert moved[1] / moved[0] == pytest.approx(ratio, abs=1e-6)


SETTINGS = {"max_steps": 45, "gyro_settling": {"seconds": 0.0, "frames": 0}}
ROW = Variant("default", Config.model_validate({"objectnav": SETTINGS}))
"""Every frame is a step of a robot that looks for what is not there."""


@pytest.fixture
def room(monkeypatch, mean_colours, house):
    """Episodes begin in the kitchen."""

    def opened(episode, config, error):
        return error.world(house, config, episode.home)

    monkeypatch.setattr(runs, "open_episode", opened)
    monkeypatch.setattr(runs, "encoder_of", lambda config: mean_colours)


def driven():
    return replace(run_episode((ROW, SOFA)), wall_seconds=0.0)


@pytest.fixture
def without_errors(monkeypatch):
    """Robots are just as they believe, and their computer answers at once."""
    monkeypatch.setattr(CalibrationError, "drawn", lambda episode: EXACT)
    monkeypatch.setattr(runs, "slow_devices", lambda devices, *_: devices)


def test_an_episode_without_errors_drives_as_a_robot_that_nothing_was_done_to(
    room, mean_colours, house, without_errors
):
    exact, config = driven(), ROW.config
    with (
        World(
            house, RehearsalConfig.read(config).world, config.mount.T_base_cam, SOFA.home
        ) as world,
        Rig(config, "sim", "sim", world) as rig,
    ):
        recorder = TruthRecorder(world, SeenFloor(world, config))
        pipeline = Pipeline(rig.devices, mean_colours, config, [recorder])
        goal = pipeline.goal("sofa")
        while pipeline.steps < 45:
            assert pipeline.tick(goal).ended is None
        assert recorder.trajectory_error() == exact.ate
        assert recorder.track()[:-1] == exact.track[: len(recorder.track()) - 1]
    assert len(exact.track) > 5
    assert exact.goals[0].steps == 45


def test_an_episode_with_errors_is_the_same_twice_and_another_than_without(room, request):
    first = driven()
    assert driven() == first
    request.getfixturevalue("without_errors")
    assert driven().track != first.track


def test_a_step_is_recorded_where_its_picture_was_taken(house):
    with EXACT.world(house, Config(), 3) as world:
        recorder = TruthRecorder(world, SeenFloor(world, Config()))
        world.render()
        pictured = world.T_world_base
        T_world_base = pictured @ planar(0.1, 0.0, 0.2)
        world.place(*T_world_base[:2, 3], yaw_of(T_world_base))
        assert np.array_equal(world.T_world_pictured, pictured)
        world.render()
        assert np.array_equal(world.T_world_pictured, world.T_world_base)
        assert recorder.path_length() == 0.0
