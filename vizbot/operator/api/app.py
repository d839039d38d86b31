"""The robot's API: what people and their programs ask for, over HTTP and WebSockets.

`/` is the console for people; `/openapi.json` describes the API to programs.
"""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter, FastAPI, HTTPException, Response, Security
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from fastapi.security import APIKeyCookie, APIKeyQuery, HTTPBearer

from vizbot import __version__
from vizbot.core.errors import VizbotError
from vizbot.operator.api.answers import RobotState
from vizbot.operator.api.console_routes import console_router
from vizbot.operator.api.errors import ANYWHERE, error_responses, refuse, refuse_invalid
from vizbot.operator.api.image_stream import NAMES, Pictures, picture_answer, picture_response
from vizbot.operator.api.map_routes import map_router
from vizbot.operator.api.proof import Credentials, proof_router
from vizbot.operator.api.sentence_routes import sentence_router
from vizbot.operator.api.sockets import socket_router
from vizbot.operator.api.state import state_of
from vizbot.operator.api.task_routes import stop_router, task_router
from vizbot.operator.language.dialogue import Dialogue
from vizbot.operator.session.live_map import LiveMap
from vizbot.operator.session.session import OperatorSession
from vizbot.operator.voice.recordings import Recordings

_DESCRIPTION = """Ask the robot, watch it, drive it, stop it.

A robot that listens beyond its own machine wants its token with every request but `/stop`, in one
of three ways. A robot that listens on a loopback address alone wants none.

Two WebSockets belong to the API. `/live?images=colour,map&rate=5` sends the state as JSON text five
times a second, and the pictures that are named (colour, depth, map, likeness) up to ten times a
second: a byte that says which, then a JPEG.

`/drive?who=NAME` drives by hand for as long as the connection lives. The robot sends
`{"time": ...}` every 50 ms. `{"sequence": 1, "heard": TIME, "linear": 0.1, "angular": 0.0}` moves
it, with the newest time that has come and a sequence that grows; what is older than 0.3 s has no
effect, and without another the robot stops. `{"refused": NAME}` says that somebody else drives
(`over=true` takes the wheel from them), and null in place of a name that the robot was stopped;
`{"done": true}` gives the wheel back.
"""
_TAGS = [
    {"name": "state", "description": "What the robot does, where it is, and what it sees."},
    {"name": "tasks", "description": "What the robot is to do, one task after another."},
    {"name": "sentences", "description": "Tasks and questions in whole sentences."},
    {"name": "map", "description": "The map that the robot has now."},
    {"name": "saved maps", "description": "Maps under a name, and changes from one to another."},
]
_TOKEN_SCHEMES = (
    HTTPBearer(scheme_name="bearer", auto_error=False),
    APIKeyCookie(scheme_name="cookie", name="token", auto_error=False),
    APIKeyQuery(scheme_name="query", name="token", auto_error=False),
)
"""For the description alone: `Guard` asks for the token before a request comes this far."""


def build_app(
    session: OperatorSession,
    pictures: Pictures,
    live_map: LiveMap,
    dialogue: Dialogue,
    recordings: Recordings,
    credentials: Credentials,
) -> FastAPI:
    """The application of one run."""
    # The pages that FastAPI offers fetch scripts from elsewhere, which would talk to the robot.
    app = FastAPI(
        title="vizbot",
        version=__version__,
        description=_DESCRIPTION,
        openapi_tags=_TAGS,
        generate_unique_id_function=lambda route: route.name,
        openapi_url=None,  # served below
        docs_url=None,
        redoc_url=None,
    )
    app.add_exception_handler(RequestValidationError, refuse_invalid)
    app.add_exception_handler(VizbotError, refuse)
    app.include_router(console_router())
    for router in (
        _state_router(session, pictures),
        task_router(session),
        sentence_router(dialogue, recordings),
        map_router(live_map),
    ):
        app.include_router(
            router,
            dependencies=[Security(scheme) for scheme in _TOKEN_SCHEMES],
            responses=error_responses(*ANYWHERE),
        )
    app.include_router(stop_router(session))
    app.include_router(proof_router(credentials))
    app.include_router(socket_router(session, pictures))

    @app.get("/openapi.json", include_in_schema=False)
    def description() -> JSONResponse:
        """Describe the API to programs."""
        document = app.openapi()
        _remove_impossible_errors(document)
        return JSONResponse(document)

    return app


def build_stop_app(session: OperatorSession) -> FastAPI:
    """The application that only stops the robot."""
    app = FastAPI(openapi_url=None, docs_url=None, redoc_url=None)
    app.include_router(stop_router(session))
    return app


def _remove_impossible_errors(document: dict[str, Any]) -> None:
    """Take out the 422 that FastAPI adds for each parameter: any text will do as a name."""
    generated = {"HTTPValidationError", "ValidationError"}
    for operations in document["paths"].values():
        for operation in operations.values():
            answer = str(operation["responses"].get("422"))
            if any(f"/{name}'" in answer for name in generated):
                operation["responses"].pop("422", None)
    for name in generated:
        document["components"]["schemas"].pop(name, None)


def _state_router(session: OperatorSession, pictures: Pictures) -> APIRouter:
    router = APIRouter(tags=["state"])

    # A response of our own is not validated: people's programs ask for the state all the time.
    @router.get("/state", summary="Read the state", response_model=RobotState)
    def state() -> JSONResponse:
        """Read what the robot does, where it is, what it feels, and what it was asked for."""
        return JSONResponse(state_of(session))

    # Before the other pictures, whose route would take its name.
    @router.get(
        "/pictures/arrival.jpg",
        summary="Read the picture of the arrival",
        response_class=Response,
        responses={200: picture_response("What was found."), **error_responses(404)},
    )
    def arrival_picture() -> Response:
        """Read the picture of what the robot has arrived at last, with a box around it."""
        arrival = session.arrival
        if arrival is None:
            raise HTTPException(404, "the robot has not arrived, or does something else by now")
        if arrival.picture is None:
            raise HTTPException(404, arrival.no_picture)
        return picture_answer(arrival.picture)

    @router.get(
        "/candidates/{number}/picture.jpg",
        summary="Read the picture of a candidate",
        response_class=Response,
        responses={
            200: picture_response("The candidate that the robot approaches."),
            **error_responses(404, 409, 422, 503),
        },
    )
    def candidate_picture(number: int) -> Response:
        """Read the picture of the candidate that the robot approaches, with a box around it."""
        try:
            return picture_answer(session.candidate_picture(number))
        except LookupError as error:
            raise HTTPException(404, str(error)) from error

    @router.get(
        "/pictures/{name}.jpg",
        summary="Read a picture",
        response_class=Response,
        responses={200: picture_response("The newest picture."), **error_responses(404, 503)},
    )
    def picture(name: str) -> Response:
        """Read the newest picture: colour, depth, map, or likeness to what is asked for."""
        if name not in NAMES:
            raise HTTPException(404, f"no picture {name!r}; there are {', '.join(NAMES)}")
        newest = pictures.newest([name])
        if newest is None:
            raise HTTPException(503, "the robot has seen nothing yet; ask again")
        return picture_answer(newest[1][0])

    return router
