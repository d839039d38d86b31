"""The run's folder: configuration, trajectory, commands, map and metrics."""

from __future__ import annotations

import csv
import io
import json
import logging
import math
import os
import time
import weakref
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryFile

import numpy as np
from numpy.typing import NDArray

from mapping import map_bundle
from mapping.map_bundle import MapBundle
from mapping.map_folder import is_readable
from mapping.map_saver import MapSaver
from mapping.map_snapshot import MapSnapshot
from mapping.tum import heading_of, pose_line, write_trajectory
from vizbot.config import Config, write_config
from vizbot.core.errors import ConfigError
from vizbot.core.files import GrowingFile, require_folder, write_whole
from vizbot.core.interfaces import Clock, Pending
from vizbot.core.observer import GoalReport, Step
from vizbot.core.program.interrupts import first_error, one_line
from vizbot.core.types import SE3, Twist

log = logging.getLogger(__name__)

_RESERVE = 200_000_000
"""Reserved space [bytes]; maps of homes take a fifth of it."""
_SAVED_EVERY = 10.0
"""Interval between two saves of the map [s]."""
_COLUMNS = "stamp,linear,angular,by\n"


def require_run_folder(folder: Path) -> None:
    """Refuse a folder for a run before the devices are opened; nothing changes.

    Raises:
        ConfigError: it is not new or empty, cannot be made, or has no space.
    """
    _require_empty(folder)
    try:
        require_folder(folder, _RESERVE)
    except OSError as error:
        raise _unwritable(folder, error) from error


def _require_empty(folder: Path) -> None:
    try:
        if not folder.exists() or not any(folder.iterdir()):
            return
    except OSError:
        pass  # a file, or a folder that cannot be read
    raise ConfigError(f"{folder} is not a new or empty folder; give another with --out")


def _unwritable(folder: Path, error: OSError) -> ConfigError:
    return ConfigError(
        f"cannot write to {folder}: {error.strerror} (a run needs {_RESERVE // 1_000_000} MB); give"
        " another folder with --out"
    )


