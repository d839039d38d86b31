"""Progress on standard error: of the bank of pictures before a run, then one live line."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Self

from rich.console import Console
from rich.live import Live
from rich.text import Text

from vizbot.core.observer import GoalReport, Step
from vizbot.operator.printing import echo, printable
from vizbot.rig import calibration_line

if TYPE_CHECKING:  # their modules load torch
    from mapping.clip.encoder import ClipEncoder, TextEncoder
    from vizbot.perception.interfaces import PerceptionParts

_PLAIN_EVERY = 25
"""Steps between two lines that are printed where there is no terminal."""
_BANK_EVERY = 5.0
"""Time between two lines [s]."""


class Progress:
    """An observer that shows, while entered, what each step does and why, and what it knows.

    On a terminal the line is rewritten in place; elsewhere (a log, a pipe) every 25th is printed.
    """

    def __init__(self, max_steps: int | None = None) -> None:
        """Create it; a goal is given up after `max_steps`, None where nothing is."""
        self._most = "" if max_steps is None else f" of {max_steps}"
        self._goal, self._steps = "", 0
        self._console = Console(stderr=True, highlight=False)
        self._live = Live(Text(""), console=self._console, refresh_per_second=8)

    def __enter__(self) -> Self:
        if self._console.is_terminal:
            self._live.start()
        return self

    def __exit__(self, *exc: object) -> None:
        if self._console.is_terminal:
            self._live.stop()

    def on_step(self, step: Step) -> None:
        """Show the step."""
        self._steps = self._steps + 1 if step.goal == self._goal else 1
        self._goal = step.goal
        if not self._console.is_terminal and step.index % _PLAIN_EVERY:
            return
        if not step.goal:
            keyframe = step.estimate.keyframe
            self._show(f"frame {step.index:4d}  keyframe {keyframe}  {step.activity}{_seen(step)}")
            return
        measure = step.measure
        score = "-" if step.shown_score is None else measure.text(step.shown_score)
        to_go = "-" if step.distance_to_go is None else f"{step.distance_to_go:.1f} m"
        self._show(
            f"step {self._steps:4d}{self._most}  {_short(step.goal)}: {_doing(step)}"
            f"  {measure} {score} (enough: {measure.text(step.threshold)})  to go {to_go}"
            f"{_seen(step)}"
        )

    def on_goal(self, report: GoalReport) -> None:
        """Show the answer."""
        self._steps = 0
        answer = f"{report.headline}: {report.reason}"
        self._console.print(Text(printable(answer)), soft_wrap=True)

    def _show(self, line: str) -> None:
        text = Text(printable(line))
        if self._console.is_terminal:
            self._live.update(text)
        else:
            self._console.print(text, soft_wrap=True)


def _doing(step: Step) -> str:
    """What the robot does, and why in short."""
    return f"{step.activity}, since {step.short_why}" if step.why else step.activity


def _seen(step: Step) -> str:
    """How much of the floor was seen, where a search for frontiers knows it."""
    return "" if step.seen_share is None else f"  seen {step.seen_share:.0%}"


def _short(goal: str) -> str:
    return goal if len(goal) <= 40 else goal[:39] + "…"


class BankProgress:
    """Says how far the bank is, at most every five seconds."""

    def __init__(self, model_id: str, now: Callable[[], float] = time.monotonic) -> None:
        """Say nothing yet; `now` reads a monotonic clock [s]."""
        self._model_id, self._now = model_id, now
        self._began = self._said = 0.0

    def __call__(self, done: int, of: int) -> None:
        """Say how many pictures have been embedded, if the last line is old enough."""
        now = self._now()
        if done == 0:
            self._began = self._said = now
            echo(
                f"{self._model_id} embeds {of} pictures that questions are compared with; they are"
                " kept for its next runs",
                err=True,
            )
            return
        if done < of and now - self._said < _BANK_EVERY:
            return
        self._said = now
        took = now - self._began
        left = f", about {took / done * (of - done):.0f} s left" if done < of else ""
        echo(f"{done} of {of} pictures after {took:.0f} s{left}", err=True)


def say_calibration(encoder: TextEncoder, clip: str) -> None:
    """Say whether the belief's numbers fit the encoder, as `--clip` names it."""
    if (line := calibration_line(encoder, clip)) is not None:
        echo(line, err=True)


def parts_with_bank(encoder: ClipEncoder) -> PerceptionParts | None:
    """Embed the bank, unless it is kept, by an encoder that was loaded from a disk.

    It is done before a device is opened: a robot that stands with an empty map while the bank is
    embedded would be of no use. None by other encoders, which embed it with the first frame.
    """
    from mapping.clip.background.kept_bank import KnownWeights
    from mapping.clip.scores import Background
    from vizbot.perception.interfaces import PerceptionParts

    if not isinstance(encoder, KnownWeights):
        return None
    background = Background.embedded_by(encoder, BankProgress(encoder.model_id))
    return PerceptionParts(background=lambda: background)
