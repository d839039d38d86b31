"""The errors that the API answers with: their models, their documentation, their exceptions."""

from __future__ import annotations

from typing import Any

from fastapi import Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from pydantic import ConfigDict

from vizbot.core.errors import ConfigError, MapError
from vizbot.core.settings import causes
from vizbot.operator.api.answers import AnswerModel


class Refusal(AnswerModel):
    """Why a request was refused."""

    detail: str
    """The reason, in one line."""


class InvalidField(AnswerModel):
    """A part of a request that does not fit."""

    model_config = ConfigDict(extra="allow")

    type: str
    """What kind of error it is, as pydantic names it."""
    loc: list[str | int]
    """Where it stands: `body` or `query`, then names and indices."""
    msg: str
    """The reason, in one line."""


class InvalidRequest(AnswerModel):
    """Why a request does not fit what it is documented to be."""

    detail: str | list[InvalidField]
    """The reason in one line, or every part that does not fit."""


_REASONS = {
    400: "The body ended before it was whole.",
    401: "The request gives no token, or a wrong one.",
    403: "The request comes from a page of another site, or under a foreign host name.",
    404: "There is no such thing.",
    409: "The robot cannot do that now; the reason says what to change.",
    413: "The body is too large.",
    422: "The request does not fit its model, is too long, or holds no sound that can be read.",
    429: "Too many requests come from this address, or too many things wait to be done or read.",
    503: "The robot is busy, ends, or has seen nothing yet; ask again.",
}
ANYWHERE = (401, 403, 429)
"""Every request may be refused so, except one to stop."""
WITH_BODY = (400, 413, 422)
"""A request with a body may be refused so."""


def error_responses(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """Document errors, by the HTTP status codes of a route, as FastAPI takes them."""
    return {
        status: {
            "description": _REASONS[status],
            "model": InvalidRequest if status == 422 else Refusal,
        }
        for status in sorted(statuses)
    }


def refuse_invalid(request: Request, error: Exception) -> JSONResponse:
    """Answer a request that does not fit, without what was sent: not all of that can be answered.

    JSON bodies may hold NaN, and surrogates that no encoding has.
    """
    assert isinstance(error, RequestValidationError)
    parts = [
        InvalidField(
            type=part["type"],
            loc=[each if isinstance(each, int) else encodable(each) for each in part["loc"]],
            msg=encodable(part["msg"]),
        )
        for part in causes(error.errors())
    ]
    return JSONResponse({"detail": [part.model_dump() for part in parts]}, 422)


def encodable(text: str) -> str:
    """The text with escapes in place of surrogates, which no encoding has."""
    return text.encode("utf-8", "backslashreplace").decode()


def refuse(request: Request, error: Exception) -> JSONResponse:
    """Answer what raised an error of vizbot: 409 where the client can correct it, else 503."""
    status = 409 if isinstance(error, ConfigError | MapError) else 503
    return JSONResponse({"detail": str(error)}, status)
