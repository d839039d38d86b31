"""Which settings file a command uses that was given none."""

from __future__ import annotations

import os
from pathlib import Path

from vizbot.config import Config, load_config
from vizbot.core.errors import ConfigError
from vizbot.core.method import Method
from vizbot.operator.printing import echo

NAME = Path("robot.toml")
"""The settings file in the folder where a command is started."""
VARIABLE = "VIZBOT_CONFIG"
"""The environment variable that names a settings file."""


def load_settings(
    given: Path | None, clip: str | None = None, method: Method | None = None
) -> Config:
    """Read the settings of a command; a line on standard error names a file that was found.

    Args:
        given: The file of `--config`; without one it is looked for.
        clip: Encoder instead of the file's own.
        method: Method of search instead of the file's own.

    Raises:
        ConfigError: `VIZBOT_CONFIG` names what is not there, or the file cannot be used.
    """
    path = settings_file(given)
    config = load_config(path, clip, method)
    if path != given:
        echo(f"settings: {path}", err=True)
    return config


def settings_file(given: Path | None) -> Path | None:
    """The file of `--config`, else the first of three that is there; None for the defaults.

    Looked for are what `VIZBOT_CONFIG` names, `./robot.toml` and `~/.config/vizbot/robot.toml`, in
    this order.

    Raises:
        ConfigError: `VIZBOT_CONFIG` names what is not there.
    """
    if given is not None:
        return given
    named = os.environ.get(VARIABLE)
    if named:
        if not os.path.lexists(named):
            raise ConfigError(
                f"{VARIABLE} names {named}, which is not there; name a TOML file, or unset it"
            )
        return Path(named)
    # Unlike Path.home() this raises nothing for a user without a home, who then has no such file.
    home = os.environ.get("XDG_CONFIG_HOME") or os.path.expanduser("~/.config")  # noqa: PTH111
    places = (NAME, Path(home) / "vizbot" / NAME)
    # A link that leads nowhere is meant to be a file: reading it says what is wrong.
    return next((place for place in places if os.path.lexists(place)), None)
