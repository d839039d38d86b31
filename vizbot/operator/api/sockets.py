"""The WebSockets of the API: `/live` to watch the robot, `/drive` to drive it by hand."""

from __future__ import annotations

import asyncio
import json
from typing import Annotated

from fastapi import APIRouter, Query, WebSocket, WebSocketDisconnect
from pydantic import ValidationError
from starlette.concurrency import run_in_threadpool

from vizbot.core.types import Twist
from vizbot.operator.api.image_stream import NAMES, RATE, Pictures
from vizbot.operator.api.requests import DriveMessage
from vizbot.operator.api.state import SharedState
from vizbot.operator.session.session import SOMEBODY, OperatorSession

PicturesPerSecond = Annotated[float, Query(allow_inf_nan=False)]

STAMPS_EVERY = 0.05
"""Between two time stamps that are sent to whoever drives [s]."""
_STATE_EVERY = 0.2
"""Between two states that are sent to whoever watches [s]."""
_MOST_WATCHING = 20


def socket_router(session: OperatorSession, pictures: Pictures) -> APIRouter:
    """The WebSockets of a robot."""
    router = APIRouter()
    watching: set[WebSocket] = set()
    shared = SharedState(session)

    @router.websocket("/live")
    async def live(socket: WebSocket, images: str = "", rate: PicturesPerSecond = 5.0) -> None:
        """The state as text five times a second, and pictures as bytes.

        The first byte of a picture is its place in `colour, depth, map, likeness`, the rest JPEG.
        `images` names those that are wanted, separated by commas; `rate` is at most 10 a second.
        """
        await socket.accept()
        if len(watching) >= _MOST_WATCHING:
            await socket.close(1013, "too many are watching")
            return
        watching.add(socket)
        wanted = [name for name in NAMES if name in images.split(",")]
        sending = asyncio.gather(
            _send_state(socket, shared), _send_pictures(socket, pictures, wanted, rate)
        )
        try:
            while True:  # no message is expected; but the end of the connection is
                await socket.receive_text()
        except (WebSocketDisconnect, KeyError):
            pass
        finally:
            watching.discard(socket)
            sending.cancel()
            await asyncio.gather(sending, return_exceptions=True)

    @router.websocket("/drive")
    async def drive(socket: WebSocket, who: str = "somebody", over: bool = False) -> None:
        """Drive by hand while this connection lives; `over=true` takes over from somebody else.

        The robot sends `{"time": ...}` every 50 ms; each motion brings back the newest of these as
        `heard`. One that is older than 0.3 s, or comes after a later one, has no effect.
        `{"refused": NAME}` says that somebody else drives, null that the robot was stopped.
        `{"done": true}` gives the wheel back, and what was running goes on; where the connection
        just ends, the robot rests until it is asked to go on.
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
                text = await socket.receive_text()
                motion, given_back = _motion(text), _is_done(text)
                if motion is not None:
                    twist = Twist(motion.linear, motion.angular)
                    session.lease.accept(link, motion.sequence, motion.heard, twist)
            if not given_back:
                await asyncio.wait([sending])  # it ends with the reason for whoever drove
        except (WebSocketDisconnect, KeyError):
            pass
        finally:
            session.release_lease(link, given_back=given_back)
            sending.cancel()
            await asyncio.gather(sending, return_exceptions=True)

    return router


def _is_done(text: str) -> bool:
    try:
        return bool(json.loads(text) == {"done": True})
    except (ValueError, RecursionError):  # of nonsense, and of brackets in brackets in brackets
        return False


def _motion(text: str) -> DriveMessage | None:
    """A motion; None for anything else, which has no effect."""
    try:
        return DriveMessage.model_validate_json(text)
    except ValidationError:
        return None


async def _send_stamps(socket: WebSocket, session: OperatorSession, link: int) -> None:
    """Send the robot's time until this link may drive no more, then the reason."""
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
    """Send each picture once."""
    shown: int | None = None
    period = 1.0 / min(max(rate, 0.1), RATE)
    while wanted:
        newest = await run_in_threadpool(pictures.newest, wanted)
        if newest is not None and shown != newest[0]:
            shown = newest[0]
            for name, picture in zip(wanted, newest[1], strict=True):
                await socket.send_bytes(bytes([NAMES.index(name)]) + picture)
        await asyncio.sleep(period)
