"""Pages with figures: the rows make most of them, README's table, and sentences of the others."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from benchmarks.claims.claims import read_claims
from benchmarks.claims.facts import kept_facts
from benchmarks.claims.readme_table import with_table
from benchmarks.faults.page import faults_page
from benchmarks.objectnav.others_page import others_page
from benchmarks.objectnav.search_page import search_page
from benchmarks.planner.bench import planner_page
from benchmarks.questions.bench import questions_page
from benchmarks.slam.page import slam_page
from vizbot.core.errors import ConfigError
from vizbot.core.files import write_whole

RESULTS = Path("docs/results")
"""Folder of the pages, from the root of the repository; its rows and claims are in it."""
ROWS = RESULTS / "rows"
"""Folder of the folders of published rows."""
README = Path("README.md")
"""The page whose table of results is made."""
MADE: Mapping[str, Callable[[Path, Path], str]] = {
    "faults": faults_page,
    "others": others_page,
    "planner": planner_page,
    "questions": questions_page,
    "search": search_page,
    "slam": slam_page,
}
"""What makes a page from its folder of rows and its own path, by the name of both; it makes nothing
where rows are missing that the page cannot do without."""


def page_of(folder: Path) -> Path:
    """The page of a folder of rows: in `docs/results` for published ones, else beside it."""
    page = folder.with_suffix(".md")
    return RESULTS / page.name if page.parent.resolve() == ROWS.resolve() else page


def write_pages() -> list[Path]:
    """Write the pages, and README's table, anew from their kept rows; the paths of the pages."""
    texts = _made_pages()
    for path, text in texts.items():
        write_whole(path, text.encode())
    return list(texts)


def problems() -> list[str]:
    """Where README or a page does not say what the kept rows do, one line each.

    Raises:
        ConfigError: this is no folder of the repository, or a file in it cannot be read.
    """
    claims = RESULTS / "claims.toml"
    if not claims.is_file():
        raise ConfigError(f"{claims} is missing here; run it in the root of the repository")
    found = read_claims(claims).problems(Path(), kept_facts(ROWS))
    for path, text in _made_pages().items():
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            found.append(f"{path} is not what its rows make; write it by `vizbot bench --figures`")
    return found


def _made_pages() -> dict[Path, str]:
    texts = {
        (path := RESULTS / f"{name}.md"): made(ROWS / name, path) for name, made in MADE.items()
    }
    texts[README] = with_table(README.read_text(encoding="utf-8"), ROWS)
    return {path: text for path, text in texts.items() if text}
