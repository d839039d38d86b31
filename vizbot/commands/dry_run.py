"""`vizbot dry-run`: the whole loop once, scored where the world is simulated."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from vizbot.commands.open_run import OpenRun, open_run
from vizbot.commands.options import DryRunOptions
from vizbot.commands.run_plan import DryRunPlan
from vizbot.core.observer import Outcome
from vizbot.core.program.interrupts import first_error, one_line
from vizbot.mission import advise, drive_to_all, watch
from vizbot.mission import explore as explore_all
from vizbot.objectnav.tasks import Task
from vizbot.operator.printing import echo
from vizbot.pipeline import Pipeline

if TYPE_CHECKING:
    from vizbot.commands.serve import ServedRun  # its module loads the console's server
    from vizbot.rehearsal.plan_process import PlanProcess


def run(plan: DryRunPlan, options: DryRunOptions, world: PlanProcess | None = None) -> bool:
    """Run once, write the run's folder, print the result.

    `world` is the plan of the simulated world, under way; None where it is not.

    Returns:
        Whether it succeeded: with no base, a recorded camera or `explore` by having come to its
        end, in a simulated world by the scorer's verdict, else by what the robot believes.

    Raises:
        VizbotError: a device is missing or gone, or the map or another file cannot be kept; what
            can be written is written first.
    """
    goals, choice = plan.goals, plan.devices
    score = not options.explore
    with open_run(plan.run, choice, serve=options.serve, score=score, world=world) as opened:
        claimed, failure = _to_the_end(opened.pipeline, lambda: _do_all(opened, goals, options))
        metrics, lost = opened.write(
            _metrics(opened, claimed, failure)
            | {
                "camera": choice.camera,
                "base": choice.base,
                "world": choice.world or None,
            }
        )
        _print(opened, metrics, options, failure)
    if (error := failure or lost) is not None:
        raise error
    return bool(metrics["success"])


def _do_all(opened: OpenRun, goals: Sequence[str], options: DryRunOptions) -> bool:
    """Whether every task is done, as far as the robot knows."""
    if opened.served is not None:
        return _serve(opened, opened.served, goals, options)
    return _explore_and_ask(opened, goals) if options.explore else _drive_or_watch(opened, goals)


def _drive_or_watch(opened: OpenRun, goals: Sequence[str]) -> bool:
    """Whether the robot believes that it has arrived everywhere, or a recording had frames."""
    pipeline, devices = opened.pipeline, opened.devices
    wanted = [pipeline.goal(goal) for goal in goals]
    max_steps = opened.config.objectnav.max_steps
    if devices.base is None:
        if devices.recorded:
            watch(pipeline, wanted)
        else:
            advise(pipeline, wanted, max_steps)
        return pipeline.steps > 0
    reports = drive_to_all(pipeline, devices, wanted, max_steps)
    return all(report.outcome is Outcome.ARRIVED for report in reports)


def _explore_and_ask(opened: OpenRun, goals: Sequence[str]) -> bool:
    """Whether nothing was left to see; then the map is asked for the goals all the same."""
    max_steps = opened.config.objectnav.max_exploration_steps
    outcome, reason = explore_all(opened.pipeline, opened.devices, max_steps)
    if outcome is not Outcome.EXPLORED:
        echo(f"the exploration did not finish: {reason}", err=True)
    _look_up_all(opened.pipeline, goals)
    return outcome is Outcome.EXPLORED


def _serve(
    opened: OpenRun, served: ServedRun, goals: Sequence[str], options: DryRunOptions
) -> bool:
    """Whether the robot believes that it has done all tasks, or a recording had frames."""
    drives = served.base is not None
    requests = [Task.EXPLORE] if options.explore else goals
    served.serve(
        opened.pipeline,
        options.service.service(),
        requests if drives else [],
        opened.config.objectnav,
    )
    if not drives:
        _look_up_all(opened.pipeline, goals)
        return opened.pipeline.steps > 0
    good = (Outcome.ARRIVED, Outcome.EXPLORED, Outcome.LOCATED)
    return all(task.outcome in good for task in served.session.queue.tasks())


def _look_up_all(pipeline: Pipeline, goals: Sequence[str]) -> None:
    """Look every goal up on the finished map."""
    pipeline.finish()
    for goal in goals:
        pipeline.look_up(pipeline.goal(goal))


def _to_the_end(pipeline: Pipeline, work: Callable[[], bool]) -> tuple[bool, BaseException | None]:
    """Whether the work succeeded, and what ended it early; its results until then are kept."""
    claimed = False

    def do() -> None:
        nonlocal claimed
        claimed = work()

    failure = first_error(do)
    if not isinstance(failure, KeyboardInterrupt):  # which waits for no encoder
        failure = failure or first_error(pipeline.finish)
    return claimed and failure is None, failure


def _metrics(opened: OpenRun, claimed: bool, failure: BaseException | None) -> dict[str, object]:
    success, clock, rehearsal = claimed, opened.devices.clock, opened.rehearsal
    scorer = None if rehearsal is None else rehearsal.scorer
    if scorer is not None:
        success = failure is None and all(verdict.success for verdict in scorer.verdicts)
    lockstep_world = rehearsal.world if rehearsal is not None and clock.simulated else None
    return {
        "success": success,
        "judged": scorer is not None,
        "claimed": claimed,
        "error": None if failure is None else _told(failure),
        "collisions": None if lockstep_world is None else lockstep_world.collisions,
        "simulated_seconds": None if lockstep_world is None else round(clock.now(), 3),
        **opened.totals(),
    }


def _told(failure: BaseException) -> str:
    return "interrupted" if isinstance(failure, KeyboardInterrupt) else one_line(failure)


def _print(
    opened: OpenRun,
    metrics: dict[str, object],
    options: DryRunOptions,
    failure: BaseException | None,
) -> None:
    if opened.notice:
        echo(opened.notice, err=True)
    scorer = None if opened.rehearsal is None else opened.rehearsal.scorer
    for verdict in () if scorer is None else scorer.verdicts:
        if not verdict.success:
            echo(f"the scorer says: {verdict.reason}", err=True)
    if options.as_json:
        echo(json.dumps(metrics))
    if failure is not None:
        what = "was mapped" if metrics["map"] is not None else "is left of the run"
        echo(f"what {what} until then is in {opened.folder}", err=True)
    elif not options.as_json:
        done = "processed" if opened.devices.base is None else "arrived"
        if options.serve:
            done = "ended"
        elif options.explore:
            done = "explored"
        said = done if metrics["success"] else "not done"
        echo(f"{said}: {opened.folder / 'report.html'}")
