"""What the robot drives backwards by itself, where it sees nothing, is limited in all."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from benchmarks.faults.minimal_robot import WheelPoses
from tests.helpers.scripted_robot import PERIOD, ScriptedBase, until_it_ends
from vizbot.behaviours.blind_motion import BlindMotion
from vizbot.core.geometry import camera_mount, planar
from vizbot.core.observer import Outcome
from vizbot.core.types import STOP, BaseMode, BaseState, Twist
from vizbot.objectnav.tasks import Decision, ShortMove, Task, Waypoint
from vizbot.perception.interfaces import PerceptionParts

BUMPED = {"bump_left": True, "bump_right": True}
WALL = {"virtual_wall": True}
STUCK = {"overcurrents": (True, False)}
FROZEN = {
    "bumper": BUMPED,
    "left bumper": {"bump_left": True},
    "virtual wall": WALL,
    "overcurrent": STUCK,
    "edge": {"cliffs": (False, True, True, False)},
    "edge in Passive": {"cliffs": (True,) * 4, "mode": BaseMode.PASSIVE},
    "dock": {"docked": True},
    "dock and bumper": {"docked": True} | BUMPED,
    "light bumper": {"light_bumpers": (True,) * 6},
    "wheel drop": {"wheel_drops": (True, True)},
    "charger": {"plugged_in": True},
    "nothing": {},
}
TASKS = {
    "a goal": None,
    "exploration": Task.EXPLORE,
    "coming back": Task.COME_BACK,
    "docking": Task.DOCK,
    "finding its place": Task.FIND_PLACE,
    "a place": Waypoint(0.6, 0.3),
    "a turn": ShortMove(turn=2.0),
    "a way": ShortMove(forward=1.0),
}
HOLD = 0.3


@dataclass
class FrozenBase(ScriptedBase):
    """A base whose sensors show one thing after another, and whose wheels may not turn."""

    felt: dict = None
    turns: bool = True

    def drive(self, twist):
        before = self.T_odom_base
        super().drive(twist)
        if not self.turns:
            self.T_odom_base = before

    def read(self):
        return replace(super().read(), **(self.felt or {}))


def spent(base, before, felt, budget):
    """Add a tick to the way [m] and time [s] backwards, and to the way ahead without a contact."""
    way, seconds, ahead = budget
    rolled = float((np.linalg.inv(before) @ base.T_odom_base)[0, 3])
    touches = felt.keys() & {"bump_left", "virtual_wall", "overcurrents", "cliffs"}
    ahead = 0.0 if touches else max(0.0, ahead + rolled)
    if ahead >= 0.15:
        return 0.0, 0.0, 0.0
    backwards = base.driven[-1].linear < 0.0
    return way + max(0.0, -rolled), seconds + backwards * PERIOD, ahead


def drive_while_frozen(pipeline, base, felt, tasks):
    """Do the tasks in turn while the sensors show one thing after another; sum up the wheels.

    Args:
        pipeline: On the base.
        base: A `FrozenBase`.
        felt: Names of what the sensors show, each with a number of ticks.
        tasks: Names of tasks; each is left when it ends, and after 15 ticks.
    """
    named = [pipeline.goal("yellow chair") if TASKS[t] is None else TASKS[t] for t in tasks]
    budget, asked, ticks, docked = (0.0, 0.0, 0.0), 0, 0, False
    for name, count in felt:
        base.felt = FROZEN[name]
        docked |= "dock" in name
        for _ in range(count):
            before = base.T_odom_base
            step = pipeline.tick(named[asked % len(named)])
            ticks += 1
            budget = spent(base, before, base.felt, budget)
            assert budget[0] <= 0.3 + docked * 0.6 + 1e-9
            assert budget[1] <= 5.0 + docked * 8.0 + 1e-9
            asked += step.ended is not None or ticks % 15 == 0


@pytest.mark.slow
@pytest.mark.sampled("nothing", "virtual wall", "overcurrent", "edge in Passive", "dock and bumper")
@pytest.mark.parametrize("name", FROZEN)
def test_no_behaviour_drives_far_backwards_while_the_sensors_are_frozen(pipeline_on, name):
    base = FrozenBase()
    drive_while_frozen(pipeline_on(base, resume_safe=True), base, [(name, 130)], list(TASKS))


def courses(examples):
    """A test of so many courses of frozen sensors and tasks."""

    @settings(max_examples=examples, suppress_health_check=[HealthCheck.function_scoped_fixture])
    @given(
        felt=st.lists(
            st.tuples(st.sampled_from(sorted(FROZEN)), st.integers(1, 60)), min_size=1, max_size=4
        ),
        tasks=st.lists(st.sampled_from(sorted(TASKS)), min_size=1, max_size=4),
        turns=st.booleans(),
        resume_safe=st.booleans(),
    )
    def test(pipeline_on, felt, tasks, turns, resume_safe):
        base = FrozenBase(turns=turns)
        drive_while_frozen(pipeline_on(base, resume_safe=resume_safe), base, felt, tasks)

    return test


test_nor_does_any_while_they_freeze_in_turn = courses(4)
test_nor_does_any_in_many_courses = pytest.mark.long(courses(300))


def frozen(pipeline_on, **sensors):
    """A base whose sensors show that, and the pipeline on it."""
    base = FrozenBase(**sensors)
    return base, pipeline_on(base)


def explore(pipeline, ticks):
    return [pipeline.tick(Task.EXPLORE) for _ in range(ticks)]


def backed_off(pipeline, base, felt, ticks=60):
    """How far the robot drives back while its sensors show that [m]."""
    base.felt, there = felt, base.T_odom_base
    explore(pipeline, ticks)
    return -float((np.linalg.inv(there) @ base.T_odom_base)[0, 3])


@pytest.mark.parametrize("felt", [BUMPED, WALL, STUCK], ids=["bumper", "wall", "overcurrent"])
def test_a_contact_that_lasts_ends_the_task_at_rest_and_every_later_one_at_once(pipeline_on, felt):
    base, pipeline = frozen(pipeline_on, felt=felt)
    last = until_it_ends(pipeline, Task.EXPLORE)[-1]
    outcome, reason = last.ended
    assert outcome is Outcome.GAVE_UP and "\n" not in reason
    assert "has not helped: 0.3 m in" in reason and "put it where its way ahead is free" in reason
    assert last.command == base.driven[-1] == STOP
    assert -base.T_odom_base[0, 3] == pytest.approx(0.3, abs=0.01)
    explore(pipeline, 40)
    assert -base.T_odom_base[0, 3] <= 0.3


@pytest.mark.slow
def test_wheels_that_do_not_count_are_given_five_seconds(pipeline_on):
    base, pipeline = frozen(pipeline_on, felt=BUMPED, turns=False)
    explore(pipeline, 200)
    backwards = sum(twist.linear < 0.0 for twist in base.driven) * PERIOD
    assert 4.0 < backwards <= 5.0


@pytest.mark.slow
def test_way_ahead_without_a_contact_gives_the_budget_back_and_less_does_not(pipeline_on):
    for ahead, again in ((0.14, False), (0.16, True)):
        base, pipeline = frozen(pipeline_on, felt=WALL)
        explore(pipeline, 60)
        base.felt = {}
        base.T_odom_base = base.T_odom_base @ planar(ahead, 0.0, 0.0)
        pipeline.tick(Task.MAP)  # somebody drives it by hand
        more = backed_off(pipeline, base, WALL)
        assert more == pytest.approx(0.3 if again else 0.0, abs=0.01)


@pytest.mark.slow
def test_much_way_ahead_is_not_saved_up(pipeline_on):
    base, pipeline = frozen(pipeline_on)
    pipeline.tick(Task.EXPLORE)
    for _ in range(10):
        base.T_odom_base = base.T_odom_base @ planar(0.5, 0.0, 0.0)
        pipeline.tick(Task.MAP)
    assert backed_off(pipeline, base, {"docked": True}, 80) == pytest.approx(0.6, abs=0.01)


@pytest.mark.slow
def test_way_ahead_along_a_contact_gives_nothing_back(pipeline_on):
    base, pipeline = frozen(pipeline_on, felt=WALL)
    explore(pipeline, 60)
    base.T_odom_base = base.T_odom_base @ planar(0.5, 0.0, 0.0)
    there = base.T_odom_base
    explore(pipeline, 60)
    np.testing.assert_allclose(base.T_odom_base, there, atol=0.01)


@pytest.mark.slow
def test_driving_backwards_by_hand_costs_nothing(pipeline_on):
    base, pipeline = frozen(pipeline_on)
    for _ in range(20):
        base.drive(Twist(-0.4, 0.0))
        pipeline.tick(Task.MAP)
    assert backed_off(pipeline, base, BUMPED) == pytest.approx(0.3, abs=0.01)


@pytest.mark.slow
def test_another_map_gives_nothing_back(pipeline_on):
    base, pipeline = frozen(pipeline_on, felt=BUMPED)
    explore(pipeline, 60)
    pipeline.begin_map(None)
    explore(pipeline, 60)
    assert -base.T_odom_base[0, 3] <= 0.3


class StandingPose(WheelPoses):
    """A pose that stands still, whatever the wheels do."""

    def track(self, frame, T_odom_base):
        return super().track(frame, np.eye(4))


def test_a_pose_that_stands_still_does_not_keep_the_robot_leaving_its_dock(pipeline_on):
    base, pipeline = frozen(pipeline_on, felt={"docked": True})
    pipeline._parts = PerceptionParts(slam=StandingPose(camera_mount(0.6, 0.05, 0.15)))
    steps = []
    for _ in range(60):
        steps.append(pipeline.tick(Task.EXPLORE))
        if base.T_odom_base[0, 3] < -0.1:
            base.felt = {}
    left = [step.activity for step in steps].index("leaving the dock")
    done = next(n for n in range(left, 60) if steps[n].activity != "leaving the dock")
    assert not any(step.activity == "leaving the dock" for step in steps[done:])
    assert -0.6 <= min(twist.linear for twist in base.driven) * PERIOD * (done - left) <= -0.5


def test_a_dock_that_does_not_let_go_ends_the_task_after_little_more_than_the_usual_way(
    pipeline_on,
):
    base, pipeline = frozen(pipeline_on, felt={"docked": True})
    steps = explore(pipeline, 80)
    ended = [step.ended for step in steps if step.ended is not None]
    assert "leaving the dock has not helped: 0.6 m" in ended[0][1]
    assert "put it off its dock" in ended[0][1]
    assert -base.T_odom_base[0, 3] == pytest.approx(0.6, abs=0.01)


@pytest.mark.parametrize("frames", [1, 4])
def test_few_frames_with_the_bit_of_the_dock_do_not_move_it_backwards(pipeline_on, frames):
    base, pipeline = frozen(pipeline_on, felt={"docked": True})
    explore(pipeline, frames)
    assert base.driven == [STOP] * frames
    base.felt = {}
    explore(pipeline, 20)
    assert all(twist.linear >= 0.0 for twist in base.driven)


def test_the_fifth_frame_in_a_row_with_the_bit_of_the_dock_moves_it(pipeline_on):
    base, pipeline = frozen(pipeline_on, felt={"docked": True})
    explore(pipeline, 5)
    assert base.driven[:4] == [STOP] * 4 and base.driven[4].linear < 0.0


@given(
    speed=st.floats(0.01, 0.5), period=st.floats(0.02, HOLD), turn=st.floats(-2.0, 2.0),
)  # fmt: skip
def test_no_speed_and_no_period_drives_beyond_the_budget(speed, period, turn):
    budget, now, T_odom_base = BlindMotion(0.5, HOLD), 0.0, np.eye(4)
    wanted = Decision(Twist(-speed, turn), "backing off")
    state = BaseState(0.0, T_odom_base, True, True, (False,) * 4, (False,) * 2, 1.0, BaseMode.SAFE)
    way = seconds = 0.0
    for _ in range(500):
        budget.observe(replace(state, T_odom_base=planar(-way, 0.0, 0.0)), now, by_hand=False)
        decision = budget.permit(wanted, now)
        way -= decision.twist.linear * period
        seconds += period * (decision.ended is None)
        now += period
        if decision.ended is not None:
            assert decision.twist == STOP
            break
        assert decision.twist.angular == pytest.approx(turn / speed * -decision.twist.linear)
    assert decision.ended is not None
    assert way <= 0.3 + 1e-9 and seconds <= 5.0 + 1e-9
    assert way > 0.25 or seconds > 4.0
