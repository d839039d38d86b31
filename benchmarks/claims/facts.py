"""What the kept rows say: figures by benchmark and row, for the claims of README and pages."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import mean
from typing import Any

from benchmarks.episodes.absent_things import ThingAnswer
from benchmarks.episodes.episode import EpisodeResult, QueryResult
from benchmarks.faults.bench import DRIVES_BY_DEFAULT, MISSIONS_BY_DEFAULT
from benchmarks.faults.page import drives_in, missions_in
from benchmarks.faults.totals import DefaultResults, FaultTotals
from benchmarks.harness.bench_plan import SEARCHED, results_file
from benchmarks.harness.scores import NavigationScore, PairedCounts, Rate, interval_over_homes
from benchmarks.harness.store import Store, StoredResult
from benchmarks.objectnav import absent
from benchmarks.objectnav.multi_goal import at_least_rates, within_reach
from benchmarks.objectnav.overshoot import Overshoot, ways_before_and_after
from benchmarks.objectnav.retrieval import retrieval_result
from benchmarks.objectnav.seen_section import seen_rate
from benchmarks.objectnav.single_goal import SCALES
from benchmarks.slam.homes import FAULTS
from benchmarks.slam.hours import DrivenHours, hours_result
from benchmarks.slam.lap_scores import LapResult, laps_result
from benchmarks.slam.relocalisation import StartResult

DEFAULT, IN_A_ROW = "objectnav-default", "multi-default"
"""The rows that the others of their folder are paired with."""

Facts = dict[str, Any]
"""Names and figures, nested; rates are in percent."""
_WEAKEST = 8
"""Number of the weakest phrasings of the embedded encoder that its page names."""


def kept_facts(rows: Path) -> Facts:
    """Figures of all kept rows, by the folder and the file that hold them.

    A file `scoreboard/objectnav-default.jsonl` becomes `["scoreboard"]["objectnav-default"]`;
    a JSON file comes as it is, some with what follows from it. Default rows are paired, under
    `against`, with those of the other folders that share episodes with them.

    Args:
        rows: Folder of the kept rows.

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
        elif path.stem.startswith("multi-"):
            inner[path.stem] = _multi(Store(path, EpisodeResult).fullest())
        elif path.stem.startswith("retrieval-queries"):
            inner[path.stem] = _retrieval(Store(path, QueryResult).fullest())
        elif path == results_file(path.parent, absent.NAME, SEARCHED):
            inner[path.stem] = _vain(Store(path, EpisodeResult).fullest())
        elif path.stem.startswith(f"{absent.NAME}-"):
            inner[path.stem] = _absent(Store(path, ThingAnswer).fullest())
        elif path.stem.startswith("overshoot-"):
            inner[path.stem] = _overshoot(Store(path, Overshoot).fullest())
        elif path.stem.startswith(("objectnav-", "later-")):
            inner[path.stem] = _navigation(Store(path, EpisodeResult).fullest())
        elif folder.name == "slam" and path.stem == "homes":
            inner["laps"] = _laps(path.parent)
        elif folder.name == "slam" and path.stem == "hours":
            inner["hours"] = _hours(path)
        elif folder.name == "faults" and path.stem == "drives":
            inner["totals"] = _fault_totals(path.parent)
    for inner in facts.values():
        for name, row in inner.items():
            default = inner.get(IN_A_ROW if name.startswith("multi-") else DEFAULT)
            if default is not None and "reached" in row:
                row["default_against"] = _against(default, row)
    defaults = {name: inner[DEFAULT] for name, inner in facts.items() if DEFAULT in inner}
    for name, row in defaults.items():
        row["against"] = {
            other: _against(row, theirs)
            for other, theirs in defaults.items()
            if other != name and row["reached"].keys() & theirs["reached"].keys()
        }
    return facts


