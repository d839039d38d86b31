"""The robot's API: what people and their programs ask for, over HTTP and WebSockets.

`/` is the console for people; `/openapi.json` describes the API to programs.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import Sequence
from typing import Annotated

from fastapi import FastAPI, HTTPException, Query, Request, Response, WebSocket, WebSocketDisconnect
from pydantic import ValidationError
from starlette.concurrency import run_in_threadpool

from vizbot.core.errors import ConfigError
from vizbot.core.types import Feedback, Twist
from vizbot.objectnav.tasks import Task, Waypoint
from vizbot.operator.api.console_routes import console_router
from vizbot.operator.api.image_stream import NAMES, RATE, Pictures
from vizbot.operator.api.map_routes import map_router
from vizbot.operator.api.schemas import Doubt, Goals, Motion, Order, PlaceRequest
from vizbot.operator.api.sentence_routes import sentence_router
from vizbot.operator.api.state import SharedState, state_of
from vizbot.operator.session.live_map import LiveMap
from vizbot.operator.session.session import SOMEBODY, OperatorSession
from vizbot.operator.session.task_queue import TaskRequest
from vizbot.operator.voice.dialogue import Dialogue

Rate = Annotated[float, Query(allow_inf_nan=False)]

_DESCRIPTION = """Ask the robot, watch it, drive it, stop it.

Two WebSockets belong to it. `/live?images=colour,map&rate=5` sends the state as JSON text five
times a second, and the pictures that are named (colour, depth, map, similarity) up to ten times a
second: a byte that says which, then a JPEG.

`/drive?who=NAME` drives by hand for as long as the link lives. The robot sends `{"time": ...}`
every 50 ms. `{"sequence": 1, "heard": TIME, "linear": 0.1, "angular": 0.0}` moves it, with the
newest time that has come and a sequence that grows; what is older than 0.3 s has no effect, and
without another the robot stops. `{"refused": NAME}` says that somebody else drives (`over=true`
takes the wheel from them), and null in place of a name that the robot was stopped;
`{"done": true}` gives the wheel back.
"""
STAMPS_EVERY = 0.05
"""Whoever drives is sent our time so often [s]."""
_IN_TURN = Order()
_STATE_EVERY = 0.2
_MOST_LINKS = 20
"""Of people who watch."""
_BODY_WITHIN = 0.2
"""Who stops the robot is not waited for longer, to be named [s]."""


def build_app(
    session: OperatorSession, pictures: Pictures, live_map: LiveMap, sentences: Dialogue
) -> FastAPI:
    """The application.

    Args:
        session: Of the run.
        pictures: Likewise.
        live_map: Likewise.
        sentences: Likewise.
    """
    # The pages that FastAPI offers fetch scripts of others, who would then talk to the robot.
    app = FastAPI(
        title="vizbot",
        description=_DESCRIPTION,
        docs_url=None,
        redoc_url=None,
    )
    app.include_router(console_router())
    app.include_router(map_router(live_map))
    app.include_router(sentence_router(sentences))
    links: set[WebSocket] = set()
    shared = SharedState(session)

    @app.get("/state")
    def state() -> dict[str, object]:
        """What the robot does, where it is, what it feels, and what it was asked for."""
        return state_of(session)

    @app.post("/goals")
    def ask(goals: Goals) -> dict[str, list[int]]:
        """Ask for goals, literally in these words; a sentence goes to `/said`.

        Their numbers tell them apart in the state.
        """
        for text in goals.texts:
            if not text.isprintable():
                raise HTTPException(422, f"the goal {text!r} holds what is no text")
        return _asked(session, goals.texts, at_once=goals.at_once)

    @app.post("/explore")
    def explore(order: Order = _IN_TURN) -> dict[str, list[int]]:
        """Ask for an exploration, until nothing is left to see."""
        return _asked(session, [Task.EXPLORE], at_once=order.at_once)

    @app.post("/place")
    def drive_to(place: PlaceRequest) -> dict[str, list[int]]:
        """Ask it to drive to a place on the map, as near as there is room."""
        return _asked(session, [Waypoint(place.x, place.y)], at_once=place.at_once)

    @app.post("/come-back")
    def come_back(order: Order = _IN_TURN) -> dict[str, list[int]]:
        """Ask it to go back to where the run began."""
        return _asked(session, [Task.COME_BACK], at_once=order.at_once)

    @app.post("/dock")
    def dock(order: Order = _IN_TURN) -> dict[str, list[int]]:
        """Ask it to go to its dock and charge there."""
        return _asked(session, [Task.DOCK], at_once=order.at_once)

    @app.post("/doubt")
    def doubt(said: Doubt) -> dict[str, bool]:
        """Tell people, in the log and by the base's song, that a question waits for an answer."""
        session.show(Feedback.DOUBT)
        session.write("doubt", said.question)
        return {"shown": True}

    @app.post("/stop")
    async def stop(request: Request) -> dict[str, bool]:
        """Rest now; all that was asked for is called off. Works for everyone, at any time.

        `{"who": NAME}` tells others who did it; nothing that is sent along keeps it from working.
        """
        session.stopped.set()  # first of all; whose stop it is may come late
        try:  # it waits for no thread and for no body that does not come
            said = await asyncio.wait_for(request.json(), _BODY_WITHIN)
            who = str(said["who"])
        except Exception:
            who = SOMEBODY
        session.stop(who)
        return {"stopped": True}

    @app.post("/continue")
    def go_on() -> dict[str, bool]:
        """Do what is still to be done, after the link of somebody who drove was lost."""
        session.go_on()
        return {"asked": True}

    @app.post("/resume")
    def resume() -> dict[str, bool]:
        """Ask the base to obey again after an edge or after it was lifted; its wheels rest first.

        The state tells by the base's mode whether it does.
        """
        session.resume_base()
        session.write("resume", "somebody asked the base to obey again")
        return {"asked": True}

    @app.get("/pictures/{name}.jpg", response_class=Response)
    def picture(name: str) -> Response:
        """The newest picture: colour, depth, map, or similarity to what is asked for."""
        if name not in NAMES:
            raise HTTPException(404, f"no picture {name!r}; there are {', '.join(NAMES)}")
        newest = pictures.newest([name])
        if newest is None:
            raise HTTPException(503, "the robot has seen nothing yet; ask again")
        headers = {"Cache-Control": "no-store"}
        return Response(newest[1][0], media_type="image/jpeg", headers=headers)

    @app.websocket("/live")
    async def live(socket: WebSocket, images: str = "", rate: Rate = 5.0) -> None:
        """The state as text five times a second, and pictures as bytes.

        The first byte of a picture is its place in `colour, depth, map, similarity`, the rest JPEG.
        `images` names those that are wanted, separated by commas; `rate` is at most 10 a second.
        """
        await socket.accept()
        if len(links) >= _MOST_LINKS:
            await socket.close(1013, "too many are watching")
            return
        links.add(socket)
        wanted = [name for name in NAMES if name in images.split(",")]
        sending = asyncio.gather(
            _send_state(socket, shared), _send_pictures(socket, pictures, wanted, rate)
        )
        try:
            while True:  # nothing is expected; but the end of the link is
                await socket.receive_text()
        except (WebSocketDisconnect, KeyError):
            pass
        finally:
            links.discard(socket)
            sending.cancel()
            await asyncio.gather(sending, return_exceptions=True)

    @app.websocket("/drive")
    async def drive(socket: WebSocket, who: str = "somebody", over: bool = False) -> None:
        """Drive by hand while this link lives; `over=true` takes the wheel from somebody else.

        The robot sends `{"time": ...}` every 50 ms; each motion brings back the newest of these as
        `heard`. One that is older than 0.3 s, or comes after a later one, has no effect.
        `{"refused": NAME}` says that somebody else drives, null that the robot was stopped.
        `{"done": true}` gives the wheel back, and what was running goes on; where the link just
        ends, the robot rests until it is asked to go on.
        """
        await socket.accept()
        link = session.take_lease(who, over=over)
        if link is None:
            await socket.send_json({"refused": session.lease.holder or SOMEBODY})
            await socket.close(1008, "somebody else drives")
            return
        sending = asyncio.ensure_future(_send_stamps(socket, session, link))
        given_back = False
        try:
            while session.lease.holds(link) and not given_back:
                said = await socket.receive_text()
                motion, given_back = _motion(said), _is_done(said)
                if motion is not None:
                    twist = Twist(motion.linear, motion.angular)
                    session.lease.accept(link, motion.sequence, motion.heard, twist)
            if not given_back:
                await asyncio.wait([sending])  # who drove is told why it is over
        except (WebSocketDisconnect, KeyError):
            pass
        finally:
            session.release_lease(link, given_back=given_back)
            sending.cancel()
            await asyncio.gather(sending, return_exceptions=True)

    return app


