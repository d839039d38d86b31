"""One tick after another on scripted devices: what the robot does with what it is told."""

from dataclasses import dataclass, field, replace
from types import SimpleNamespace

import numpy as np
import pytest

from drivers.roomba_config import RoombaConfig
from sim_stubs.clock import SimulatedClock
from vizbot.config import Config, SettlingConfig
from vizbot.core.diff_drive import rolled, wheel_speeds
from vizbot.core.errors import DeviceError, DeviceTimeoutError
from vizbot.core.geometry import camera_mount
from vizbot.core.observation import Outcome
from vizbot.core.types import (
    STOP,
    BaseMode,
    BaseState,
    Button,
    ImuSamples,
    Intrinsics,
    RGBDFrame,
    Tracking,
    Twist,
)
from vizbot.pipeline import Pipeline, Task
from vizbot.rig import Devices

CAMERA = Intrinsics(320, 240, 308.0, 308.0, 159.5, 119.5)
PERIOD = 0.21


@dataclass
class Wall:
    """A camera that always looks at a plain wall near by, so that only wheels tell the motion."""

    clock: SimulatedClock
    rgb: np.ndarray
    intrinsics: Intrinsics = CAMERA
    imu: ImuSamples = field(default_factory=ImuSamples.none)

    def read(self, timeout=1.0):
        self.clock.sleep(PERIOD)
        depth = np.full(self.rgb.shape[:2], 1.2, np.float32)
        return RGBDFrame(self.clock.now(), self.rgb, depth, CAMERA, self.imu)


@dataclass
class ScriptedBase:
    """A base that rolls as told and feels what `feels` says for each tick (by number, from 0)."""

    feels: dict[int, dict] = field(default_factory=dict)
    driven: list[Twist] = field(default_factory=list)
    T_odom_base: np.ndarray = field(default_factory=lambda: np.eye(4))
    mode: BaseMode = BaseMode.SAFE
    resumed_at: list[int] = field(default_factory=list)
    silent_reads: int = 0

    def drive(self, twist):
        self.driven.append(twist)
        left, right = wheel_speeds(twist, 0.235)
        self.T_odom_base = self.T_odom_base @ rolled(left * PERIOD, right * PERIOD, 0.235)

    def resume(self):
        self.resumed_at.append(len(self.driven))

    def read(self):
        if self.silent_reads > 0:
            self.silent_reads -= 1
            raise DeviceTimeoutError("no answer from the base")
        state = BaseState(
            0.0, self.T_odom_base, False, False, (False,) * 4, (False, False), 1.0, self.mode
        )
        return replace(state, **self.feels.get(len(self.driven), {}))


@pytest.fixture
def pipeline_on(mean_colours):
    def build(base, look_around=False, colour=(120, 110, 100), imu=None, resume_safe=False):
        clock = SimulatedClock()
        rgb = np.full((240, 320, 3), colour, np.uint8)
        config = Config.model_validate(
            {"objectnav": {"look_around": look_around}, "roomba": {"resume_safe": resume_safe}}
        )
        wall = Wall(clock, rgb, CAMERA, imu or ImuSamples.none())
        devices = Devices(clock, wall, base, camera_mount(0.6, 0.05, 0.15), False)
        return Pipeline(devices, mean_colours, config, [])

    return build


def ticks(pipeline, count, text="yellow chair"):
    goal = pipeline.goal(text)
    return [pipeline.tick(goal) for _ in range(count)]


def test_the_robot_first_turns_once_around(pipeline_on):
    base = ScriptedBase()
    steps = ticks(pipeline_on(base, look_around=True), 60)
    turning = [step.activity == "looking around" for step in steps]
    first_other = turning.index(False)
    assert not any(turning[first_other:])
    turned = sum(twist.angular for twist in base.driven[:first_other]) * PERIOD
    assert 2 * np.pi - 0.1 < turned < 2 * np.pi + 0.6  # it brakes when it has been around


def test_with_a_gyroscope_the_robot_stands_still_first(pipeline_on):
    samples = ImuSamples(np.array([0.2, 0.205]), np.zeros((2, 3)), np.zeros(0), np.zeros((0, 3)))
    base = ScriptedBase()
    steps = ticks(pipeline_on(base, look_around=True, imu=samples), 14)
    standing = [step.activity.startswith("standing still") for step in steps]
    count = sum(standing)
    assert count == np.ceil(SettlingConfig().seconds / PERIOD) and all(standing[:count])
    assert all(twist == STOP for twist in base.driven[:count])
    assert base.driven[-1].angular > 0.0


