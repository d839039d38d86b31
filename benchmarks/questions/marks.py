"""Places of things in a recording, as a person marked them in its pictures."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
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
    """Column and row in the picture as it was taken [px]."""


class MarkedThing(BaseModel):
    """A question, and where an answer is right."""

    model_config = SETTINGS

    text: str = Field(min_length=1)
    """What is asked for."""
    marks: tuple[Mark, ...] = ()
    """Points on every such thing; none where there is no such thing."""


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


MOST, LEAST = 0.75, 0.25
"""Bounds of how far from a marked point an answer is right [m]: the second is the edge of a place
of the map, so that a thing beside another one can be right at all."""


@dataclass(frozen=True, slots=True, eq=False)
class MarkedPlaces:
    """The places of a thing in a recording.

    Attributes:
        points: (M, 3) marked points in `world` [m]; none where there is no such thing.
        tolerances: (M,) how far from each an answer is right [m].
    """

    points: NDArray[np.float64]
    tolerances: NDArray[np.float64]

    def nearest(self, point: NDArray[np.float64]) -> tuple[float, float] | None:
        """Distance of a point (3,) from a mark, and what is right there [m]; None without marks.

        It is the mark with which the point is right, where there is one.
        """
        if len(self.points) == 0:
            return None
        away = np.linalg.norm(self.points - point, axis=1)
        chosen = int(np.argmin(away - self.tolerances))
        return float(away[chosen]), float(self.tolerances[chosen])

    def on_plan(self, xy: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which points (N, 2) of the plan are right, whatever their height."""
        away = np.linalg.norm(xy[:, None] - self.points[None, :, :2], axis=2)
        return np.asarray((away <= self.tolerances).any(axis=1))


def places_of(
    camera: RecordedSequence, questions: Sequence[MarkedThing], Ts_world_cam: NDArray[np.float64]
) -> list[MarkedPlaces]:
    """Where the thing of each question is, and what is right there.

    An answer is right within `MOST` of a mark, and not beyond half the way to the nearest mark of
    another thing, but within `LEAST` in any case.

    Raises:
        ConfigError: as of `marked_points`.
    """
    points = [marked_points(camera, question, Ts_world_cam) for question in questions]
    places = []
    for number, own in enumerate(points):
        others = np.concatenate([np.zeros((0, 3)), *points[:number], *points[number + 1 :]])
        away = np.linalg.norm(own[:, None] - others[None], axis=2).min(axis=1, initial=np.inf)
        places.append(MarkedPlaces(own, np.clip(away / 2, LEAST, MOST)))
    return places


def marked_points(
    camera: RecordedSequence, question: MarkedThing, Ts_world_cam: NDArray[np.float64]
) -> NDArray[np.float64]:
    """The marked points in `world` (M, 3) [m].

    Args:
        camera: The recording.
        question: The question.
        Ts_world_cam: Poses of all frames (F, 4, 4), NaN where one is not known.

    Raises:
        ConfigError: a mark is outside of the recording or in a frame without a pose, or nothing was
            measured there.
    """
    points = [_point(camera, question, mark, Ts_world_cam) for mark in question.marks]
    return np.array(points).reshape(-1, 3)


def _point(
    camera: RecordedSequence, question: MarkedThing, mark: Mark, Ts_world_cam: NDArray[np.float64]
) -> NDArray[np.float64]:
    where = f"question {question.text!r}: mark {mark.frame}, {mark.pixel}"
    if mark.frame >= len(Ts_world_cam):
        raise ConfigError(f"{where} is in none of the {len(Ts_world_cam)} frames")
    T_world_cam: SE3 = Ts_world_cam[mark.frame]
    if np.isnan(T_world_cam).any():
        raise ConfigError(f"{where} is in a frame without a pose; mark it in another one")
    frame = camera.frame(mark.frame)
    u, v = mark.pixel
    height, width = frame.depth.shape
    if not (0 <= u < width and 0 <= v < height):
        raise ConfigError(f"{where} is outside of the picture of {width} x {height} pixels")
    u, v = camera.undistorted(u, v)
    depth = float(frame.depth[v, u])
    if depth <= 0.0:
        raise ConfigError(f"{where} has no depth; mark another pixel of it")
    ray = np.linalg.inv(frame.intrinsics.K) @ (u, v, 1.0)
    return np.asarray(transform(T_world_cam, (depth * ray)[None])[0])
