"""Which settings file a command uses that was given none."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from mapping.clip.own_encoder import is_class_name
from vizbot.config import Config, load_config
from vizbot.core.errors import ConfigError
from vizbot.core.files import user_folder
from vizbot.core.method import Method
from vizbot.operator.printing import echo

if TYPE_CHECKING:  # loads the simulator
    from vizbot.rehearsal.config import RehearsalConfig

NAME = Path("robot.toml")
"""The settings file in the folder where a command is started."""
VARIABLE = "VIZBOT_CONFIG"
"""The environment variable that names a settings file."""


def load_settings(
    given: Path | None, clip: str | None = None, method: Method | None = None
) -> Config:
    """Read the settings of a command; a line on standard error names a file that was found.

    A file that merely lies in the folder where a command is started may be somebody else's. It
    names no code: a class is opened where `--clip`, a file that a person names, or the file in
    their home names it.

    Without a file `given` by `--config` it is looked for; `clip` and `method` replace the file's
    own.

    Raises:
        ConfigError: `VIZBOT_CONFIG` names what is not there, the file cannot be used, or one that
            was found in the working folder names a class.
    """
    path = settings_file(given)
    config = load_config(path, clip, method)
    if path is None or path == given:
        return config
    lies_here = _lies_here(path)
    if lies_here and clip is None and is_class_name(config.clip):
        raise ConfigError(
            f"configuration {path} was found in this folder and names a class, {config.clip}, which"
            f" is code that would run; if you trust it, name it: --clip {config.clip}, or --config"
            f" {path}"
        )
    echo(f"settings: {path}{', found in this folder' if lies_here else ''}", err=True)
    return config


def rehearsal_settings() -> type[RehearsalConfig] | None:
    """The settings of rehearsals; None where there is no simulator."""
    try:
        from vizbot.rehearsal.config import RehearsalConfig
    except ModuleNotFoundError:
        return None
    return RehearsalConfig


def with_rehearsal(config: Config) -> Config:
    """The same settings with every one of rehearsals, where there is a simulator.

    Raises:
        ConfigError: one of those has a wrong key or value.
    """
    rehearsal = rehearsal_settings()
    return config if rehearsal is None else rehearsal.read(config).within(config)


def _lies_here(path: Path) -> bool:
    """Whether a file was found in the working folder: nobody named it, and no home has it."""
    if path != NAME or os.environ.get(VARIABLE):
        return False
    mine = _in_home()
    return not (mine.exists() and mine.samefile(path))


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
    # A link that leads nowhere is meant to be a file: reading it says what is wrong.
    return next((place for place in (NAME, _in_home()) if os.path.lexists(place)), None)


def _in_home() -> Path:
    return user_folder("XDG_CONFIG_HOME", ".config") / NAME
