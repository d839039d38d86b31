"""Questions to a recording, and the right places, which a person marked in its pictures."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field, ValidationError

from drivers.tum_sequence import RecordedSequence
from vizbot.core.errors import ConfigError
from vizbot.core.geometry import transform
from vizbot.core.settings import SETTINGS
from vizbot.core.types import SE3


class Mark(BaseModel):
    """A point that is on the thing, in one picture."""

    model_config = SETTINGS

    frame: int = Field(ge=0)
    """Number of the picture in the recording, from 0."""
    pixel: tuple[int, int]
    """Column and row [px]."""


class MarkedThing(BaseModel):
    """A question, and where an answer is right."""

    model_config = SETTINGS

    text: str = Field(min_length=1)
    """What is asked for."""
    marks: tuple[Mark, ...] = ()
    """Points on every such thing; none where there is no such thing."""
    radius: float = Field(default=0.75, gt=0.0)
    """How far from a marked point an answer is still right [m]."""


class _Questions(BaseModel):
    model_config = SETTINGS

    question: tuple[MarkedThing, ...] = Field(min_length=1)


def read_questions(path: Path) -> tuple[MarkedThing, ...]:
    """The questions of a TOML file.

    Raises:
        ConfigError: it cannot be read, or is no list of questions.
    """
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8-sig"))
        return _Questions.model_validate(content).question
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError, ValidationError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise ConfigError(
            f"questions {path} cannot be read: {reason}; give a TOML file of things and"
            " where they are"
        ) from error


def marked_points(
    camera: RecordedSequence, question: MarkedThing, Ts_world_cam: NDArray[np.float64]
) -> NDArray[np.float64]:
    """The marked points in `world` (M, 3) [m].

    Args:
        camera: The recording.
        question: The question.
        Ts_world_cam: True poses of all frames (F, 4, 4).

    Raises:
        ConfigError: a mark is outside of the recording, or nothing was measured there.
    """
    points = [_point(camera, question, mark, Ts_world_cam) for mark in question.marks]
    return np.array(points).reshape(-1, 3)


def _point(
    camera: RecordedSequence, question: MarkedThing, mark: Mark, Ts_world_cam: NDArray[np.float64]
) -> NDArray[np.float64]:
    where = f"question {question.text!r}: mark {mark.frame}, {mark.pixel}"
    if mark.frame >= len(Ts_world_cam):
        raise ConfigError(f"{where} is in none of the {len(Ts_world_cam)} frames")
    frame = camera.frame(mark.frame)
    u, v = mark.pixel
    height, width = frame.depth.shape
    if not (0 <= u < width and 0 <= v < height):
        raise ConfigError(f"{where} is outside of the picture of {width} x {height} pixels")
    depth = float(frame.depth[v, u])
    if depth <= 0.0:
        raise ConfigError(f"{where} has no depth; mark another pixel of it")
    ray = np.linalg.inv(frame.intrinsics.K) @ (u, v, 1.0)
    T_world_cam: SE3 = Ts_world_cam[mark.frame]
    return np.asarray(transform(T_world_cam, (depth * ray)[None])[0])
