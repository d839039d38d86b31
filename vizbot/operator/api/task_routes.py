"""Routes of the API that queue tasks, call them off, and let the robot go on."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from typing import Any

from fastapi import APIRouter, HTTPException, Request

from vizbot.core.errors import ConfigError
from vizbot.core.types import Feedback
from vizbot.objectnav.tasks import Task, Waypoint
from vizbot.operator.api.answers import DoubtShown, RequestTaken, StopAnswer, TaskNumbers
from vizbot.operator.api.errors import WITH_BODY, error_responses
from vizbot.operator.api.requests import (
    CancelRequest,
    DoubtRequest,
    GoalsRequest,
    PlaceRequest,
    StopRequest,
    TaskOptions,
    VerdictRequest,
)
from vizbot.operator.session.session import SOMEBODY, OperatorSession
from vizbot.operator.session.task_queue import TaskRequest

_IN_TURN = TaskOptions()
_BY_SOMEBODY = CancelRequest()
_BODY_TIMEOUT = 0.2
"""A stop waits no longer than this for the name of the person [s]."""
_BODY = error_responses(*WITH_BODY)
_CHANGE = error_responses(409, *WITH_BODY)
_NUMBER = error_responses(409, 422)
_VERDICT = error_responses(409, 503, *WITH_BODY)
_STOP_BODY: dict[str, Any] = {
    "requestBody": {"content": {"application/json": {"schema": StopRequest.model_json_schema()}}}
}


def task_router(session: OperatorSession) -> APIRouter:
    """The routes that queue tasks."""
    router = APIRouter(tags=["tasks"])

    @router.post("/goals", summary="Queue goals", responses=_BODY)
    def ask(goals: GoalsRequest) -> TaskNumbers:
        """Queue goals, literally in these words; a sentence goes to `/said`.

        Their numbers identify them in the state.
        """
        for text in goals.texts:
            if not text.isprintable():
                raise HTTPException(422, f"the goal {text!r} holds characters that are no text")
        return _queued(session, goals.texts, at_once=goals.at_once)

    @router.post("/explore", summary="Queue an exploration", responses=_BODY)
    def explore(options: TaskOptions = _IN_TURN) -> TaskNumbers:
        """Queue an exploration, which lasts until nothing is left to see."""
        return _queued(session, [Task.EXPLORE], at_once=options.at_once)

    @router.post("/place", summary="Queue a place on the map", responses=_BODY)
    def drive_to(place: PlaceRequest) -> TaskNumbers:
        """Queue a drive to a place on the map, or as near to it as there is room."""
        return _queued(session, [Waypoint(place.x, place.y)], at_once=place.at_once)

    @router.post("/come-back", summary="Queue the way back", responses=_BODY)
    def come_back(options: TaskOptions = _IN_TURN) -> TaskNumbers:
        """Queue a drive to where the run began."""
        return _queued(session, [Task.COME_BACK], at_once=options.at_once)

    @router.post("/dock", summary="Queue charging", responses=_BODY)
    def dock(options: TaskOptions = _IN_TURN) -> TaskNumbers:
        """Queue a drive to the dock, where the base charges."""
        return _queued(session, [Task.DOCK], at_once=options.at_once)

    @router.delete("/tasks", summary="Forget what is over")
    def forget() -> RequestTaken:
        """Drop the tasks that are over from the state."""
        session.queue.forget_ended()
        return RequestTaken()

    @router.delete("/tasks/{number}", summary="Call off a task", responses=_CHANGE)
    def cancel(number: int, by: CancelRequest = _BY_SOMEBODY) -> RequestTaken:
        """Call off a task that runs or waits; the others stay."""
        session.cancel(number, by.who)
        return RequestTaken()

    @router.post("/tasks/{number}/next", summary="Do a task next", responses=_NUMBER)
    def do_next(number: int) -> RequestTaken:
        """Let a task that waits be the next one; the running one goes on."""
        session.do_next(number)
        return RequestTaken()

    @router.post("/tasks/{number}/again", summary="Ask again", responses=_NUMBER)
    def ask_again(number: int) -> TaskNumbers:
        """Queue once more what a task that is over was about."""
        return TaskNumbers(numbers=[task.number for task in session.ask_again(number)])

    @router.post("/verdict", summary="Say whether that is it", responses=_VERDICT)
    def judge(verdict: VerdictRequest) -> TaskNumbers:
        """Say whether what the robot has arrived at last is what it was asked for.

        Where it is not, that place is believed less and the search for the same words goes on at
        once, as the task whose number is the answer.
        """
        tasks = session.judge(confirmed=verdict.confirmed, who=verdict.who)
        return TaskNumbers(numbers=[task.number for task in tasks])

    @router.post(
        "/candidates/{number}/verdict", summary="Say whether to go there", responses=_VERDICT
    )
    def judge_candidate(number: int, verdict: VerdictRequest) -> RequestTaken:
        """Say whether to go to what the robot sees, and take it for the goal, or to keep looking.

        Where it is not the goal, that place is believed less, as after an arrival.
        """
        session.judge_candidate(number, confirmed=verdict.confirmed, who=verdict.who)
        return RequestTaken()

    @router.post("/doubt", summary="Show a question", responses=_BODY)
    def doubt(request: DoubtRequest) -> DoubtShown:
        """Show people, in the log and by the base's song, that a question waits for an answer."""
        session.robot.show(Feedback.DOUBT)
        session.log.write("doubt", request.question)
        return DoubtShown()

    @router.post("/continue", summary="Go on")
    def go_on() -> RequestTaken:
        """Do what is still queued, after the link of somebody who drove was lost.

        Says yes, too, to a `question` of the state.
        """
        session.go_on()
        return RequestTaken()

    @router.post("/resume", summary="Let the base drive again")
    def resume() -> RequestTaken:
        """Ask the base to obey again after an edge or after it was lifted; its wheels rest first.

        The base's mode in the state shows whether it does.
        """
        session.robot.resume_base()
        session.log.write("resume", "somebody asked the base to obey again")
        return RequestTaken()

    return router


def stop_router(session: OperatorSession) -> APIRouter:
    """The route that stops the robot; nobody needs a token for it."""
    router = APIRouter(tags=["tasks"])

    @router.post(
        "/stop", summary="Stop the robot", responses=error_responses(403), openapi_extra=_STOP_BODY
    )
    async def stop(request: Request) -> StopAnswer:
        """Stop now; all tasks are called off. Works for everyone, at any time.

        `{"who": NAME}` tells others who did it; nothing that is sent along keeps it from working.
        """
        session.stopped.set()  # first of all; whose stop it is may come late
        try:  # it waits for no thread and for no body that does not come
            body = await asyncio.wait_for(request.json(), _BODY_TIMEOUT)
            who = str(body["who"])
        except Exception:
            who = SOMEBODY
        session.stop(who)
        return StopAnswer()

    return router


def _queued(
    session: OperatorSession, requests: Sequence[TaskRequest], *, at_once: bool = False
) -> TaskNumbers:
    try:
        requests = [session.readable(request) for request in requests]
    except ConfigError as error:
        raise HTTPException(422, str(error)) from error
    try:
        tasks = session.ask(requests, at_once=at_once)
    except ConfigError as error:
        raise HTTPException(429, str(error)) from error
    return TaskNumbers(numbers=[task.number for task in tasks])