def test_a_robot_that_is_lifted_does_not_know_where_it_is(pipeline_on):
    hangs = {"wheel_drops": (True, True)}
    base = ScriptedBase(feels={3: hangs, 4: {"wheel_drops": (True, False)}})
    steps = ticks(pipeline_on(base), 5)
    states = [step.estimate.tracking for step in steps]
    assert Tracking.LOST not in states[:3]
    assert states[3] is Tracking.LOST
    assert base.driven[3:] == [STOP, STOP]


def test_a_bump_makes_it_stop_back_off_mark_the_place_and_go_on(pipeline_on):
    base = ScriptedBase(feels={2: {"bump_left": True, "bump_right": True}})
    steps = ticks(pipeline_on(base), 12)
    backing = [step.activity == "backing off after a bump" for step in steps]
    assert backing.index(True) == 2
    assert base.driven[2] == STOP
    back = [twist.linear for twist, b in zip(base.driven, backing, strict=True) if b][1:]
    assert back and all(speed <= 0.0 for speed in back)
    assert -0.25 < sum(back) * PERIOD < -0.05
    assert not backing[-1]
    touched = (steps[2].T_map_base @ [0.2, 0.0, 0.0, 1.0])[:2]
    grid = steps[-1].grid
    assert grid.occupancy[tuple(grid.to_cells(touched))] == 1.0


@pytest.mark.parametrize("felt", [{"virtual_wall": True}, {"overcurrents": (True, False)}])
def test_a_virtual_wall_and_a_stuck_wheel_are_backed_off_from_as_well(pipeline_on, felt):
    base = ScriptedBase(feels={2: felt})
    steps = ticks(pipeline_on(base), 12)
    backing = [step.activity == "backing off after a bump" for step in steps]
    assert backing.index(True) == 2 and not backing[-1]
    assert min(twist.linear for twist in base.driven) < -0.05
    ahead = (steps[2].T_map_base @ [0.2, 0.0, 0.0, 1.0])[:2]
    grid = steps[-1].grid
    assert grid.occupancy[tuple(grid.to_cells(ahead))] == 1.0


def test_a_step_along_a_path_takes_several_frames_of_which_one_is_embedded(pipeline_on):
    base = ScriptedBase()
    pipeline = pipeline_on(base)
    for _ in range(40):
        before = base.T_odom_base
        pipeline.tick(Task.EXPLORE)
        assert np.linalg.norm((base.T_odom_base - before)[:2, 3]) <= 0.25
    assert pipeline.steps == 40
    frames = len(base.driven)
    assert frames > pipeline.steps
    pipeline.finish()
    assert len(np.unique(pipeline.bundle().elements.frames)) <= pipeline.steps < frames


def test_a_wheel_drop_ends_the_search_with_the_wheels_stopped(pipeline_on):
    base = ScriptedBase(feels={3: {"wheel_drops": (False, True)}})
    last = ticks(pipeline_on(base), 4)[-1]
    assert last.ended is not None and last.ended[0] is Outcome.GAVE_UP
    assert base.driven[-1] == STOP


def test_where_a_person_allows_it_a_robot_that_was_lifted_goes_on_once_it_is_put_down(pipeline_on):
    hangs = {"wheel_drops": (True, True), "mode": BaseMode.PASSIVE}
    base = ScriptedBase(feels={2: hangs, 3: hangs, 4: {"mode": BaseMode.PASSIVE}})
    pipeline = pipeline_on(base, resume_safe=True)
    steps = ticks(pipeline, 7)
    assert [step.activity for step in steps[2:5]] == ["waiting to be put down"] * 3
    assert all(step.ended is None for step in steps)
    assert base.driven[2:5] == [STOP] * 3
    assert "waiting" not in steps[6].activity


def test_who_presses_clean_on_a_lifted_robot_ends_the_search(pipeline_on):
    pressed = {"wheel_drops": (True, True), "buttons": frozenset({Button.CLEAN})}
    pipeline = pipeline_on(ScriptedBase(feels={2: pressed}), resume_safe=True)
    assert "Clean" in ticks(pipeline, 3)[-1].ended[1]


