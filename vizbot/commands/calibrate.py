"""`vizbot calibrate`: drive, measure, and write the figures into the robot's settings."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import tomlkit
from rich.console import Console
from rich.table import Table

from vizbot.calibration.drive import record
from vizbot.calibration.solve import Calibration, solve
from vizbot.commands.config.discovery import load_settings, settings_file
from vizbot.commands.options import CalibrateOptions
from vizbot.config import Config, load_config
from vizbot.core.errors import ConfigError
from vizbot.core.files import require_writable, write_whole
from vizbot.core.interfaces import Devices
from vizbot.operator.printing import echo
from vizbot.rig import opened_devices, require_devices

_LONGEST_LINE = 1000
"""Letters of an answer that are read at most."""


def run(options: CalibrateOptions) -> None:
    """Calibrate, print what was measured, and write it to `out` or back to the settings file.

    Raises:
        VizbotError: the settings cannot be written, nobody confirmed the drive, a device is
            missing, or the robot saw too little or touched something.
    """
    camera, base = options.camera, options.base
    settings = settings_file(options.config)
    config, into = load_settings(options.config), options.out or settings
    if into is not None:
        require_writable(into)
        load_config(_source(settings, into))
    if base == "none":
        raise ConfigError("nothing can be calibrated with --base none; use roomba or sim")
    if base not in ("sim", "roomba"):
        raise ConfigError(f"unknown base {base!r}; use roomba or sim")
    if camera not in ("sim", "realsense"):
        raise ConfigError(f"--camera {camera} cannot be calibrated; use realsense or sim")
    if "sim" in (camera, base):
        from vizbot.rehearsal.choice import choose

        choose(camera, base, options.world)
    require_devices(config, camera, base)
    if not options.yes and base == "roomba":
        echo("The robot turns twice to each side and drives 1.5 m ahead and back.")
        echo("2 m ahead must be free. Enter to start.")
        if not sys.stdin.readline(_LONGEST_LINE):
            raise ConfigError("nobody confirmed that the robot may drive; use --yes")
    with _opened(config, options) as devices:
        samples = record(devices, config, lambda line: echo(line, err=True))
    found = solve(samples, config)
    written = False
    try:  # written before it is printed, which may fail
        if into is not None:
            write_whole(into, updated(_source(settings, into), found).encode())
            written = True
    finally:  # whatever has become of the file during the drive
        _print(found, config)
        if written:
            echo(f"written to {into}")
        else:
            by_hand = tomlkit.dumps(_settings(found))
            echo(f"\nadd this to the robot's settings:\n\n{by_hand}")


@contextmanager
def _opened(config: Config, options: CalibrateOptions) -> Iterator[Devices]:
    if "sim" not in (options.camera, options.base):
        with opened_devices(config, options.camera, options.base) as devices:
            yield devices
        return
    from vizbot.rehearsal.rig import Rig

    with Rig(config, options.camera, options.base, options.world) as rig:
        yield rig.devices


def updated(config_path: Path | None, found: Calibration) -> str:
    """The settings of a file, comments and all, with the figures that were found.

    Raises:
        ConfigError: the file is missing, is not TOML, or has a wrong key or value.
    """
    load_config(config_path)
    text = "" if config_path is None else config_path.read_text(encoding="utf-8-sig")
    document = tomlkit.parse(text)
    for section, values in _settings(found).items():
        if section == "calibration":  # its date is that of all of it
            document[section] = values
            continue
        table = document.setdefault(section, tomlkit.table())
        for key, value in values.items():
            table[key] = value
    return tomlkit.dumps(document)


def _source(config_path: Path | None, into: Path) -> Path | None:
    """The file whose settings are written beside the figures: `into` itself if it is there."""
    return into if into.exists() else config_path


def _settings(found: Calibration) -> dict[str, dict[str, Any]]:
    return {
        "mount": found.mount.model_dump(),
        "roomba": {"wheel_base": found.wheel_base, "wheel_scale": found.wheel_scale},
        "calibration": found.calibration.model_dump(mode="json", exclude_none=True),
    }


def _print(found: Calibration, before: Config) -> None:
    table = Table(box=None, pad_edge=False)
    for column in ("", "before", "now"):
        table.add_column(column)
    for section, values in _settings(found).items():
        old = getattr(before, section).model_dump()
        for key, value in values.items():
            if not isinstance(value, Mapping):
                table.add_row(f"{section}.{key}", str(old[key]), str(value))
    for key, value in found.calibration.residuals:
        table.add_row(f"left unexplained: {key}", "", str(value))
    Console().print(table)
