"""A recording is mapped, its map is asked, and the answers are compared with marked places."""

from __future__ import annotations

import hashlib
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field, ValidationError

from benchmarks.harness.bench_plan import BenchResult
from benchmarks.harness.fingerprint import commit, hardware, key_of_robot, key_of_settings
from benchmarks.harness.scores import Rate
from benchmarks.harness.store import Store
from benchmarks.harness.tables import fraction_with_interval, markdown_table
from drivers.tum_sequence import RecordedSequence
from mapping.clip.encoder import ClipEncoder
from mapping.map_bundle import MapBundle
from mapping.trajectory_error import align, associate
from mapping.tum import read_trajectory
from vizbot.config import Config
from vizbot.core.errors import ConfigError
from vizbot.core.geometry import transform
from vizbot.core.settings import SETTINGS
from vizbot.core.types import SE3
from vizbot.mission import watch
from vizbot.objectnav.tasks import goal_of
from vizbot.operator.session.place_answers import find_places
from vizbot.pipeline import Pipeline
from vizbot.rig import open_encoder, opened_devices

NAME = "questions"
ScoreKind = Literal["probability", "similarity"]
"""What an answer is decided by; by the method `paper` the similarity of question and place."""
_TEXT = """`vizbot bench questions SEQ --questions FILE` maps a recording, asks its map once for
each thing in the file, and compares the first place of each answer with the places that a person
marked in the pictures ([questions of the walk through an office](questions/hololens_office.toml)).
With `--clip FOLDER` another CLIP answers the same questions, so that one sees what real weights
give. The embedded encoder was trained on simulated homes alone: it is there for rehearsals, and not
to be relied on in real pictures."""
_BY_SIMILARITY = "The scores are similarities, -1 to 1, by which the robot of that commit decided."


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


@dataclass(frozen=True, slots=True)
class MarkedAnswer:
    """The first answer of a map to a question.

    Attributes:
        text: The question.
        exists: Whether there is such a thing.
        score: What the robot decides by, of the best place; None where there is none.
        threshold: Score above which the robot takes it for the thing.
        distance: Distance from the nearest marked point [m]; None without a thing or a place.
        radius: Largest distance that is right [m].
    """

    text: str
    exists: bool
    score: float | None
    threshold: float
    distance: float | None
    radius: float

    @property
    def right(self) -> bool:
        """Whether the first place is the thing, whatever the robot thinks of it."""
        return self.distance is not None and self.distance <= self.radius

    @property
    def believed(self) -> bool:
        """Whether the robot takes the place for the thing."""
        return self.score is not None and self.score > self.threshold


@dataclass(frozen=True, slots=True)
class RecordingAnswers:
    """The answers of one encoder on one recording.

    Attributes:
        recording: Name of the recording.
        model: Identity of the encoder, as maps name it.
        notice: What the encoder says of itself; empty for none.
        frames: Number of frames.
        score_kind: What the scores are: probabilities, 0 to 1, or cosines, -1 to 1.
        answers: One for each question.
    """

    recording: str
    model: str
    notice: str
    frames: int
    score_kind: ScoreKind
    answers: tuple[MarkedAnswer, ...]


def run_questions(sequence: Path, questions: Path, config: Config, folder: Path) -> BenchResult:
    """Map the recording, ask every question once, keep the answers and print their table.

    Args:
        sequence: Folder in TUM layout with a `groundtruth.txt`, in whose frame marks are placed.
        questions: TOML file of the questions.
        config: Settings of the robot.
        folder: Folder of the results.

    Raises:
        VizbotError: a file or the encoder cannot be used.
    """
    asked = read_questions(questions)
    truth = sequence / "groundtruth.txt"
    if not truth.is_file():
        raise ConfigError(f"{truth} is missing; marked places are placed by it")
    with RecordedSequence(sequence) as camera:
        stamps, Ts_world_cam = _true_poses(camera, truth)
        places = [marked_points(camera, question, Ts_world_cam) for question in asked]
    encoder = open_encoder(config.clip, config.device, config.half)
    bundle = _mapped(sequence, config, encoder)
    T_world_map = _alignment(bundle, stamps, Ts_world_cam)
    answers = tuple(
        _answer(question, points, bundle, T_world_map, encoder, config)
        for question, points in zip(asked, places, strict=True)
    )
    result = RecordingAnswers(
        sequence.resolve().name,
        encoder.model_id,
        encoder.notice or "",
        len(stamps),
        "similarity" if config.objectnav.method == "paper" else "probability",
        answers,
    )
    asked_by = hashlib.sha256(questions.read_bytes()).hexdigest()[:12]
    key = f"{key_of_robot('benchmarks/questions')}-{key_of_settings(config)}-{asked_by}"
    Store(folder / "answers.jsonl", RecordingAnswers).add(key, commit(), hardware(), result)
    return questions_result(result)


