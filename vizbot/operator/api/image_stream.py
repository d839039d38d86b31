"""JPEGs of what the robot sees and knows, drawn once for everybody who watches, and as answers."""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from fastapi import Response

from vizbot.core.observer import Step
from vizbot.operator.figures.image_encoding import jpeg
from vizbot.operator.figures.panels import LARGE, panel
from vizbot.operator.session.session import OperatorSession

NAMES = ("colour", "depth", "map", "likeness")
"""Names of the pictures; `likeness` is the heat map of the goal."""
RATE = 10.0
"""Steps a second that are drawn and sent at most."""


class Pictures:
    """Pictures of the newest step, or of one hardly older; safe to use from several threads."""

    def __init__(self, session: OperatorSession) -> None:
        self._session = session
        self._lock = threading.Lock()
        self._step: Step | None = None
        self._since = 0.0
        self._jpegs: dict[str, bytes] = {}

    def newest(self, names: Sequence[str]) -> tuple[int, list[bytes]] | None:
        """The index of a step and pictures of it as JPEG; None before the first step."""
        newest, now = self._session.newest_step(), time.monotonic()
        if newest is None:
            return None
        with self._lock:
            step = self._step
            if step is None or (step is not newest and now - self._since >= 1.0 / RATE):
                step = self._step = newest
                self._jpegs, self._since = {}, now
            for name in names:
                if name not in self._jpegs:
                    shown = self._with_scores(step) if name == "likeness" else step
                    turn = self._session.map_turn.turn_at(shown)
                    track = self._session.track()
                    self._jpegs[name] = jpeg(
                        panel("obstacle map" if name == "map" else name, shown, track, turn, LARGE)
                    )
            return step.index, [self._jpegs[name] for name in names]

    def _with_scores(self, step: Step) -> Step:
        """The step with the scores of the last search: the likeness stays until the next one."""
        scored = self._session.scored_step()
        if scored is None or step.scores is not None:
            return step
        return replace(
            step, scores=scored.scores, measure=scored.measure, threshold=scored.threshold
        )


def picture_answer(jpeg: bytes) -> Response:
    """An answer that no browser keeps: the next one may be another."""
    return Response(jpeg, media_type="image/jpeg", headers={"Cache-Control": "no-store"})


def picture_response(description: str) -> dict[str, Any]:
    """Document a picture as FastAPI takes it."""
    schema = {"schema": {"type": "string", "format": "binary"}}
    return {"description": description, "content": {"image/jpeg": schema}}
