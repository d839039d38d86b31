"""Answers that are pictures."""

from __future__ import annotations

from typing import Any

from fastapi import Response


def picture_answer(jpeg: bytes) -> Response:
    """An answer that no browser keeps: the next one may be another."""
    return Response(jpeg, media_type="image/jpeg", headers={"Cache-Control": "no-store"})


def picture_response(description: str) -> dict[str, Any]:
    """Document a picture as FastAPI takes it."""
    schema = {"schema": {"type": "string", "format": "binary"}}
    return {"description": description, "content": {"image/jpeg": schema}}
