"""The settings that a command works by."""

from __future__ import annotations

from pathlib import Path

from vizbot.config import Config, load_config


def load_settings(path: Path | None, clip: str | None) -> Config:
    """Read a file of settings, with the encoder that `--clip` names.

    Args:
        path: A TOML file; None for the defaults.
        clip: The encoder; None for that of the file.

    Raises:
        ConfigError: the file is missing, is not TOML, or has a wrong key or value.
    """
    config = load_config(path)
    return config if clip is None else config.model_copy(update={"clip": clip})
