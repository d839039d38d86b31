"""Models of what the API answers."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from vizbot.core.observer import Outcome
from vizbot.core.place_scores import Measure
from vizbot.core.types import Charging, Tracking

Point = tuple[float, float]
"""x, y in `map` [m]."""
Position = tuple[float, float, float]
"""x, y, z in `map` [m]."""
Share = Annotated[float, Field(ge=0.0, le=1.0)]


class AnswerModel(BaseModel):
    """Described by the docstrings of its fields."""

    model_config = ConfigDict(use_attribute_docstrings=True)


class TaskNumbers(AnswerModel):
    """The tasks that were queued."""

    numbers: list[int]
    """One for each task, as in the state."""


class StopAnswer(AnswerModel):
    """The robot was stopped."""

    stopped: Literal[True] = True


class RequestTaken(AnswerModel):
    """The request reached the robot; the state shows what comes of it."""

    asked: Literal[True] = True


class TokenProof(AnswerModel):
    """The proof that a server knows the token."""

    run: str
    """Name of this run of the server."""
    proof: str | None
    """HMAC-SHA256 by the token of `["server", challenge, run, host, port]` as JSON; null where no
    token is wanted."""


class DoubtShown(AnswerModel):
    """The question is in the log, and the base has played its song of doubt."""

    shown: Literal[True] = True


class SentenceAnswer(AnswerModel):
    """What the robot answers to a sentence."""

    said: list[str]
    """Lines to be shown."""
    question: str | None
    """What the robot asks back before it does anything; null without a doubt."""
    meant: str | None
    """The sentence that says yes to the question; null without one."""
    place: Point | None
    """Where what was asked for is, x, y in `map` [m]; null where it is not on the map, or where
    nothing was asked for."""
    heard: str | None
    """The words of a recording; null for a typed sentence."""
    numbers: list[int]
    """Of the tasks that the sentence has queued, as in the state."""


class TaskState(AnswerModel):
    """A task that was asked for."""

    number: int
    """From 1, in the order in which tasks were asked for."""
    text: str
    """What is to be done, as a person says it."""
    headline: str | None
    """How the search for a goal ended, in words: "Found the sofa after 50 s, 12 m"; null before its
    end, and for what is no search."""
    outcome: Outcome | None
    """How the task ended; null before its end."""
    reason: str
    """Why it ended so, in one line; empty before its end."""
    position: Position | None
    """Where the task ended or its goal was found, x, y, z in `map` [m]; null without a place."""
    seconds: float | None
    """What the search for a goal took, by the clock of the run [s]; null before its end, and for
    what is no search."""
    way: float | None
    """What the robot drove for it [m]."""


class ArrivalState(AnswerModel):
    """Where the robot has arrived last, for people to say whether that is it."""

    number: int
    """Of the task."""
    text: str
    """What was asked for."""
    headline: str
    """The outcome in words, as of the task."""
    seconds: float | None
    """What the search took, by the clock of the run [s]."""
    way: float | None
    """What the robot drove for it [m]."""
    has_picture: bool
    """Whether `/pictures/arrival.jpg` shows what was found, with a box around it."""
    confirmed: bool | None
    """Whether somebody says that it is what was asked for; null before."""


class CandidateState(AnswerModel):
    """The place that the robot approaches because it may be the goal."""

    number: int
    """The same as long as it is one place."""
    text: str
    """What is searched for."""
    headline: str
    """What the robot says of the place: "I see something like a sofa"."""
    position: Point
    """x, y in `map` [m]."""
    confirmed: bool
    """Whether somebody has said to go there."""


class BaseReport(AnswerModel):
    """The newest sensor values of the base."""

    mode: Literal["off", "passive", "safe", "full"]
    """The Open Interface mode; only in `safe` and `full` do the wheels obey."""
    battery: Share | None
    """Charge from 0 to 1; null where it is unknown."""
    charging: Charging
    docked: bool
    """Whether the base stands on its dock."""
    plugged_in: bool
    """Whether the base is charged by a cable."""
    bumps: tuple[bool, bool]
    """Left, right."""
    cliffs: tuple[bool, bool, bool, bool]
    """Left, front left, front right, right."""
    wheel_drops: tuple[bool, bool]
    """Left, right."""
    overcurrents: tuple[bool, bool]
    """Left, right."""
    virtual_wall: bool
    maybe_moved: bool
    """Whether somebody may have moved it while nobody heard it; it rests until it is asked to obey
    again."""
    feels: list[str]
    """What the base touches or misses, in plain words."""


class LogLine(AnswerModel):
    """A line of the log."""

    time: float
    """Seconds since 1970."""
    code: Literal[
        "goal", "activity", "ended", "stop", "wheel", "verdict", "doubt", "resume", "map", "warning"
    ]
    """What kind of thing happened."""
    text: str
    outcome: Outcome | None = None
    """How the task of an `ended` line ended; absent from other lines."""


class MapPictureView(AnswerModel):
    """Where the picture of the map lies in `map`; walls stand upright in it.

    The pixel `column, row`, counted from the picture's upper left corner, shows the place that lies
    `column * metres_per_pixel` in the direction `turn` from the corner, and
    `(height - row) * metres_per_pixel` in the direction a quarter turn counterclockwise from that.
    """

    corner: Point
    """x, y of the picture's lower left corner in `map` [m]."""
    metres_per_pixel: float
    width: int
    """[px]"""
    height: int
    """[px]"""
    turn: float
    """Direction of the picture's rows in `map`, counterclockwise from x [rad]; seldom changes."""