def rate_facts(rate: Rate, over_homes: tuple[float, float] | None = None) -> Facts:
    """A rate as figures: `count`, `of`, `percent`, and bounds of 95 % (Wilson; over homes)."""
    low, high = rate.interval()
    facts: Facts = {"count": rate.count, "of": rate.trials, "low": 100 * low, "high": 100 * high}
    facts["percent"] = None if rate.value is None else 100 * rate.value
    if over_homes is not None:
        facts |= {"homes_low": 100 * over_homes[0], "homes_high": 100 * over_homes[1]}
    return facts


def _against(ours: Facts, theirs: Facts) -> Facts:
    """Two rows paired by what they reach, and how many paths they have in common."""
    facts = _paired(ours["reached"], theirs["reached"])
    if "tracks" in theirs:
        facts["same_path"] = len(ours["tracks"].items() & theirs["tracks"].items())
    return facts


def _made(lines: Sequence[StoredResult[Any]]) -> Facts:
    return {"commit": " and ".join(dict.fromkeys(line.commit for line in lines))}


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


def _navigation(lines: Sequence[StoredResult[EpisodeResult]]) -> Facts:
    results = [line.result for line in lines]
    score = NavigationScore.from_results(results)
    return _made(lines) | rate_facts(score.success, score.success_over_homes) | {
        "coco": rate_facts(score.coco),
        "others": rate_facts(score.others),
        "said_wrongly": rate_facts(score.said_wrongly),
        "spl": score.spl,
        "stuck": score.stuck,
        "steps": score.steps,
        "driven": score.path_of_successes,
        "shortest": score.shortest_of_successes,
        "collisions": score.collisions,
        "reached": {result.episode: result.success for result in results},
        "tracks": {result.episode: result.track for result in results},
    }  # fmt: skip


def _multi(lines: Sequence[StoredResult[EpisodeResult]]) -> Facts:
    results = [line.result for line in lines]
    over_homes = interval_over_homes((r.episode.home, r.success) for r in results)
    facts = _made(lines)
    for number, rate in enumerate(at_least_rates(results), start=1):
        facts[f"at_least_{number}"] = rate_facts(rate)
    facts["of_home"] = Counter(result.episode.home for result in results)
    facts["asked_for"] = Counter(goal.text for result in results for goal in result.goals)
    facts["ended_at"] = Counter(r.goals[-1].text for r in results if not r.success)
    facts["ended_in"] = Counter(r.episode.home for r in results if not r.success)
    facts["ended"] = facts["ended_at"].total()
    facts["said_wrongly"] = sum(g.claimed and not g.success for r in results for g in r.goals)
    facts["steps"] = mean(goal.steps for result in results for goal in result.goals)
    facts["within_reach"] = rate_facts(within_reach(results))
    facts["reached"] = {result.episode: result.success for result in results}
    facts["all"] = rate_facts(Rate.over(result.success for result in results), over_homes)
    return facts


def _retrieval(lines: Sequence[StoredResult[QueryResult]]) -> Facts:
    answers = [line.result for line in lines if line.result.exists]
    facts = _made(lines)
    rights: dict[str, dict[str, dict[Any, bool]]] = {}
    for scales in dict.fromkeys(answer.scales for answer in answers):
        of_scales = [a for a in answers if a.scales == scales]
        name = _scales(scales)
        rights[name] = {
            "answer": {(a.home, a.text): a.correct for a in of_scales},
            "most_similar": {(a.home, a.text): a.most_similar_correct for a in of_scales},
        }
        facts[name] = {
            rule: rate_facts(
                Rate.over(right.values()),
                interval_over_homes((home, each) for (home, _), each in right.items()),
            )
            for rule, right in rights[name].items()
        }
    for name, by_rule in rights.items():
        for rule, right in by_rule.items():
            facts[name][rule]["all_against"] = _paired(rights[_scales(SCALES)][rule], right)
        facts[name]["answer_against_most_similar"] = _paired(
            by_rule["answer"], by_rule["most_similar"]
        )
    result = retrieval_result([line.result for line in lines], SCALES)
    return facts | {name: result.summary[name] for name in ("calibration_error", "log_loss")}


