"""`report.html`: one self-contained page that tells what became of a run."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from jinja2 import Environment, PackageLoader, select_autoescape
from numpy.typing import NDArray

from vizbot.core.files import write_whole
from vizbot.core.observation import GoalReport, Step
from vizbot.operator.album import Album
from vizbot.operator.encoded import data_uri, jpeg, png
from vizbot.operator.matches import Match, matches
from vizbot.operator.panels import board, panels
from vizbot.operator.run_map import run_map
from vizbot.operator.story import Chapter, Story
from vizbot.operator.video import Video

log = logging.getLogger(__name__)

VIDEO = (720, 566)
"""Width and height of the video [px]; it is in the page, which should stay small."""
_EVERY = 2
_RATE = 10


class Report:
    """An observer that draws the run and writes the page at its end."""

    def __init__(self, folder: Path, notice: str | None) -> None:
        """Begin the video `run.webm` in `folder`.

        Args:
            folder: Of the run.
            notice: What must be said wherever the encoder answers; None for nothing.
        """
        self._folder = folder
        self._notice = notice
        self._track: list[tuple[float, float]] = []
        self._reports: list[GoalReport] = []
        self._story = Story()
        self._album = Album(folder)
        self._matches: dict[int, list[Match]] = {}
        self._last: Step | None = None
        self._way: NDArray[np.float64] | None = None
        self._video: Video | None = None

    def on_step(self, step: Step) -> None:
        """Draw every second step into the video."""
        self._story.add(step)
        self._track.append((float(step.T_map_base[0, 3]), float(step.T_map_base[1, 3])))
        self._last = step
        if step.target is None or step.path is None:
            self._way = None
        elif self._way is None or len(step.path) > len(self._way):
            self._way = step.path  # as it was planned when the goal was found
        if step.index % _EVERY == 0 or step.ended is not None:
            self._draw(step)
        self._album.add(step.frame_number, step.frame.rgb)

    def on_goal(self, report: GoalReport) -> None:
        """Keep the answer, and what it was found in."""
        self._reports.append(report)
        self._story.end(report)
        if self._last is not None:
            found = matches(report, self._last, self._album)
            self._matches[len(self._story.chapters) - 1] = found

    def finish(
        self,
        metrics: Mapping[str, object],
        true_plan: NDArray[np.uint8] | None = None,
        attributions: Sequence[str] = (),
    ) -> Path:
        """Close the video and write the page.

        Args:
            metrics: What the run measured, shown as a table.
            true_plan: (H, W, 3) picture of the simulated home, for comparison; None on hardware.
            attributions: Author and licence of each model that the pictures show.

        Returns:
            The page.
        """
        video = self._finished_video()
        pictures, drawn_map = [], None
        self._album.close()
        if self._last is not None:
            drawn = panels(replace(self._last, path=self._way), np.array(self._track))
            if true_plan is not None:
                drawn["the simulated home as it is (the robot never saw this)"] = true_plan
            pictures = [
                (name, data_uri("image/png", png(picture)))
                if name != "colour"
                else (name, data_uri("image/jpeg", jpeg(picture)))
                for name, picture in drawn.items()
            ]
            drawn_map = run_map(self._last, np.array(self._track), self._reports)
        page = self._folder / "report.html"
        environment = Environment(
            loader=PackageLoader("vizbot.operator", "page"), autoescape=select_autoescape()
        )
        content = environment.get_template("report.html").render(
            reports=self._reports,
            chapters=[self._chapter(i) for i in range(len(self._story.chapters))],
            story=self._story,
            map=drawn_map,
            last=self._last,
            metrics=metrics,
            pictures=pictures,
            video=video,
            notice=self._notice,
            attributions=attributions,
        )
        write_whole(page, content.encode())
        return page

    def _chapter(self, number: int) -> tuple[Chapter, list[tuple[Match, str]]]:
        """A chapter, and its pictures with their data URIs."""
        found = self._matches.get(number, [])
        pictures = [(match, data_uri("image/jpeg", jpeg(match.picture))) for match in found]
        return self._story.chapters[number], pictures

    def _finished_video(self) -> str | None:
        """As a data URI; None if there is none, or the disk was full."""
        if self._video is None:
            return None
        try:
            self._video.close()
            return data_uri("video/webm", (self._folder / "run.webm").read_bytes())
        except OSError as error:
            log.warning("the report has no video: %s", error.strerror or error)
            return None

    def _draw(self, step: Step) -> None:
        picture = cv2.resize(
            board(step, np.array(self._track)), VIDEO, interpolation=cv2.INTER_AREA
        )
        if self._video is None:
            self._video = Video(self._folder / "run.webm", *VIDEO, _RATE)
        self._video.add(np.asarray(picture, np.uint8))
