"""The routes of the console: the files of `page/`, which talk to the API from a browser."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from fastapi import APIRouter, Response

_PAGE = Path(__file__).parents[1] / "page"
_SCRIPTS = (path.relative_to(_PAGE).as_posix() for path in (_PAGE / "scripts").rglob("*.js"))
FILES = {
    "/": ("console.html", "text/html"),
    "/console.css": ("console.css", "text/css"),
    "/layout.css": ("layout.css", "text/css"),
    "/console.svg": ("console.svg", "image/svg+xml"),
    **{f"/{name}": (name, "text/javascript") for name in sorted(_SCRIPTS)},
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
    content = (_PAGE / name).read_bytes()
    return lambda: Response(content, media_type=media_type, headers=_HEADERS)
