"""All pages with figures: the written ones are held against the rows, the others made from them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from vizbot.bench.claims.claims import read_claims
from vizbot.bench.claims.facts import kept_facts
from vizbot.bench.questions.page import questions_page
from vizbot.bench.slam.page import slam_page
from vizbot.core.errors import ConfigError
from vizbot.core.files import write_whole

RESULTS = Path("docs/results")
"""Folder of the pages, from the root of the repository; its rows and claims are in it."""
MADE: Mapping[str, Callable[[Path, Path], str]] = {"questions": questions_page, "slam": slam_page}
"""What makes a page from its folder of rows and its own path, by the name of both."""


def write_page(name: str) -> Path:
    """Write a page anew from its kept rows, and return its path."""
    path = RESULTS / f"{name}.md"
    write_whole(path, MADE[name](RESULTS / "rows" / name, path).encode())
    return path


def problems() -> list[str]:
    """Where README or a page does not say what the kept rows do, one line each.

    Raises:
        ConfigError: this is no folder of the repository, or a file in it cannot be read.
    """
    claims = RESULTS / "claims.toml"
    if not claims.is_file():
        raise ConfigError(f"{claims} is missing here; run it in the root of the repository")
    found = read_claims(claims).problems(Path(), kept_facts(RESULTS / "rows"))
    for name, made in MADE.items():
        path = RESULTS / f"{name}.md"
        if path.read_text(encoding="utf-8") != made(RESULTS / "rows" / name, path):
            found.append(f"{path} is not what its rows make; write it by `vizbot bench --pages`")
    return found