def _true_poses(
    camera: RecordedSequence, truth: Path
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Stamps (F,) [s] and true poses (F, 4, 4) of all frames."""
    stamps = np.array([camera.frame(i).stamp for i in range(len(camera))])
    true_stamps, Ts_world_cam = read_trajectory(truth)
    here, there = associate(stamps, true_stamps)
    if len(here) < len(stamps):
        raise ConfigError(
            f"{truth} tells of {len(here)} of the {len(stamps)} frames; all are needed"
        )
    return stamps, Ts_world_cam[there]


def _mapped(sequence: Path, config: Config, encoder: ClipEncoder) -> MapBundle:
    with opened_devices(config, str(sequence), "none") as devices:
        pipeline = Pipeline(devices, encoder, config, [])
        watch(pipeline, [])
    bundle = pipeline.bundle()
    assert bundle is not None  # there are frames
    return bundle


def _alignment(
    bundle: MapBundle, stamps: NDArray[np.float64], Ts_world_cam: NDArray[np.float64]
) -> SE3:
    """T_world_map that brings the map's final trajectory nearest to the true one."""
    here, there = associate(bundle.trajectory.stamps, stamps)
    return align(bundle.final_poses()[here, :3, 3], Ts_world_cam[there, :3, 3])


def _answer(
    question: MarkedThing,
    points: NDArray[np.float64],
    bundle: MapBundle,
    T_world_map: SE3,
    encoder: ClipEncoder,
    config: Config,
) -> MarkedAnswer:
    goal = goal_of(encoder, question.text)
    answer = find_places(bundle, goal, encoder.log_odds, config.objectnav)
    distance, score = None, None
    if answer.places:
        best = answer.places[0]
        score = round(best.score, 4)
        if len(points):
            there = transform(T_world_map, np.array([best.position]))[0]
            distance = round(float(np.linalg.norm(points - there, axis=1).min()), 2)
    return MarkedAnswer(
        question.text, bool(len(points)), score, answer.threshold, distance, question.radius
    )


def questions_result(result: RecordingAnswers) -> BenchResult:
    """Rows, summary and table of these answers."""
    exist = [answer for answer in result.answers if answer.exists]
    absent = [answer for answer in result.answers if not answer.exists]
    right = Rate.over(answer.right for answer in exist)
    found = Rate.over(answer.right and answer.believed for answer in exist)
    refused = Rate.over(not answer.believed for answer in absent)
    header = ("question", result.score_kind, "has to exceed", "off [m]", "right within [m]",
              "first place", "the robot says")  # fmt: skip
    table = markdown_table(header, [_table_row(answer) for answer in result.answers])
    notes = [
        f"{result.recording}, {result.frames} frames, mapped and asked with {result.model}."
        + (f" {result.notice[0].upper()}{result.notice[1:]}." if result.notice else ""),
        f"First place right: {fraction_with_interval(right)}; right, and the robot believes"
        f" it: {fraction_with_interval(found)}. Of things that are not there refused:"
        f" {fraction_with_interval(refused)}.",
    ]
    summary: dict[str, object] = {
        "questions": right.trials,
        "right": right.value,
        "found": found.value,
        "absent": refused.trials,
        "refused": refused.value,
    }
    rows: list[dict[str, object]] = [
        {"row": answer.text, "right": answer.right, "believed": answer.believed,
         "distance": answer.distance, "score": answer.score}
        for answer in result.answers
    ]  # fmt: skip
    return BenchResult(NAME, rows, summary, "\n\n".join([*notes, table]))


def _table_row(answer: MarkedAnswer) -> Sequence[object]:
    first = ("right" if answer.right else "wrong") if answer.exists else "there is none"
    return [
        answer.text,
        answer.score,
        f"{answer.threshold:.2f}",
        answer.distance,
        f"{answer.radius:g}" if answer.exists else None,
        first,
        "it is there" if answer.believed else "not found",
    ]


def questions_page(folder: Path, page: Path) -> str:
    """The page of the newest answers on each recording; empty without any."""
    newest = {line.result.recording: line for line in Store(
        folder / "answers.jsonl", RecordingAnswers
    ).all()}  # fmt: skip
    if not newest:
        return ""
    parts = ["# Questions to a real recording"]
    for name, line in newest.items():
        parts += [f"## {name}", questions_result(line.result).text, f"Commit {line.commit}."]
        if line.result.score_kind == "similarity":
            parts.append(_BY_SIMILARITY)
    return "\n\n".join([*parts, _TEXT, ""])