def test_a_robot_that_does_not_obey_since_it_was_lifted_says_so(pipeline_on):
    passive = {"mode": BaseMode.PASSIVE}
    feels = dict.fromkeys(range(1000), passive) | {0: passive | {"wheel_drops": (True, True)}}
    pipeline = pipeline_on(ScriptedBase(feels=feels), resume_safe=True)
    last = next(step for step in (pipeline.tick(Task.EXPLORE) for _ in range(400)) if step.ended)
    assert "does not obey since it was lifted" in last.ended[1]


def test_a_robot_that_nobody_puts_down_gives_up(pipeline_on):
    hangs = {"wheel_drops": (True, True), "mode": BaseMode.PASSIVE}
    pipeline = pipeline_on(ScriptedBase(feels=dict.fromkeys(range(1000), hangs)), resume_safe=True)
    last = next(step for step in (pipeline.tick(Task.EXPLORE) for _ in range(400)) if step.ended)
    assert last.ended[0] is Outcome.GAVE_UP
    assert last.frame.stamp == pytest.approx(60.0, abs=2.0)


def test_a_battery_that_is_nearly_empty_ends_the_search(pipeline_on):
    base = ScriptedBase(feels={3: {"battery": 0.08}})
    step = ticks(pipeline_on(base), 4)[-1]
    assert step.ended == (Outcome.GAVE_UP, "the battery is at 8 %; put the robot on its dock")
    assert base.driven[-1] == STOP


def test_an_encoder_without_memory_costs_its_answers_and_not_the_run(pipeline_on, caplog):
    base = ScriptedBase()
    pipeline = pipeline_on(base, colour=(240, 220, 12))
    encoder = pipeline._encoder
    fails = SimpleNamespace(
        model_id=encoder.model_id,
        dimension=encoder.dimension,
        threshold=encoder.threshold,
        notice=None,
        embed_texts=encoder.embed_texts,
        embed_images=failing_at_first(encoder.embed_images, 4),
    )
    pipeline._encoder = fails
    steps = [pipeline.tick(Task.MAP) for _ in range(12)]
    pipeline.finish()
    assert len(steps[3].points) == 0
    assert len(steps[-1].points) > 0
    assert caplog.text.count("out of memory; going on without its answers") == 1
    assert caplog.text.count("the encoder works again") == 1


def failing_at_first(embed, times):
    left = [times]

    def embed_images(images):
        left[0] -= 1
        if left[0] >= 0:
            raise DeviceError("out of memory")
        return embed(images)

    return embed_images


def test_a_picture_that_is_burnt_out_is_not_mapped(pipeline_on):
    pipeline = pipeline_on(None, colour=(255, 254, 255))
    for _ in range(3):
        pipeline.tick(Task.MAP)
    pipeline.finish()
    assert len(pipeline.bundle().elements.keyframes) == 0


def test_without_a_base_commands_are_computed_all_the_same(pipeline_on):
    pipeline = pipeline_on(None, look_around=True)
    steps = ticks(pipeline, 4)
    assert {step.activity for step in steps} == {"looking around"}
    assert steps[-1].command.angular > 0.5
    assert pipeline.tick(Task.MAP).command is None


def test_a_base_that_falls_silent_is_waited_for_and_not_for_ever(pipeline_on):
    base = ScriptedBase()
    pipeline = pipeline_on(base)
    ticks(pipeline, 3)
    driven, base.silent_reads = len(base.driven), 20
    ticks(pipeline, 1)
    assert base.silent_reads == 0
    assert len(base.driven) == driven + 1
    base.silent_reads = 10_000
    with pytest.raises(DeviceTimeoutError, match="no answer"):
        ticks(pipeline, 1)
    waited = (10_000 - base.silent_reads) * PERIOD
    assert waited == pytest.approx(RoombaConfig().reconnect_timeout, abs=2 * PERIOD)


def test_who_presses_clean_on_the_base_ends_the_search(pipeline_on):
    base = ScriptedBase(feels={2: {"buttons": frozenset({Button.CLEAN})}})
    steps = ticks(pipeline_on(base), 3)
    assert [step.ended is None for step in steps] == [True, True, False]
    outcome, reason = steps[2].ended
    assert outcome is Outcome.GAVE_UP and "Clean" in reason
    assert base.driven[-1] == STOP


