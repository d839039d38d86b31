"""What the kept rows say: figures by file, for the claims of pages."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from benchmarks.episodes.episode import EpisodeResult
from benchmarks.harness.scores import NavigationScore, Rate
from benchmarks.harness.store import Store
from benchmarks.slam.homes import FAULTS
from benchmarks.slam.lap_scores import LapResult, laps_result
from benchmarks.slam.relocalisation import StartResult

DEFAULT = "objectnav-default"
"""The row that the others of its folder are compared with."""

Facts = dict[str, Any]
"""Names and figures, nested; rates are in percent."""
_WEAKEST = 8
"""Number of the weakest phrasings of the embedded encoder that its page names."""


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
