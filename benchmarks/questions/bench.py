"""A recording is mapped, its map is asked, and the answers are compared with marked places."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from benchmarks.episodes.run import encoder_of
from benchmarks.harness.bench_plan import BenchResult
from benchmarks.harness.fingerprint import commit, hardware, key_of_robot, key_of_settings
from benchmarks.harness.scores import Rate
from benchmarks.harness.store import Store
from benchmarks.harness.tables import fraction_with_interval, markdown_table, percent
from benchmarks.questions.marks import (
    MarkedPlaces,
    MarkedThing,
    places_of,
    read_questions,
)
from benchmarks.questions.poses import BY_SLAM, poses_at, recorded_poses, require_most, told_poses
from drivers.tum_sequence import RecordedSequence
from mapping.clip.encoder import ClipEncoder
from mapping.clip.places.footprint import PLACE
from mapping.map_bundle import MapBundle
from vizbot.config import Config
from vizbot.core.errors import ConfigError
from vizbot.core.types import Tracking
from vizbot.objectnav.tasks import Task, goal_of
from vizbot.operator.session.place_answers import find_places
from vizbot.perception.interfaces import PerceptionParts, PoseEstimator
from vizbot.pipeline import Pipeline
from vizbot.rig import opened_devices

NAME = "questions"
ScoreKind = Literal["probability", "similarity"]
"""What an answer is decided by; by the method `paper` the similarity of question and place."""
_TEXT = """`vizbot bench questions SEQ --questions FILE` maps a recording, asks its map once for
each thing in the file, and compares the first place of each answer with the places that a person
marked in the pictures ([questions of the walk through an office](questions/hololens_office.toml)).
The poses of the map are the recorded ones, or those of our own SLAM where none were recorded, and
marks lie where these poses put them: errors of poses show on [their own page](slam.md).
An answer is right within 0.75 m of a mark, and not beyond half the way to the nearest mark of
another thing (0.25 m at least, the edge of a place of the map).
With `--clip FOLDER` another CLIP answers the same questions, so that one sees what real weights
give. The embedded encoder was trained on simulated homes alone: it is there for rehearsals, and not
to be relied on in real pictures."""
_BY_SIMILARITY = "The scores are similarities, -1 to 1, by which the robot of that commit decided."


@dataclass(frozen=True, slots=True)
class MarkedAnswer:
    """The first answer of a map to a question.

    Attributes:
        text: The question.
        exists: Whether there is such a thing.
        score: What the robot decides by, of the best place; None where there is none.
        threshold: Score above which the robot takes it for the thing.
        distance: Distance from the marked point that decides [m]; None without a thing or a place.
        radius: Largest distance from that point that is right [m]; None without a thing.
        by_chance: Share of the places of the map that are right on the plan, which is how often a
            random one of them would be.
    """

    text: str
    exists: bool
    score: float | None
    threshold: float
    distance: float | None
    radius: float | None
    by_chance: float

    @property
    def right(self) -> bool:
        """Whether the first place is the thing, whatever the robot thinks of it."""
        off, most = self.distance, self.radius
        return off is not None and most is not None and off <= most

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
        own_poses: Whether our own SLAM made the poses of the map, as none were recorded.
        lost: Number of frames without a pose, which are left out.
    """

    recording: str
    model: str
    notice: str
    frames: int
    score_kind: ScoreKind
    answers: tuple[MarkedAnswer, ...]
    own_poses: bool
    lost: int


def run_questions(sequence: Path, questions: Path, config: Config, folder: Path) -> BenchResult:
    """Map the recording, ask every question once, keep the answers and print their table.

    Args:
        sequence: Folder in TUM layout. It is mapped by the poses of its `groundtruth.txt`, without
            one by those of our own SLAM; marks lie where the poses of the map put them.
        questions: TOML file of the questions.
        config: Settings of the robot.
        folder: Folder of the results.

    Raises:
        VizbotError: a file or the encoder cannot be used.
    """
    asked = read_questions(questions)
    with RecordedSequence(sequence) as camera:
        Ts_world_cam = recorded_poses(camera, sequence)
        slam = None
        if Ts_world_cam is not None:
            slam = told_poses(camera, Ts_world_cam, config.perception.slam.keyframes)
        encoder = encoder_of(config)
        bundle, known = _mapped(sequence, config, encoder, slam)
        if slam is None:
            require_most(known, *BY_SLAM)
        stamps = bundle.trajectory.stamps[known]
        Ts_map_cam = poses_at(camera.stamps, stamps, bundle.final_poses()[known])
        marked = places_of(camera, asked, Ts_map_cam)
    answers = tuple(
        _answer(question, places, bundle, encoder, config)
        for question, places in zip(asked, marked, strict=True)
    )
    result = RecordingAnswers(
        sequence.resolve().name,
        encoder.model_id,
        encoder.notice or "",
        len(known),
        "similarity" if config.objectnav.method == "paper" else "probability",
        answers,
        own_poses=slam is None,
        lost=int(np.sum(~known)),
    )
    asked_by = hashlib.sha256(questions.read_bytes()).hexdigest()[:12]
    key = f"{key_of_robot('benchmarks/questions')}-{key_of_settings(config)}-{asked_by}"
    Store(folder / "answers.jsonl", RecordingAnswers).add(key, commit(), hardware(), result)
    return questions_result(result)