class RobotState(AnswerModel):
    """What the robot does, where it is, what it feels, and what it was asked for.

    What comes after `map_view` is absent before the first step.
    """

    stopped: bool
    """Whether the robot rests until somebody asks for something new."""
    wheel: str | None
    """Who drives by hand; null for nobody."""
    goals: list[TaskState]
    """Tasks that are over come first, then the running one, then the waiting ones."""
    steps_per_second: float
    """Mean of the last five seconds."""
    base: BaseReport | None
    """Null without a base, or before it has reported."""
    arrival: ArrivalState | None
    """Null before the robot has arrived anywhere, and once another search or map has begun."""
    candidate: CandidateState | None
    """Null where the robot approaches nothing that may be the goal."""
    question: str | None
    """What the robot asks before it does anything more; `/continue` says to go on. Null where it
    asks nothing."""
    log: list[LogLine]
    """Oldest line first."""
    run: str | None
    """Folder of the run, on the robot's machine; null where it keeps none."""
    step: int | None
    """Index of the newest step, from 0; null before the first one."""
    activity: str
    """What the robot is doing, in plain words."""
    map_view: MapPictureView | None
    """Null before the first step."""
    goal: str | None = None
    """The words that the robot looks for; empty while it looks for nothing."""
    likeness: str | None = None
    """The words to which the picture `likeness` belongs, those of the last search; empty before."""
    tracking: Tracking | None = None
    """How far the robot's pose can be trusted."""
    position: Point | None = None
    """x, y of the base in `map` [m]."""
    heading: float | None = None
    """Yaw of the base in `map`, counterclockwise from x [rad]."""
    why: str | None = None
    """Why it does that, in one line; empty where it needs no saying."""
    score: float | None = None
    """What the search decides by, of the best place on the map; null without a goal or a map."""
    measure: Measure | None = None
    """What a score is: the probability that a place is the goal, 0 to 1, or by the method `paper`
    the similarity of what it shows, -1 to 1."""
    threshold: float | None = None
    """What the places were compared with in the newest step; 0 without a goal. It falls late in a
    search, for a place that the robot already approaches, and where nothing is left to try."""
    distance_to_go: float | None = None
    """Along the planned path [m]; null without one."""


class PlaceAnswer(AnswerModel):
    """A place on the map that may be what was asked for."""

    position: Position
    """x, y, z in `map` [m]."""
    score: float
    """Probability that the place is what was asked for; by the method `paper` the cosine between
    the two, -1 to 1."""
    frame: int
    """Number of the frame that saw the place."""
    box: tuple[int, int, int, int]
    """Where in that frame: left, top, right, bottom [px]."""
    seen_at: datetime
    """When the place was last seen, UTC."""


class PlacesAnswer(AnswerModel):
    """What the map answers to a question."""

    text: str
    """The question."""
    outcome: Literal[Outcome.LOCATED, Outcome.NOT_FOUND]
    """Whether the best place's score is enough."""
    threshold: float
    """What it has to exceed."""
    places: list[PlaceAnswer]
    """Best place first."""
    note: str | None
    """How the encoder understands the question; null where it needs no saying."""
    summary: str
    """The answer in one line, seen from the robot."""


class VocabularyAnswer(AnswerModel):
    """Things and rooms of a household that the map finds."""

    phrases: list[str]
    """In alphabetical order."""


class NamedRoom(AnswerModel):
    """A room on the map."""

    name: str
    position: Point
    """x, y in `map` of a place about in its middle [m]."""


class RoomsAnswer(AnswerModel):
    """The rooms on the map."""

    rooms: list[NamedRoom]
    """Largest room first."""


class ZonesAnswer(AnswerModel):
    """The keep-out zones."""

    zones: list[list[Point]]
    """The corners of each zone, x, y in `map` [m]."""


class ZoneCount(AnswerModel):
    """The keep-out zones have changed."""

    zones: int
    """How many there are now."""


class ListedMap(AnswerModel):
    """A saved map, as the list has it."""

    name: str
    saved_at: float
    """Seconds since 1970."""
    in_use: bool
    """Whether a robot is in it; it cannot be deleted then."""


class MapNames(AnswerModel):
    """The saved maps."""

    names: list[str]
    """Newest map first."""
    maps: list[ListedMap]
    """The same with what there is to say of each."""


class MapSaved(AnswerModel):
    """The map was saved."""

    saved: str
    """The name of the saved map."""


class RenamedMap(AnswerModel):
    """The saved map has another name."""

    renamed: str
    """The new name."""


class DeletedMap(AnswerModel):
    """The saved map is gone."""

    deleted: str
    """The name that it had."""


class LeftMap(AnswerModel):
    """The robot has changed its map."""

    left: str | None
    """The name under which the map that was left is saved; null where it held too little,
    or could not be saved."""
