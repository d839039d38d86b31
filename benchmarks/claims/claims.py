"""Claims: sentences of pages with figures, and whether the kept rows say the same.

`docs/results/claims.toml` lists them. A *claim* is a piece of a page, with fields in braces instead
of figures (`{bare[objectnav-default][percent]:.0f} %`); filled from the rows it must stand on
the page word for word. A *section* is a part of a page whose every number must be in a claim, or
among its *constants*, which are no results (a year, a limit, the paper's own figures).
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Sequence
from pathlib import Path

from pydantic import BaseModel, ValidationError

from benchmarks.claims.facts import Facts
from vizbot.core.errors import ConfigError
from vizbot.core.settings import SETTINGS

_NOT_TEXT = re.compile(r"<!-- (\w+): begin -->.*?<!-- \1: end -->|\]\([^)]*\)|`[^`]*`|<[^>]*>")
"""What the rows make, targets of links, code and HTML, in which no figure is looked for."""


class Section(BaseModel):
    """A part of a page in which every number must be accounted for."""

    model_config = SETTINGS

    page: str
    """File, from the root of the repository."""
    heading: str = ""
    """Heading that it begins with; it ends before the next of the same level. Empty: all of it."""
    constants: tuple[str, ...] = ()
    """Pieces of text whose numbers are no results."""


class Claim(BaseModel):
    """A piece of a page with figures."""

    model_config = SETTINGS

    page: str
    """File, from the root of the repository."""
    text: str
    """What must stand there; fields in braces are filled from the facts."""


class Claims(BaseModel):
    """All claims and sections, as they stand in the file."""

    model_config = SETTINGS

    section: tuple[Section, ...] = ()
    claim: tuple[Claim, ...] = ()

    def problems(self, root: Path, facts: Facts) -> list[str]:
        """What does not agree, one line each."""
        found, filled = list[str](), dict[str, list[str]]()
        for claim in self.claim:
            text = _plain(_page(root, claim.page))
            try:
                said = _plain(claim.text.format_map(facts))
            except (KeyError, IndexError, ValueError, TypeError, AttributeError) as error:
                found.append(f"{claim.page}: no row says {claim.text!r} ({error!r})")
                continue
            filled.setdefault(claim.page, []).append(said)
            if said not in text:
                found.append(f"{claim.page} does not say {said!r}, as the kept rows do")
        for section in self.section:
            body = _section(_page(root, section.page), section.heading)
            if body is None:
                found.append(f"{section.page} has no heading {section.heading!r}")
                continue
            left = _without(body, [*filled.get(section.page, ()), *section.constants])
            found += [
                f"{section.page}, {section.heading or 'whole page'}: {piece!r} is in no claim"
                for piece in left
            ]
        return found


def read_claims(path: Path) -> Claims:
    """The claims of a file.

    Raises:
        ConfigError: it cannot be read, or is no list of claims.
    """
    try:
        return Claims.model_validate(tomllib.loads(path.read_text(encoding="utf-8")))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError, ValidationError) as error:
        raise ConfigError(f"claims {path} cannot be read: {error}") from error


def _page(root: Path, page: str) -> str:
    path = root / page
    if not path.is_file():
        raise ConfigError(f"page {page} of a claim is missing; write it, or drop the claim")
    return path.read_text(encoding="utf-8")


def _plain(text: str) -> str:
    """The text with single spaces, however its lines are broken."""
    return " ".join(text.split())


def _section(page: str, heading: str) -> str | None:
    if not heading:
        return page
    lines = page.splitlines()
    for i, line in enumerate(lines):
        level = len(line) - len(line.lstrip("#"))
        if level and line[level:].strip() == heading:
            ends = (
                j for j in range(i + 1, len(lines))
                if re.match(rf"#{{1,{level}}} ", lines[j])
            )  # fmt: skip
            return "\n".join(lines[i + 1 : next(ends, len(lines))])
    return None


def _without(text: str, accounted: Sequence[str]) -> list[str]:
    """Pieces of the text with a number that is in none of the accounted texts."""
    left = _plain(text)
    for piece in sorted(map(_plain, accounted), key=len, reverse=True):
        left = left.replace(piece, " ~ ")
    left = _NOT_TEXT.sub("] ", left)
    return [left[max(0, m.start() - 40) : m.end() + 20] for m in re.finditer(r"\d[\d.,]*", left)]
