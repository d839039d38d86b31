"""What is shown on standard error while a run goes on."""

from dataclasses import replace

from tests.helpers.served import step
from vizbot.commands.progress import Progress
from vizbot.core.observer import GoalReport, Outcome


def test_steps_of_a_goal_are_counted_up_to_the_most_and_the_share_seen_is_told(capsys):
    with Progress(1000) as progress:
        for index in range(26):
            progress.on_step(replace(step(index), seen_share=0.25 if index else None))
        progress.on_goal(GoalReport("sofa", Outcome.GAVE_UP, "so it is", ()))
        progress.on_step(replace(step(50), seen_share=0.5))
        progress.on_step(replace(step(75), goal="", seen_share=0.5))
    first, later, _, again, mapping = capsys.readouterr().err.splitlines()
    assert first.startswith("step    1 of 1000  sofa: exploring") and "seen" not in first
    assert later.startswith("step   26 of 1000") and later.endswith("seen 25%")
    assert again.startswith("step    1 of 1000") and again.endswith("seen 50%")
    assert mapping == "frame   75  keyframe 0  exploring  seen 50%"


def test_what_a_step_does_is_told_with_why_in_one_clause(capsys):
    why = "little else is left to see; no place seen so far is worth a closer look"
    with Progress(1000) as progress:
        progress.on_step(replace(step(0), why=why))
    line = capsys.readouterr().err
    assert "sofa: exploring, since little else is left to see  probability 20%" in line
    assert "(enough: 30%)" in line and "worth" not in line
