"""The routes of the console: the files of `page/`, which talk to the API from a browser."""

from __future__ import annotations

from collections.abc import Callable
from importlib.resources import files

from fastapi import APIRouter, Response

_SCRIPTS = (
    "button_rows",
    "connection",
    "console",
    "dom",
    "drive",
    "drive_input",
    "goal_form",
    "http",
    "map/gestures",
    "map/keep_out_zones",
    "map/overlay",
    "map/places",
    "map/projection",
    "map/rooms",
    "map/view",
    "map/zoom",
    "place_cards",
    "push_to_talk",
    "refresh",
    "saved_maps",
    "state_view",
    "suggestions",
    "task_list",
    "words",
)
FILES = {
    "/": ("console.html", "text/html"),
    "/console.css": ("console.css", "text/css"),
    "/layout.css": ("layout.css", "text/css"),
    "/console.svg": ("console.svg", "image/svg+xml"),
    **{f"/scripts/{name}.js": (f"scripts/{name}.js", "text/javascript") for name in _SCRIPTS},
}
"""Name and media type of each file by its path. The files hold no secret."""
_HEADERS = {
    "Content-Security-Policy": "default-src 'self'; img-src 'self' blob:;"
    " connect-src 'self' ws: wss:; base-uri 'none'; form-action 'self'; frame-ancestors 'none'",
    "Permissions-Policy": "microphone=(self)",
    "Cache-Control": "no-cache",
    "Referrer-Policy": "same-origin",
    "X-Content-Type-Options": "nosniff",
}


def console_router() -> APIRouter:
    """The routes of these files."""
    router = APIRouter(include_in_schema=False)
    for path, (name, media_type) in FILES.items():
        router.add_api_route(path, _answer(name, media_type), response_class=Response)
    return router


def _answer(name: str, media_type: str) -> Callable[[], Response]:
    content = files("vizbot.operator").joinpath("page", name).read_bytes()
    return lambda: Response(content, media_type=media_type, headers=_HEADERS)
