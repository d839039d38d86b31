"""`report.html`: one self-contained page about a run and its outcome."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import cv2
import numpy as np
from jinja2 import Environment, PackageLoader, select_autoescape
from numpy.typing import NDArray

from vizbot.core.files import write_whole
from vizbot.core.observer import Candidate, GoalReport, Step
from vizbot.core.place_scores import Measure
from vizbot.core.work_queue import WorkQueue
from vizbot.operator.figures.image_encoding import data_uri, jpeg, png
from vizbot.operator.figures.panels import panels, video_picture
from vizbot.operator.figures.steps import StepFilter, Track
from vizbot.operator.report.frame_store import FrameStore, Match, matches, picture_of
from vizbot.operator.report.map_figure import run_map
from vizbot.operator.report.timeline import GoalTimeline, Timeline

if TYPE_CHECKING:
    from vizbot.operator.report.video import Video  # its module loads FFmpeg

log = logging.getLogger(__name__)

VIDEO = (720, 588)
"""Width and height of the video [px]; it is in the page, which should stay small."""
_EVERY = 2
_RATE = 10
_PICTURES, _THINNED = 4200, 600
_ILLUSTRATED = 100
_WAITING = 8
"""Pictures that wait to be drawn."""


class Report:
    """An observer that draws the run and writes the page at its end, however long it was left on.

    A robot that waits where it stands adds nothing. Every second step is in the video; after 600
    pictures only every fourth is, and after each 600 more half as many. The video ends with 4200
    pictures: 7 minutes, some 40 MB, for 150 000 steps. The last 100 goals have pictures of the
    places where they were found. Only the last map of the run is drawn.
    """

    def __init__(self, folder: Path, notice: str | None) -> None:
        """Begin the video `run.webm`; `notice` is said wherever the encoder answers."""
        self._folder = folder
        self._notice = notice
        self._track = Track()
        self._reports: list[GoalReport] = []
        self._before_map = 0
        self._timeline = Timeline()
        self._filter = StepFilter()
        self._frame_store = FrameStore(folder)
        self._newest_kept = -1
        self._matches: dict[int, list[Match]] = {}
        self._last: Step | None = None
        self._path: NDArray[np.float64] | None = None
        self._video: Video | None = None
        self._drawing = WorkQueue(_WAITING)
        self._drawn = 0

    def on_step(self, step: Step) -> None:
        """Draw every second step into the video."""
        if self._last is not None and step.map_number != self._last.map_number:
            self._begin_map()
        self._timeline.add(step)
        self._last = step
        if step.target is None or step.path is None:
            self._path = None
        elif self._path is None or len(step.path) > len(self._path):
            self._path = step.path  # as it was planned when the goal was found
        if self._filter.is_news(step):
            self._track.add(step.T_map_base[:2, 3])
            if self._is_drawn(step):
                self._drawn += 1
                track_xy = self._track.xy.copy()
                self._drawing.put(lambda: self._draw(step, track_xy))
        self._frame_store.add(step.frame_number, step.frame.rgb)
        new = np.searchsorted(step.frames, self._newest_kept, side="right")
        self._frame_store.keep(step.frames[new:])
        self._newest_kept = int(step.frames.max(initial=self._newest_kept))

    def on_goal(self, report: GoalReport) -> None:
        """Keep the answer and the pictures of the places."""
        self._reports.append(report)
        self._timeline.end(report)
        if self._last is not None:
            found = matches(report, self._frame_store)
            self._matches[len(self._timeline.goals) - 1] = found
            if len(self._matches) > _ILLUSTRATED:
                del self._matches[next(iter(self._matches))]

    def picture_of(self, report: GoalReport) -> bytes | None:
        """JPEG of the best place of the latest report; None where its frame was not kept."""
        if not self._timeline.goals or self._timeline.goals[-1].report is not report:
            return None
        found = self._matches.get(len(self._timeline.goals) - 1, [])
        return next((match.picture for match in found if match.rank == 1), None)

    def picture_of_place(self, place: Candidate) -> bytes | None:
        """JPEG of a place by its probability; None where its frame was not kept."""
        return picture_of(place, Measure.PROBABILITY.text(place.score), self._frame_store)

    def _begin_map(self) -> None:
        """Drop what belongs to the map that the run has left."""
        self._frame_store.clear()
        self._newest_kept = -1
        self._track, self._path, self._filter = Track(), None, StepFilter()
        self._before_map = len(self._reports)

    def finish(
        self,
        metrics: Mapping[str, object],
        true_plan: NDArray[np.uint8] | None = None,
        attributions: Sequence[str] = (),
    ) -> Path:
        """Close the video and write the page, whose path is returned.

        `true_plan` (H, W, 3) is a picture of the simulated home, for comparison, None on hardware;
        `attributions` name author and licence of each model that the pictures show.
        """
        video = self._finished_video()
        pictures, drawn_map = [], None
        self._frame_store.close()
        if self._last is not None:
            drawn = panels(replace(self._last, path=self._path), self._track.xy)
            if true_plan is not None:
                drawn["the simulated home as it is (the robot never saw this)"] = true_plan
            pictures = [
                (name, data_uri("image/png", png(picture)))
                if name != "colour"
                else (name, data_uri("image/jpeg", jpeg(picture)))
                for name, picture in drawn.items()
            ]
            drawn_map = run_map(self._last, self._track.xy, self._reports[self._before_map :])
        page = self._folder / "report.html"
        environment = Environment(
            loader=PackageLoader("vizbot.operator", "page"), autoescape=select_autoescape()
        )
        environment.filters["in_words"] = in_words
        content = environment.get_template("report.html").render(
            reports=self._reports,
            goals=[self._illustrated(i) for i in range(len(self._timeline.goals))],
            timeline=self._timeline,
            map=drawn_map,
            last=self._last,
            metrics=metrics,
            pictures=pictures,
            video=video,
            poster=self._poster(),
            notice=self._notice,
            attributions=attributions,
        )
        write_whole(page, content.encode())
        return page

    def _illustrated(self, number: int) -> tuple[GoalTimeline, list[tuple[Match, str]]]:
        """The timeline of a goal, and its pictures with their data URIs."""
        found = self._matches.get(number, [])
        pictures = [(match, data_uri("image/jpeg", match.picture)) for match in found]
        return self._timeline.goals[number], pictures

    def _finished_video(self) -> str | None:
        """As a data URI; None if there is none, or the disk was full."""
        try:
            self._drawing.finish()
            if self._video is None:
                return None
            self._video.close()
            return data_uri("video/webm", (self._folder / "run.webm").read_bytes())
        except OSError as error:
            log.warning("the report has no video: %s", error.strerror or error)
            return None

    def _poster(self) -> str | None:
        """The end of the run as the video shows it, as a data URI; None without a step."""
        if self._last is None:
            return None
        return data_uri("image/jpeg", jpeg(_in_video(self._last, self._track.xy)))

    def _is_drawn(self, step: Step) -> bool:
        if self._drawn >= _PICTURES:
            return False
        every = _EVERY << self._drawn // _THINNED
        return step.index % every == 0 or step.ended is not None

    def _draw(self, step: Step, track_xy: NDArray[np.float64]) -> None:
        picture = _in_video(step, track_xy)
        if self._video is None:
            from vizbot.operator.report.video import Video

            self._video = Video(self._folder / "run.webm", *VIDEO, _RATE)
        self._video.add(picture)


def in_words(value: object) -> str:
    """What was measured, in words where it is no number."""
    if value is None:
        return "none"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return str(value)


def _in_video(step: Step, track_xy: NDArray[np.float64]) -> NDArray[np.uint8]:
    """A picture (H, W, 3) of the video."""
    picture = cv2.resize(video_picture(step, track_xy), VIDEO, interpolation=cv2.INTER_AREA)
    return np.asarray(picture, np.uint8)
