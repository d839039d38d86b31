"""Episodes in one room, with an encoder that knows the truth so that they are short."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.episodes import run as runs
from benchmarks.episodes.calibration_error import EXACT
from benchmarks.episodes.episode import Episode, Variant
from sim_stubs.realsense import camera as realsense
from sim_stubs.realsense.config import DepthNoiseConfig
from sim_stubs.roomba.serial_line import BytesLostError
from sim_stubs.scoring.success import Verdict
from tests.helpers.failing import raising
from tests.test_benchmarks.episodes.one_room import kitchen_with_far_sofa, true_encoder
from vizbot.core.errors import ConfigError, DeviceError, VizbotError
from vizbot.core.observer import GoalReport, Outcome


@pytest.fixture(autouse=True)
def small_home(monkeypatch):
    def opened(episode, config, error=EXACT):
        return error.world(kitchen_with_far_sofa(), config, episode.number)

    monkeypatch.setattr(runs, "open_episode", opened)


def test_an_encoder_whose_cosines_lie_elsewhere_in_the_same_order_drives_the_same_path():
    config = true_encoder(40).config
    own, scaled = (
        runs.run_episode((Variant("row", config, encoder_scale=scale), Episode(1000, ("sofa",))))
        for scale in (None, "clip")
    )
    assert len(own.track) > 3
    assert (own.track, own.stop) == (scaled.track, scaled.stop)
    assert own.goals[0] == scaled.goals[0]


def test_an_episode_tells_what_became_of_its_goal():
    result = runs.run_episode((true_encoder(40), Episode(1000, ("sofa",))))
    [goal] = result.goals
    assert result.success and goal.claimed and goal.reason == ""
    assert "from near by" in goal.answer
    assert goal.distance < 2.0
    assert 2 < goal.steps <= 40
    assert goal.shortest_path == pytest.approx(0.4, abs=0.25)
    x, y, _ = result.stop
    straight = np.hypot(x - 1.2, y - 2.0)
    assert straight - 0.02 < goal.path_length < 1.25 * straight
    assert result.track[0] == (1.2, 2.0)
    assert result.ate < 0.05
    assert result.collisions == 0


def test_the_next_goal_is_told_only_when_the_last_one_succeeded(monkeypatch):
    def arrived(pipeline, devices, goals, max_steps):
        return [GoalReport(goal.text, Outcome.ARRIVED, "seen", ()) for goal in goals]

    monkeypatch.setattr(runs, "drive_to_all", arrived)
    result = runs.run_episode((true_encoder(40), Episode(1000, ("kitchen", "bed", "sofa"))))
    assert [goal.text for goal in result.goals] == ["kitchen", "bed"]
    assert result.reached == 1 and not result.success
    assert result.goals[1].claimed
    assert result.goals[1].reason == "no bed in this world"
    assert result.goals[1].shortest_path is None
    assert result.ate is None


def test_the_next_goal_is_the_first_one_far_from_where_the_robot_then_stands(monkeypatch):
    asked, ways = [], {"bed": 1.0, "tv": None, "sofa": 3.1, "kitchen": 9.0}

    def way(world, text):
        asked.append((text, round(float(world.T_world_base[0, 3]), 1)))
        return ways[text]

    def arrived(pipeline, devices, goals, max_steps):
        world = devices.camera._world
        world.place(float(world.T_world_base[0, 3]) + 0.2, 2.0, 0.0)
        return [GoalReport(goal.text, Outcome.ARRIVED, "seen", ()) for goal in goals]

    monkeypatch.setattr(runs, "drive_to_all", arrived)
    monkeypatch.setattr(runs, "nearest_path_length", way)
    monkeypatch.setattr(runs, "judge", lambda *_, **__: Verdict(True, 0.5, True, ""))
    goals = ("kitchen", "bed", "tv", "sofa")
    result = runs.run_episode((true_encoder(40), Episode(1000, goals, choose=3)))
    assert [goal.text for goal in result.goals] == ["kitchen", "sofa"]
    assert not result.success  # two were wanted after the first, and only one is far
    assert asked[:5] == [
        ("kitchen", 1.2), ("bed", 1.4), ("tv", 1.4), ("sofa", 1.4), ("sofa", 1.4)
    ]  # fmt: skip
    assert [text for text, _ in asked[5:]] == ["bed", "tv"]
    assert runs.run_episode((true_encoder(40), Episode(1000, goals, choose=2))).success


def test_a_robot_that_gives_up_at_its_goal_has_not_arrived(monkeypatch):
    def gave_up(pipeline, devices, goals, max_steps):
        return [GoalReport(goal.text, Outcome.GAVE_UP, "not found", ()) for goal in goals]

    monkeypatch.setattr(runs, "drive_to_all", gave_up)
    result = runs.run_episode((true_encoder(40), Episode(1000, ("kitchen",))))
    [goal] = result.goals
    assert not goal.claimed and not goal.success and not result.success
    assert (goal.reason, goal.answer) == ("did not stop by itself", "not found")
    assert (goal.distance, goal.steps, goal.path_length) == (0.0, 0, 0.0)


def test_a_perfect_stop_ends_a_search_where_it_is_a_success(monkeypatch, mean_colours):
    monkeypatch.setattr(runs, "encoder_of", lambda config: mean_colours)
    row = replace(true_encoder(3), name="perfect stop", oracle="stop")
    [goal] = runs.run_episode((row, Episode(1000, ("kitchen",)))).goals
    assert goal.success and goal.claimed and goal.steps == 1
    assert goal.answer == "a stop here is a success"


def test_an_episode_is_the_same_twice_and_another_number_is_not():
    def error(number):
        return runs.run_episode((true_encoder(5), Episode(1000, ("sofa",), number))).ate

    assert error(0) == error(0) != error(1)


def test_an_error_costs_the_episode_and_is_told(monkeypatch):
    monkeypatch.setattr(runs, "drive_to_all", raising(DeviceError("the camera is gone")))
    [goal] = runs.run_episode((true_encoder(40), Episode(1000, ("sofa",)))).goals
    assert not goal.success and not goal.claimed
    assert goal.reason == "did not stop by itself"
    assert goal.answer == "error: DeviceError: the camera is gone"
    assert goal.stuck is False
    assert goal.distance > 2.0


@pytest.mark.parametrize("where", ["drive_to_all", "open_episode"])
def test_bytes_that_the_machine_lost_are_no_failure_of_the_robot(monkeypatch, where):
    lost, real = [], getattr(runs, where)

    def spoilt_once(*arguments):
        if not lost:
            lost.append(1)
            raise BytesLostError("/dev/pts/2: bytes were lost on their way to the robot")
        return real(*arguments)

    job = true_encoder(2), Episode(1000, ("sofa",))
    undisturbed = runs.run_episode(job)
    monkeypatch.setattr(runs, where, spoilt_once)
    again = runs.run_episode(job)
    assert lost and replace(again, wall_seconds=0) == replace(undisturbed, wall_seconds=0)


LOST = BytesLostError("/dev/pts/2: bytes were lost on their way to the robot")


@pytest.mark.parametrize(
    ("where", "error", "said"),
    [
        ("drive_to_all", LOST, "run it again, what is finished is kept"),
        ("open_episode", DeviceError("cannot render"), "cannot render"),
    ],
)
def test_a_machine_that_always_loses_bytes_or_cannot_render_has_no_results(
    monkeypatch, where, error, said
):
    monkeypatch.setattr(runs, where, raising(error))
    with pytest.raises(VizbotError, match=said):
        runs.run_episode((true_encoder(2), Episode(1000, ("sofa",))))


def test_a_scorer_that_breaks_costs_the_goal_alone(monkeypatch):
    monkeypatch.setattr(runs, "judge", raising(IndexError("no such\ncell")))
    result = runs.run_episode((true_encoder(2), Episode(1000, ("sofa", "kitchen"))))
    [goal] = result.goals
    assert not result.success
    assert goal.answer == "error: IndexError: no such cell"
    assert result.track[0] == (1.2, 2.0)


def test_a_home_that_cannot_be_built_costs_its_episode(monkeypatch):
    monkeypatch.setattr(
        runs, "open_episode", raising(ConfigError("home 1000 has no start for 'sofa'"))
    )
    result = runs.run_episode((true_encoder(40), Episode(1000, ("sofa",))))
    assert not result.success and result.track == () and result.collisions == 0
    [goal] = result.goals
    assert goal.answer == "error: ConfigError: home 1000 has no start for 'sofa'"
    assert not goal.claimed and (goal.steps, goal.path_length, goal.simulated_seconds) == (0, 0, 0)
    assert goal.shortest_path is None and goal.distance is None


@pytest.mark.parametrize(("oracle", "noise"), [("depth", DepthNoiseConfig.none()),
                                                    (None, DepthNoiseConfig())])  # fmt: skip
def test_true_depth_is_the_camera_s(monkeypatch, mean_colours, oracle, noise):
    cameras = []

    class Camera(realsense.SimulatedRealSense):
        def __init__(self, world, clock, config):
            cameras.append(config.depth_noise)
            super().__init__(world, clock, config)

    monkeypatch.setattr(realsense, "SimulatedRealSense", Camera)
    monkeypatch.setattr(runs, "encoder_of", lambda config: mean_colours)
    row = replace(true_encoder(1), oracle=oracle)
    runs.run_episode((row, Episode(1000, ("sofa",))))
    assert cameras == [noise]