def _asked(
    session: OperatorSession, requests: Sequence[TaskRequest], *, at_once: bool = False
) -> dict[str, list[int]]:
    try:
        tasks = session.ask(requests, at_once=at_once)
    except ConfigError as error:
        raise HTTPException(429, str(error)) from error
    return {"numbers": [task.number for task in tasks]}


def _is_done(text: str) -> bool:
    try:
        return bool(json.loads(text) == {"done": True})
    except (ValueError, RecursionError):  # of nonsense, and of brackets in brackets in brackets
        return False


def _motion(text: str) -> Motion | None:
    """A motion; None for anything else, which has no effect."""
    try:
        return Motion.model_validate_json(text)
    except ValidationError:
        return None


async def _send_stamps(socket: WebSocket, session: OperatorSession, link: int) -> None:
    """Our time, until the wheel is taken from this link."""
    while session.lease.holds(link):
        await socket.send_json({"time": session.lease.time()})
        await asyncio.sleep(STAMPS_EVERY)
    await socket.send_json({"refused": session.lease.holder})
    await socket.close(1008, "the wheel was taken over")


async def _send_state(socket: WebSocket, state: SharedState) -> None:
    while True:
        await socket.send_text(await run_in_threadpool(state.json))
        await asyncio.sleep(_STATE_EVERY)


async def _send_pictures(
    socket: WebSocket, pictures: Pictures, wanted: list[str], rate: float
) -> None:
    """Each picture once."""
    shown: int | None = None
    period = 1.0 / min(max(rate, 0.1), RATE)
    while wanted:
        newest = await run_in_threadpool(pictures.newest, wanted)
        if newest is not None and shown != newest[0]:
            shown = newest[0]
            for name, picture in zip(wanted, newest[1], strict=True):
                await socket.send_bytes(bytes([NAMES.index(name)]) + picture)
        await asyncio.sleep(period)
