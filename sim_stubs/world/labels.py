"""Labels of a world in a file by others: a TOML file with lines `"NAME IN THE WORLD" = "label"`."""

from __future__ import annotations

import tomllib
from pathlib import Path

from vizbot.core.errors import ConfigError
from vizbot.core.files import read_regular

_LARGEST = 1024 * 1024
"""Size of a file of labels that is read [bytes]."""


def read_labels(path: Path) -> dict[str, str]:
    """The labels in a file by the name of the body or geom, in lower case with single spaces.

    Raises:
        ConfigError: it cannot be read, or a label is empty or no text.
    """
    try:
        table = tomllib.loads(read_regular(path, _LARGEST).decode("utf-8-sig"))
    except (OSError, ValueError, RecursionError) as error:
        reason = " ".join(str(error).split())
        raise ConfigError(
            f'labels {path} cannot be read ({reason}); give lines like kettle = "yellow kettle"'
        ) from error
    labels = {}
    for name, label in table.items():
        words = label.casefold().split() if isinstance(label, str) else []
        if not words:
            raise ConfigError(
                f'labels {path}: the label {label!r} of {name!r} is no text; give "yellow kettle"'
            )
        labels[name] = " ".join(words)
    return labels
