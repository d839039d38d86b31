"""`vizbot bench`: the benchmarks of the checkout that this `vizbot` lies in."""

from __future__ import annotations

import importlib
import sys
import tomllib
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import typer

import vizbot
from vizbot.core.errors import ConfigError

_NAME = "benchmarks"


def run(context: typer.Context) -> None:
    """Hand all that was given after a command's name on to the benchmarks.

    Raises:
        ConfigError: there are no benchmarks beside this `vizbot`.
        VizbotError: a benchmark cannot be run.
    """
    _load_package(Path(vizbot.__file__).resolve().parents[1])
    benchmarks = typer.main.get_command(importlib.import_module(f"{_NAME}.app").app)
    arguments = list(context.args)
    with benchmarks.make_context(context.info_name, arguments, parent=context.parent) as inner:
        benchmarks.invoke(inner)


def _load_package(root: Path) -> None:
    """Import the package of benchmarks from this folder, whatever the path finds by its name."""
    file = root / _NAME / "__init__.py"
    if not file.is_file() or not _is_checkout(root):
        raise ConfigError("benchmarks come with the source; run them in a checkout of vizbot")
    loaded = sys.modules.get(_NAME)
    if loaded is not None and loaded.__file__ == str(file):
        return
    spec = spec_from_file_location(_NAME, file, submodule_search_locations=[str(file.parent)])
    assert spec is not None and spec.loader is not None
    sys.modules[_NAME] = package = module_from_spec(spec)
    spec.loader.exec_module(package)
    sys.path.insert(0, str(root))  # where the processes of a benchmark look first


def _is_checkout(root: Path) -> bool:
    """Whether a folder is that of vizbot's source."""
    try:
        project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError, KeyError):
        return False
    return bool(project.get("name") == "vizbot")