class Recorder:
    """An observer that records a run.

    It reserves space on the disk at the start, so that the map can be saved when the disk is full.
    Trajectory and commands grow with each step; `finish` writes them anew, with the lines that they
    lack.

    `trajectory.tum` holds T_map_cam of the frame of every step as it was known when it arrived,
    `commands.csv` the command of every step, also if there was no base: stamp [s], velocity [m/s],
    angular velocity [rad/s] and who gave it. Where people may drive it holds all commands that the
    base was sent instead (`keep_commands`).
    """

    def __init__(self, folder: Path, config: Config) -> None:
        """Make the folder and write `config.toml` into it.

        Raises:
            ConfigError: the folder cannot be made, or is not empty, or has no space.
        """
        _require_empty(folder)
        try:
            folder.mkdir(parents=True, exist_ok=True)
            # The reserved file has no name: it vanishes with the program, however that ends.
            reserve = TemporaryFile(dir=folder)  # noqa: SIM115
            self._release_reserve = weakref.finalize(self, reserve.close)
            os.posix_fallocate(reserve.fileno(), 0, _RESERVE)
            write_config(config, folder / "config.toml")
            self._poses_file = GrowingFile(folder / "trajectory.tum", heading_of("camera"))
            self._commands_file = GrowingFile(folder / "commands.csv", _COLUMNS)
        except OSError as error:
            raise _unwritable(folder, error) from error
        self.folder = folder
        self._stamps: list[float] = []
        self._commands: list[tuple[float, str, Twist]] = []
        self._commands_written = 0
        self._commands_clock: Clock | None = None
        self._lead = -math.inf
        self._Ts_map_cam: list[SE3] = []
        self._xy: list[tuple[float, float]] = []
        self._reports: list[GoalReport] = []
        self._verdicts: dict[GoalReport, bool] = {}
        self._judged: list[dict[str, object]] = []
        self._judged_before: dict[GoalReport, list[dict[str, object]]] = {}
        self._snapshot: Callable[[], MapSnapshot | None] | None = None
        self._clock: Clock | None = None
        self._saved_at: float | None = None
        self._saving: Pending[None] | None = None
        self._saver = MapSaver(folder / "map")

    @property
    def steps(self) -> int:
        """Number of steps so far."""
        return len(self._stamps)

    @property
    def path_length(self) -> float:
        """Length of the base's estimated track [m]."""
        return float(np.linalg.norm(np.diff(np.reshape(self._xy, (-1, 2)), axis=0), axis=1).sum())

    def on_step(self, step: Step) -> None:
        """Record the pose and the command; a full disk costs lines until it has space again."""
        self._stamps.append(step.frame.stamp)
        if self._commands_clock is not None:
            self._lead = max(self._lead, step.frame.stamp - self._commands_clock.now())
        elif step.command is not None:
            self._commands.append((step.frame.stamp, "robot", step.command))
        self._Ts_map_cam.append(step.estimate.T_map_cam)
        self._xy.append((float(step.T_map_base[0, 3]), float(step.T_map_base[1, 3])))
        self._poses_file.add(pose_line(step.frame.stamp, step.estimate.T_map_cam))
        new = self._commands[self._commands_written :]
        self._commands_file.add(self._rows(new))
        self._commands_written += len(new)
        if self._snapshot is not None:
            self._keep_map(self._snapshot, step.frame.stamp)

    def keep_map(self, snapshot: Callable[[], MapSnapshot | None], clock: Clock) -> None:
        """Save the map every ten seconds beside the run: a killed program loses no more."""
        self._snapshot, self._clock = snapshot, clock

    def keep_commands(self, clock: Clock) -> Callable[[str, Twist], None]:
        """Record what the base is sent instead of what is decided in the steps.

        A repeated command is recorded once; it holds until the next one.

        Returns:
            A function to call with who gives a command and the command, by one thread at a time.
        """
        self._commands_clock = clock

        def keep(who: str, twist: Twist) -> None:
            if not self._commands or self._commands[-1][1:] != (who, twist):
                self._commands.append((clock.now(), who, twist))

        return keep

    def on_goal(self, report: GoalReport) -> None:
        """Record the report, and with it what people said on the way."""
        self._reports.append(report)
        self._judged_before[report], self._judged = self._judged, []

    def keep_verdict(self, report: GoalReport, confirmed: bool) -> None:
        """Record whether people say that what the robot has arrived at is the goal."""
        self._verdicts[report] = confirmed
        log.info(
            "%s: somebody says that it is %s", report.headline, "it" if confirmed else "not it"
        )

    def keep_verdict_on_way(self, place_xy: NDArray[np.float64], confirmed: bool) -> None:
        """Record whether people say that the candidate at (2,) in `map` [m] is the goal."""
        position = [round(float(value), 3) for value in place_xy]
        self._judged.append({"position": position, "confirmed": confirmed})

    @property
    def goals(self) -> list[dict[str, object]]:
        """The outcome of each goal, ready for JSON."""
        return [self._goal(report) for report in self._reports]

    def _goal(self, report: GoalReport) -> dict[str, object]:
        best, effort = report.candidates[0] if report.candidates else None, report.effort
        return {
            "text": report.text,
            "outcome": report.outcome,
            "reason": report.reason,
            "seconds": None if effort is None else round(effort.seconds, 1),
            "way": None if effort is None else round(effort.way, 2),
            "position": None if best is None else [round(float(v), 3) for v in best.position],
            "score": None if best is None else round(best.score, 4),
            "threshold": None if report.threshold is None else round(report.threshold, 4),
            "confirmed": self._verdicts.get(report),
            "judged_on_the_way": self._judged_before[report],
        }

    def _keep_map(self, snapshot: Callable[[], MapSnapshot | None], stamp: float) -> None:
        if self._saving is not None and not self._saving.ready():
            return
        if self._saved_at is None:
            self._saved_at = stamp
        if stamp - self._saved_at < _SAVED_EVERY or (kept := snapshot()) is None:
            return
        assert self._clock is not None
        self._saved_at = stamp
        self._saving = self._clock.start(lambda: self._save(kept), 0.0)

    def _save(self, snapshot: MapSnapshot) -> None:
        try:
            self._saver.save(snapshot)
        except Exception as error:  # the next one or the end tries again
            log.warning("the map is not saved just now: %s; the run goes on", error)

    def finish(
        self, bundle: Callable[[], MapBundle | None], metrics: Mapping[str, object]
    ) -> tuple[dict[str, object], BaseException | None]:
        """Write trajectory, commands, the map and, last, the metrics, which mark the run as ended.

        What cannot be written keeps nothing else from being written.

        `bundle` gives the map; None for none.

        Returns:
            The metrics with `map`, where the map is, and `map_error`, why there is none; and the
            first error.
        """
        self._release_reserve()
        unwritten = first_error(
            self._finish_saving,
            self._restore_folder,
            self._write_trajectory,
            self._write_commands,
        )
        folder = self.folder / "map"
        kept: dict[str, object] = {**metrics, "map": None, "map_error": "there was no frame"}

        def keep_map() -> None:
            if (last := bundle()) is not None:
                map_bundle.save(last, folder)
                kept.update(map=str(folder), map_error=None)

        if (lost := first_error(keep_map)) is not None:
            older = f"; an earlier map of this run is in {folder}" if is_readable(folder) else ""
            kept["map_error"] = one_line(lost) + older
        content = json.dumps(kept, indent=2) + "\n"
        unmarked = first_error(lambda: write_whole(self.folder / "metrics.json", content.encode()))
        return kept, lost or unwritten or unmarked

    def _finish_saving(self) -> None:
        if self._saving is not None:
            self._saving.result()

    def _restore_folder(self) -> None:
        """Make the folder again, which somebody may have removed meanwhile."""
        self._poses_file.close()
        self._commands_file.close()
        self.folder.mkdir(parents=True, exist_ok=True)

    def _write_trajectory(self) -> None:
        if self._stamps:
            write_trajectory(
                self.folder / "trajectory.tum", np.array(self._stamps), np.array(self._Ts_map_cam)
            )

    def _write_commands(self) -> None:
        table = _COLUMNS + self._rows(self._commands)
        write_whole(self.folder / "commands.csv", table.encode())

    def _rows(self, commands: Sequence[tuple[float, str, Twist]]) -> str:
        """Lines of commands, on the camera's clock as far as it is known."""
        # Frames carry the camera's clock; the frame that arrived soonest gives the offset.
        lead = self._lead if math.isfinite(self._lead) else 0.0
        table = io.StringIO()
        writer = csv.writer(table, lineterminator="\n")
        for at, who, twist in commands:
            writer.writerow((*(f"{v:.3f}" for v in (at + lead, twist.linear, twist.angular)), who))
        return table.getvalue()


def default_folder() -> Path:
    """`runs/<local time>`, with a number behind it if that is taken."""
    name = time.strftime("%Y-%m-%d_%H%M%S")
    folder = Path("runs") / name
    number = 1
    while folder.exists():
        number += 1
        folder = Path("runs") / f"{name}_{number}"
    return folder