def test_it_backs_away_from_its_dock_before_it_does_anything_else(pipeline_on):
    base = ScriptedBase(feels={n: {"docked": True} for n in range(3)})
    steps = ticks(pipeline_on(base, look_around=True), 40)
    leaving = [step.activity == "leaving the dock" for step in steps]
    gone = leaving.index(False)
    assert gone > 3 and not any(leaving[gone:])
    assert steps[gone].T_map_base[0, 3] == pytest.approx(-0.5, abs=0.05)
    assert all(twist.angular == 0.0 for twist in base.driven[:gone])


def test_at_an_edge_it_stops_asks_the_base_to_go_on_backs_off_marks_the_edge_and_goes_on(
    pipeline_on,
):
    cliffs = (False, True, False, False)
    passive = {"cliffs": cliffs, "mode": BaseMode.PASSIVE}
    base = ScriptedBase(feels={2: passive, 3: {"cliffs": cliffs}, 4: {"cliffs": cliffs}})
    steps = ticks(pipeline_on(base), 14)
    assert base.resumed_at == [2]
    backing = [step.activity == "backing off after an edge" for step in steps]
    assert backing.index(True) == 2 and not backing[-1]
    assert base.driven[2] == STOP
    back = [twist for twist, b in zip(base.driven, backing, strict=True) if b]
    assert all(twist.linear <= 0.0 and twist.angular == 0.0 for twist in back)
    assert -0.25 < sum(twist.linear for twist in back) * PERIOD < -0.05
    assert all(step.ended is None for step in steps)
    felt = steps[2].T_map_base @ [0.2 * np.cos(0.26), 0.2 * np.sin(0.26), 0.0, 1.0]
    grid = steps[-1].grid
    assert grid.occupancy[tuple(grid.to_cells(felt[:2]))] == 1.0


def test_an_edge_that_cannot_be_left_ends_the_search(pipeline_on):
    at_edge = {"cliffs": (True, True, True, True), "mode": BaseMode.PASSIVE}
    base = ScriptedBase(feels=dict.fromkeys(range(3, 60), at_edge))
    steps = ticks(pipeline_on(base), 50)
    ended = [step.ended for step in steps if step.ended is not None]
    assert ended and ended[0][0] is Outcome.GAVE_UP and "edge" in ended[0][1]
    assert all(twist == STOP for twist in base.driven[3:])


def test_a_base_that_obeys_again_soon_does_not_end_the_search(pipeline_on):
    passive = {"mode": BaseMode.PASSIVE}
    base = ScriptedBase(feels={2: passive, 3: passive, 4: passive})
    steps = ticks(pipeline_on(base), 8)
    assert all(step.ended is None for step in steps)
    assert [step.activity for step in steps[2:5]] == ["waiting for the base to obey"] * 3
    assert base.driven[2:5] == [STOP] * 3


def test_a_base_that_does_not_drive_ends_the_search(pipeline_on):
    steps = ticks(pipeline_on(ScriptedBase(mode=BaseMode.PASSIVE)), 17)
    assert [step.ended is None for step in steps[:14]] == [True] * 14
    step = next(step for step in steps if step.ended is not None)
    outcome, reason = step.ended
    assert outcome is Outcome.GAVE_UP and "PASSIVE" in reason


def test_what_fills_the_view_is_found_confirmed_and_reported(pipeline_on):
    base = ScriptedBase()
    pipeline = pipeline_on(base, colour=(240, 220, 12))
    goal = pipeline.goal("yellow chair")
    activities = []
    for _ in range(80):
        step = pipeline.tick(goal)
        activities.append(step.activity)
        if step.ended is not None:
            break
    assert step.ended is not None and step.ended[0] is Outcome.ARRIVED
    assert "making sure" in activities
    assert base.driven[-1] == STOP
    report = pipeline.report(goal, *step.ended)
    answer = report.candidates[0]
    assert answer.similarity > goal.threshold
    assert f"{answer.similarity:.3f}" in report.reason
    assert np.linalg.norm(answer.position[:2] - step.T_map_base[:2, 3]) <= 1.5


def test_without_a_base_nothing_is_driven_and_the_map_can_be_asked(pipeline_on):
    pipeline = pipeline_on(None, colour=(240, 220, 12))
    for _ in range(3):
        assert pipeline.tick(Task.MAP).activity == "mapping"
    pipeline.finish()
    assert pipeline.look_up(pipeline.goal("yellow chair")).outcome is Outcome.LOCATED
    assert pipeline.look_up(pipeline.goal("blue chair")).outcome is Outcome.NOT_FOUND
