"""What `vizbot config init`, `show` and `schema` do."""

from __future__ import annotations

import json
from pathlib import Path

from vizbot.commands.config.discovery import load_settings, settings_file, with_rehearsal
from vizbot.commands.config.settings_table import all_tables, settings_page, settings_schema
from vizbot.config import settings_toml
from vizbot.core.files import require_new, write_whole
from vizbot.operator.printing import echo


def init(out: Path, *, every: bool, force: bool) -> None:
    """Write a settings file with this machine's devices; `every` setting, or those for people.

    Raises:
        ConfigError: the file is there, or cannot be written.
    """
    require_new(out, replace=force)
    from vizbot.commands.config.robot_file import robot_file, seen_devices

    devices = seen_devices()
    write_whole(out, robot_file(all_tables(), devices, every=every).encode())
    for setting, seen in devices.items():
        echo(f"{setting}: {seen.remark}")
    echo(f"written: {out}")


def show(given: Path | None) -> None:
    """Print every effective setting as TOML, and on standard error where it comes from.

    Raises:
        ConfigError: the settings cannot be used.
    """
    config = with_rehearsal(load_settings(given))
    if settings_file(given) is None:
        echo("settings: the defaults, since no file was given or found", err=True)
    echo(settings_toml(config).rstrip())


def schema(*, markdown: bool) -> None:
    """Print each setting's description, default and bounds, as JSON schema or Markdown."""
    if markdown:
        echo(settings_page(all_tables()).rstrip())
    else:
        echo(json.dumps(settings_schema(), indent=2, ensure_ascii=False))
