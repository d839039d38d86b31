"""Claims: sentences of pages with figures, and whether the kept rows say the same.

`docs/results/claims.toml` lists them. A *claim* is a piece of a page, with fields in braces instead
of figures (`{bare[objectnav-default][percent]:.0f} %`); filled from the rows it must stand on
the page word for word. A *section* is a part of a page whose every number must be in a claim, or
among its *constants*, which are no results (a year, a limit, the paper's own figures).
"""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from benchmarks.episodes.episode import EpisodeResult
from benchmarks.harness.scores import NavigationScore, Rate
from benchmarks.harness.store import Store
from benchmarks.slam.homes import FAULTS
from benchmarks.slam.lap_scores import LapResult, laps_result
from benchmarks.slam.relocalisation import StartResult
from vizbot.core.errors import ConfigError
from vizbot.core.settings import SETTINGS

DEFAULT = "objectnav-default"
"""The row that the others of its folder are compared with."""
Facts = dict[str, Any]
"""Names and figures, nested; rates are in percent."""
_WEAKEST = 8
"""Number of the weakest phrasings of the embedded encoder that its page names."""
_NOT_TEXT = re.compile(r"<!-- (\w+): begin -->.*?<!-- \1: end -->|\]\([^)]*\)|`[^`]*`|<[^>]*>")
"""What the rows make, targets of links, code and HTML, in which no figure is looked for."""


def kept_facts(rows: Path) -> Facts:
    """Figures of the kept rows that claims name, by the folder and the file that hold them.

    A file `bare/objectnav-default.jsonl` becomes `["bare"]["objectnav-default"]`; a JSON file comes
    as it is, some with what follows from it.

    Raises:
        ConfigError: a line is no result.
    """
    facts: Facts = {}
    for path in sorted(rows.rglob("*.json*")):
        folder = path.relative_to(rows).parent
        inner = facts
        for part in folder.parts:
            inner = inner.setdefault(part, {})
        if path.suffix == ".json":
            inner[path.stem] = json.loads(path.read_text(encoding="utf-8"))
            if folder.name == "encoder":
                inner[path.stem] |= _encoder(inner[path.stem])
            elif "against" in inner[path.stem] and "rows" in inner[path.stem]:
                inner[path.stem] |= _two_commits(inner[path.stem]["rows"])
        elif path.stem == "mutants":
            inner[path.stem] = _mutants(path)
        elif path.stem.startswith("objectnav-"):
            inner[path.stem] = _navigation(path)
        elif folder.name == "slam" and path.stem == "homes":
            inner["laps"] = _laps(path.parent)
    for inner in facts.values():
        for name, row in inner.items():
            if name.startswith("objectnav-") and DEFAULT in inner:
                row["same_path"] = len(inner[DEFAULT]["tracks"].items() & row["tracks"].items())
    return facts


def rate_facts(rate: Rate, over_homes: tuple[float, float] | None = None) -> Facts:
    """A rate as figures: `count`, `of`, `percent`, and bounds of 95 % (Wilson; over homes)."""
    low, high = rate.interval()
    facts: Facts = {"count": rate.count, "of": rate.trials, "low": 100 * low, "high": 100 * high}
    facts["percent"] = None if rate.value is None else 100 * rate.value
    if over_homes is not None:
        facts |= {"homes_low": 100 * over_homes[0], "homes_high": 100 * over_homes[1]}
    return facts


def _mutants(path: Path) -> Facts:
    """What became of the mutants that do not fail at import, at first and last."""
    outcomes: dict[tuple[object, ...], list[str]] = {}
    commits: dict[str, None] = {}
    for line in map(json.loads, path.read_text(encoding="utf-8").splitlines()):
        name = (line["mutant"][key] for key in ("path", "kind", "before", "after", "number"))
        outcomes.setdefault(tuple(name), []).append(line["outcome"])
        commits[line["commit"]] = None
    ran = [each for each in outcomes.values() if each[-1] != "void"]
    return {
        "commits": ", ".join(commits),
        "drawn": len(ran),
        "killed": sum(each[-1] == "killed" for each in ran),
        "killed_at_first": sum(each[0] == "killed" for each in ran),
    }


def _navigation(path: Path) -> Facts:
    lines = Store(path, EpisodeResult).fullest()
    results = [line.result for line in lines]
    score = NavigationScore.from_results(results)
    return rate_facts(score.success, score.success_over_homes) | {
        "commit": " and ".join(dict.fromkeys(line.commit for line in lines)),
        "said_wrongly": rate_facts(score.said_wrongly),
        "spl": score.spl,
        "stuck": score.stuck,
        "tracks": {result.episode: result.track for result in results},
    }


def _laps(folder: Path) -> Facts:
    lines = Store(folder / "homes.jsonl", LapResult).fullest()
    starts = Store(folder / "starts.jsonl", StartResult).results_with_key(lines[0].key)
    return laps_result(tuple(FAULTS), [line.result for line in lines], starts, quick=False).summary


def _encoder(kept: Facts) -> Facts:
    """What the page says of an examination of the embedded encoder beside its own figures."""
    names, phrasings = kept["bare_names"], kept["phrasings_withheld"]["each"]
    weakest = sorted(phrasings.items(), key=lambda phrasing: float(phrasing[1]))[:_WEAKEST]
    patches = [patches for patches, _ in kept["combinations"]["each"].values()]
    return {
        "bare_percent": 100 * sum(names.values()) / len(names),
        "bare_classes": len(names),
        "weakest": ", ".join(f'"{phrasing}" {share:.2f}' for phrasing, share in weakest),
        "synonyms_asked": len(kept["synonyms"]["each"]),
        "absent_reaching": len(kept["absent_words"]["reaching"]),
        "fewest_patches": min(patches),
        "most_patches": max(patches),
    }


def _two_commits(rows: Sequence[Facts]) -> Facts:
    """Mean processor time of a tick here and there [ms], over the homes of `bench loop`."""
    of_homes = [row for row in rows if "home" in row]
    names = ("here_processor_ms", "there_processor_ms")
    return {name: sum(row[name] for row in of_homes) / len(of_homes) for name in names}


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
