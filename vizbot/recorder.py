"""The run's folder: configuration, trajectory, map, metrics; nothing half-written is left."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from mapping import map_bundle
from mapping.tum import write_trajectory
from vizbot.config import Config, write_config
from vizbot.core.errors import ConfigError
from vizbot.core.files import write_whole
from vizbot.core.observation import GoalReport, Step
from vizbot.core.types import SE3


def require_empty(folder: Path) -> None:
    """Refuse a folder that holds something; do so before the devices are opened.

    Raises:
        ConfigError: it is not new or empty.
    """
    try:
        if not folder.exists() or not any(folder.iterdir()):
            return
    except OSError:
        pass  # a file, or a folder that cannot be read
    raise ConfigError(f"{folder} is not a new or empty folder; give another with --out")


class Recorder:
    """An observer that keeps what a run leaves behind.

    `trajectory.tum` holds T_map_cam of the frame of every step as it was known when it arrived.
    """

    def __init__(self, folder: Path, config: Config) -> None:
        """Make the folder and write `config.toml` into it.

        Raises:
            ConfigError: the folder cannot be made, or is not empty.
        """
        require_empty(folder)
        try:
            folder.mkdir(parents=True, exist_ok=True)
            write_config(config, folder / "config.toml")
        except OSError as error:
            raise ConfigError(
                f"cannot write to {folder}: {error.strerror}; give another folder with --out"
            ) from error
        self.folder = folder
        self._stamps: list[float] = []
        self._Ts_map_cam: list[SE3] = []
        self._xy: list[tuple[float, float]] = []
        self.reports: list[GoalReport] = []

    @property
    def steps(self) -> int:
        """So far."""
        return len(self._stamps)

    @property
    def path_length(self) -> float:
        """Of the base's estimated track [m]."""
        return float(np.linalg.norm(np.diff(np.array(self._xy), axis=0), axis=1).sum())

    def on_step(self, step: Step) -> None:
        """Keep the pose."""
        self._stamps.append(step.frame.stamp)
        self._Ts_map_cam.append(step.estimate.T_map_cam)
        self._xy.append((float(step.T_map_base[0, 3]), float(step.T_map_base[1, 3])))

    def on_goal(self, report: GoalReport) -> None:
        """Keep the report."""
        self.reports.append(report)

    def finish(self, bundle: map_bundle.MapBundle | None, metrics: Mapping[str, object]) -> None:
        """Write the trajectory, the map and the metrics; the metrics come last, as the seal."""
        if self._stamps:
            write_trajectory(
                self.folder / "trajectory.tum", np.array(self._stamps), np.array(self._Ts_map_cam)
            )
        if bundle is not None:
            map_bundle.save(bundle, self.folder / "map")
        content = json.dumps(metrics, indent=2) + "\n"
        write_whole(self.folder / "metrics.json", content.encode())
