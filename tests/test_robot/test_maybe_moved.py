"""A robot that somebody may have moved unheard asks, and finds its place before it drives on."""

from dataclasses import replace

import pytest

from tests.helpers.scripted_robot import ScriptedBase, ticks
from tests.helpers.watched_robot import first_step
from vizbot.behaviours.safety import MAYBE_MOVED
from vizbot.config import ObjectNavConfig
from vizbot.core.observer import Outcome
from vizbot.core.simulated_clock import SimulatedClock
from vizbot.core.types import STOP, BaseMode, Button, Tracking
from vizbot.mission import explore
from vizbot.objectnav.tasks import Task
from vizbot.operator.api.state import state_of
from vizbot.operator.language.dialogue import Dialogue
from vizbot.operator.language.language import load_language
from vizbot.operator.session.live_map import LiveMap
from vizbot.operator.session.session import OperatorSession
from vizbot.operator.session.task_loop import run_tasks
from vizbot.operator.session.twist_mux import TwistMux

HELD = {"mode": BaseMode.PASSIVE, "maybe_moved": True}


class HeldBase(ScriptedBase):
    """Somebody may have moved it from its fourth command on, until it is asked to obey again."""

    def read(self):
        held = len(self.driven) >= 4 and "resume" not in self.asked
        self.mode = BaseMode.PASSIVE if held else BaseMode.SAFE
        self.feels = {len(self.driven): HELD if held else {}}
        return super().read()


def test_it_rests_and_asks_and_is_lost_until_it_recognises_a_place(pipeline_on):
    base = HeldBase()
    pipeline = pipeline_on(base)
    held = ticks(pipeline, 8)[4:]
    assert {step.activity for step in held} == {"somebody may have moved me: go on?"}
    assert all(step.question is MAYBE_MOVED and step.ended is None for step in held)
    assert all(step.estimate.tracking is Tracking.LOST for step in held)
    assert base.driven[4:] == [STOP] * 4
    base.resume()
    after = ticks(pipeline, 1)[0]
    assert after.question is None
    assert after.activity == "lost, looking around"  # before it drives on
    assert base.driven[-1].linear == 0.0


@pytest.mark.parametrize("task", [Task.MAP, Task.EXPLORE, Task.DOCK, Task.COME_BACK])
def test_whatever_it_does_it_asks_first_and_does_not_take_the_base_back_itself(pipeline_on, task):
    base = HeldBase()
    pipeline = pipeline_on(base)
    ticks(pipeline, 4)
    assert pipeline.tick(task).question is MAYBE_MOVED
    assert base.asked == []


def test_the_clean_button_ends_the_task_of_a_robot_that_asks(pipeline_on):
    pressed = HELD | {"buttons": frozenset({Button.CLEAN})}
    step = ticks(pipeline_on(ScriptedBase(feels={0: pressed})), 1)[0]
    assert step.ended == (Outcome.GAVE_UP, "somebody pressed Clean on the base")


def test_where_nobody_can_be_asked_the_run_ends_at_rest_with_its_reason_in_a_line(pipeline_on):
    base = HeldBase()
    pipeline = pipeline_on(base)
    outcome, reason = explore(pipeline, pipeline._devices, 50)
    assert outcome is Outcome.GAVE_UP
    assert reason == MAYBE_MOVED.unanswered and "\n" not in reason
    assert base.driven[-1] == STOP


def test_where_people_can_be_asked_the_task_is_held_for_as_long_as_it_takes(pipeline_on):
    session, base, said = OperatorSession(), HeldBase(), []
    mux = TwistMux(base, session.lease, session.stopped)
    session.robot.resume_base = mux.resume

    class Person:
        """Says to go on once it was asked for many steps, and ends it when it has gone on."""

        def on_step(self, step):
            said.append(step.question)
            if said.count(MAYBE_MOVED) == 12 and step.question is not None:
                assert session.question is MAYBE_MOVED
                assert session.queue.current().outcome is None
                session.go_on()
            if len(said) > 20:
                session.closed.set()

        def on_goal(self, report):
            pass

    pipeline = pipeline_on(base, observers=[session, Person()])
    session.ask(["yellow chair"])
    run_tasks(pipeline, SimulatedClock(), mux, session, ObjectNavConfig(max_steps=10))
    assert said.count(MAYBE_MOVED) == 12
    assert base.asked == ["resume"]
    assert session.question is None
    assert any("somebody said to go on" in line.text for line in session.log.lines())


@pytest.mark.parametrize(
    ("code", "sentence", "resumes", "answer"),
    [
        ("en", "go on", True, "I see where I am, then I go on"),
        ("en", "yes", True, "I see where I am, then I go on"),
        ("en", "no", False, "then I stay where I am"),
        ("en", "what are you doing?", False, "somebody may have moved me: go on?"),
        ("de", "mach weiter", True, "Ich sehe nach, wo ich bin, dann mache ich weiter"),
        ("de", "was machst du?", False, "vielleicht hat mich jemand umgestellt: soll ich"),
    ],
)
def test_what_a_person_says_to_the_question_is_its_answer(code, sentence, resumes, answer):
    session, resumed = OperatorSession(), []
    session.robot.resume_base = lambda: resumed.append(True)
    session.ask(["sofa"])
    session.on_step(replace(first_step(), question=MAYBE_MOVED))
    assert state_of(session)["question"] == "somebody may have moved me: go on?"
    dialogue = Dialogue(session, LiveMap(session), language=load_language(code))
    [said] = dialogue.typed(sentence, "ann").said
    assert said.startswith(answer)
    assert resumed == [True] * resumes
    session.on_step(first_step())
    assert state_of(session)["question"] is None
    dialogue.typed("go on" if code == "en" else "mach weiter", "ann")
    assert resumed == [True] * resumes  # a base that obeys is not asked to