def _mapped(
    sequence: Path, config: Config, encoder: ClipEncoder, slam: PoseEstimator | None
) -> tuple[MapBundle, NDArray[np.bool_]]:
    """The map of a recording by the robot's own SLAM or another one, and which frames it posed."""
    with opened_devices(config, str(sequence), "none") as devices:
        pipeline = Pipeline(
            devices, encoder, config, [], PerceptionParts(slam=slam, every_pose=True)
        )
        known = []
        while (step := pipeline.tick(Task.MAP)) is not None:
            known.append(step.estimate.tracking is not Tracking.LOST)
        pipeline.finish()
    bundle = pipeline.bundle()
    assert bundle is not None  # there are frames
    return bundle, np.array(known)


def _answer(
    question: MarkedThing,
    marked: MarkedPlaces,
    bundle: MapBundle,
    encoder: ClipEncoder,
    config: Config,
) -> MarkedAnswer:
    """The map's answer to a question about places `marked` in `map`."""
    exists = len(marked.points) > 0
    by_chance = round(float(marked.on_plan(_seen_places(bundle)).mean()), 4)
    try:
        goal = goal_of(encoder, question.text)
    except ConfigError:  # it has no name for that
        least = config.objectnav.answer_probability
        return MarkedAnswer(question.text, exists, None, least, None, None, by_chance)
    answer = find_places(bundle, goal, config.objectnav)
    distance, radius, score = None, None, None
    if answer.places:
        best = answer.places[0]
        score = round(best.score, 4)
        if (found := marked.nearest(np.array(best.position))) is not None:
            distance, radius = (round(each, 2) for each in found)
    return MarkedAnswer(question.text, exists, score, answer.threshold, distance, radius, by_chance)


def _seen_places(bundle: MapBundle) -> NDArray[np.float64]:
    """Centres (N, 2) of all places that the map has views of, in `map` [m]."""
    placed = bundle.place_map().placed(bundle.keyframes.poses())
    return np.asarray((np.unique(placed.places, axis=0) + 0.5) * PLACE)


def questions_result(result: RecordingAnswers) -> BenchResult:
    """Rows, summary and table of these answers."""
    exist = [answer for answer in result.answers if answer.exists]
    absent = [answer for answer in result.answers if not answer.exists]
    right = Rate.over(answer.right for answer in exist)
    found = Rate.over(answer.right and answer.believed for answer in exist)
    refused = Rate.over(not answer.believed for answer in absent)
    by_chance = float(np.mean([answer.by_chance for answer in exist])) if exist else None
    header = ("question", result.score_kind, "has to exceed", "off [m]", "right within [m]",
              "a random place [%]", "first place", "the robot says")  # fmt: skip
    table = markdown_table(header, [_table_row(answer) for answer in result.answers])
    notes = [
        f"{result.recording}, {result.frames} frames, mapped and asked with {result.model}."
        + (f" {result.notice[0].upper()}{result.notice[1:]}." if result.notice else "")
        + " Its poses are "
        + (
            "those of our own SLAM, as none were recorded"
            if result.own_poses
            else "the recorded ones"
        )
        + (f"; frames without one, left out: {result.lost}." if result.lost else "."),
        f"First place right: {fraction_with_interval(right)}, where a random place of the map is"
        f" right in {percent(by_chance)} %; right, and the robot believes it:"
        f" {fraction_with_interval(found)}. Of things that are not there refused:"
        f" {fraction_with_interval(refused)}.",
    ]
    summary: dict[str, object] = {
        "questions": right.trials,
        "right": right.value,
        "right_by_chance": by_chance,
        "found": found.value,
        "absent": refused.trials,
        "refused": refused.value,
    }
    rows: list[dict[str, object]] = [
        {"row": answer.text, "right": answer.right, "believed": answer.believed,
         "distance": answer.distance, "score": answer.score, "by_chance": answer.by_chance}
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
        answer.radius,
        percent(answer.by_chance),
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