def _absent(lines: Sequence[StoredResult[ThingAnswer]]) -> Facts:
    answers = [line.result for line in lines]
    facts = _made(lines) | {
        kind: rate_facts(absent.refused_rate([a for a in answers if a.kind == kind]))
        for kind in ("elsewhere", "nowhere")
    }
    facts["refused"] = rate_facts(absent.refused_rate(answers))
    return facts | {"found": rate_facts(absent.found_rate(answers))}


def _vain(lines: Sequence[StoredResult[EpisodeResult]]) -> Facts:
    """Searches for what is not there."""
    goals = [goal for line in lines for goal in line.result.goals]
    return _made(lines) | {
        "refused": rate_facts(Rate.over(map(absent.is_refusal, goals))),
        "claimed": rate_facts(Rate.over(goal.claimed for goal in goals)),
        "steps": sum(goal.steps for goal in goals) / max(len(goals), 1),
        "seen_close": rate_facts(seen_rate(filter(absent.is_refusal, goals))),
    }


def _overshoot(lines: Sequence[StoredResult[Overshoot]]) -> Facts:
    before, after = ways_before_and_after([line.result for line in lines])
    return _made(lines) | {
        "of": len(lines), "stood": len(before), "before": mean(before), "after": mean(after)
    }  # fmt: skip


def _laps(folder: Path) -> Facts:
    lines = Store(folder / "homes.jsonl", LapResult).fullest()
    key = lines[0].key if lines else ""
    starts = Store(folder / "starts.jsonl", StartResult).results_with_key(key)
    result = laps_result(tuple(FAULTS), [line.result for line in lines], starts, quick=False)
    rows = {str(row["row"]): row for row in result.rows}
    return _made(lines) | {"rows": rows} | result.summary


def _hours(path: Path) -> Facts:
    newest = Store(path, DrivenHours).all()[-1]
    return _made([newest]) | hours_result(newest.result).summary


def _fault_totals(folder: Path) -> Facts:
    drives = drives_in(folder / "drives.jsonl")
    missions = missions_in(folder / "missions.jsonl")
    ours = [line.result for line in missions]
    scores = [line.result for line in drives]
    totals = FaultTotals.count(scores, ours)
    undisturbed = Rate.over(m.reached for m in ours if not m.mission.faults)
    by_default = _faults_by_default(folder)
    return _made(drives) | {
        "drives": totals.drives,
        "missions": totals.missions,
        "stopped": rate_facts(totals.stopped),
        "reached": rate_facts(totals.reached),
        "undisturbed": rate_facts(undisturbed),
        "crashes": len(totals.crashes),
        "maps_lost": totals.maps_lost,
        "strayed": totals.strayed,
        "astray_most": max((s.astray_max or 0.0 for s in scores), default=0.0),
        "silent": totals.silent,
        "default_drives": sum(len(score.series.seeds) for score in by_default.scores),
        "default_missions": len(by_default.missions),
        "default_ended": sum(m.ended_by_default for m in by_default.missions),
        "default_right": rate_facts(by_default.right),
        "default_commit": _made(drives_in(folder / DRIVES_BY_DEFAULT))["commit"],
    }


def _faults_by_default(folder: Path) -> DefaultResults:
    drives = drives_in(folder / DRIVES_BY_DEFAULT)
    missions = missions_in(folder / MISSIONS_BY_DEFAULT)
    return DefaultResults([line.result for line in drives], [line.result for line in missions])


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


def _scales(scales: tuple[int, ...]) -> str:
    """A set of scales as a key that a claim can name: "scales 1 0 -1"."""
    return " ".join(["scales", *map(str, scales)])


def _paired(first: Mapping[Any, bool], second: Mapping[Any, bool]) -> Facts:
    """Two ways to do the same trials: `wins` and `losses` of the first, and `p`."""
    counts = PairedCounts.over(first, second)
    return {"wins": counts.wins, "losses": counts.losses, "p": counts.p}
