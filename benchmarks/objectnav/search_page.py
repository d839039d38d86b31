"""`docs/results/search.md`: the search by belief beside the one before, and without its parts."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from pathlib import Path

from benchmarks.episodes.episode import EpisodeResult, HomeGoals
from benchmarks.episodes.oracles import ORACLES
from benchmarks.harness.bench_plan import (
    ABLATION_ROWS,
    ENCODER_ROWS,
    PAPER,
    SEARCHED,
    results_file,
)
from benchmarks.harness.scores import (
    NavigationScore,
    PairedCounts,
    interval_over_homes,
    path_weighted_success,
)
from benchmarks.harness.store import Store, StoredResult
from benchmarks.harness.tables import (
    fraction_text,
    interval_text,
    markdown_table,
    percent,
    percent_range,
)
from benchmarks.objectnav import absent, multi_goal
from benchmarks.objectnav.home_tables import homes_table, models_section
from benchmarks.objectnav.map_sections import map_sections
from benchmarks.objectnav.overshoot import overshoot_table
from benchmarks.objectnav.seen_section import seen_section
from benchmarks.objectnav.single_goal import DEFAULT, NAME, oracle_table

OLD = "old"
"""The row of the search before this one, driven at its last commit."""
_THIRD = {
    ENCODER_ROWS["clip"]: "the embedded encoder's cosines lie where those of ViT-L/14 do, in the"
    " same order, and their scale and bias are told",
    ENCODER_ROWS["offset"]: "each text has an offset, too, and each pair of patch and text an error"
    " (0.01 each)",
    ENCODER_ROWS["unknown"]: "cosines as of ViT-L/14, in the same order, whose scale and bias are"
    " not told, so that z-scores are all there is",
    PAPER: "the paper's own method",
    "scale 1": "patches of the coarsest scale alone",
    "true encoder": "the truth about what each patch shows",
}
"""Rows that are driven on a third of the episodes, and what each one is."""
PARTS = "_parts"
"""Ending of the folder beside that of the rows, which holds the search without each of its parts,
and whole by the same computer and commit."""
TRUE = "_true"
"""Ending of the folder beside that of the rows, which holds the failures, and as many successes,
driven with the truth about one part."""
_INTRODUCTION = """The search by belief (`default`) beside the one before it (`old`), in homes
that nobody had read, drawn before either was driven in them, each at one commit. Homes, encoder and
furniture split are ours. "Said wrongly" are episodes in which the robot said that it had arrived
and had not. SPL is success weighted by path length; its intervals, and those of differences, draw
whole homes again (cluster bootstrap, fixed seed), which is rough with so few homes. Differences of
success are decided by the exact paired test (McNemar)."""

_SURE = re.compile(r"(\d+)% sure")
"""How the robot says the probability of the place at which it stops."""
_SURE_EDGES = (0.0, 0.6, 0.7, 0.8, 0.9, 1.01)
"""Edges of the rows of the table of these probabilities."""
_NO_OLD = "The row `old` has not been driven whole yet, so nothing here is compared with it."

Row = Sequence[StoredResult[EpisodeResult]]


def search_page(folder: Path, page: Path) -> str:
    """The page of the kept rows of a folder; empty without the default row.

    Args:
        folder: Folder of the kept rows.
        page: The file that the text is for.
    """
    rows = {name: _row(folder, name) for name in (OLD, DEFAULT, *_THIRD)}
    rows = {name: row for name, row in rows.items() if row}
    if DEFAULT not in rows:
        return ""
    surveyed = Store(folder / "homes.jsonl", HomeGoals).fullest()
    homes = sorted((line.result for line in surveyed), key=lambda each: str(each.home))
    parts = [
        f"# {page.stem.replace('_', ' ').capitalize()}",
        _INTRODUCTION,
        "" if OLD in rows else _NO_OLD,
        _made_with(rows),
        "## All goals",
        _table(rows, (OLD, DEFAULT)),
    ]
    parts += [_differences(rows, (OLD,))]
    if third := [name for name in _THIRD if name in rows]:
        parts += ["## Other encoders and methods, on a third of the goals"]
        told = "; ".join(f"`{name}`: {_THIRD[name]}" for name in third)
        parts += [f"{told}.", _table(rows, third), _differences(rows, third)]
    parts += _without_parts(folder.with_name(folder.name + PARTS), rows[DEFAULT])
    parts += _with_true_parts(folder.with_name(folder.name + TRUE), rows[DEFAULT])
    parts += [_overshoot(folder), *map_sections(folder, page), _in_a_row(folder)]
    vain = Store(results_file(folder, absent.NAME, SEARCHED), EpisodeResult).fullest()
    parts += [_arrivals(rows[DEFAULT]), seen_section(_results(rows[DEFAULT]), _results(vain))]
    parts += ["## Failures", _failures(rows[DEFAULT])]
    parts += ["## Homes", homes_table(homes), models_section(homes)]
    return "\n\n".join(part for part in parts if part) + "\n"


def _row(folder: Path, name: str) -> list[StoredResult[EpisodeResult]]:
    return Store(results_file(folder, NAME, name), EpisodeResult).fullest()


def _without_parts(folder: Path, board: Row) -> list[str]:
    """The search without each of its parts, and how the whole one does beside the board's."""
    names = ABLATION_ROWS.values()
    rows = {name: row for name in (DEFAULT, *names) if (row := _row(folder, name))}
    if DEFAULT not in rows:
        return []
    whole = rows[DEFAULT]
    here, there = whole[0].hardware, board[0].hardware
    tables = [_table(rows, list(rows)), _differences(rows, list(rows))]
    title = "## Without its parts, on a fifth of the goals"
    if here == there:
        before = _results(board)
        same = sum(result in before for result in _results(whole))
        told = (
            f"Driven at commit {_each(line.commit for line in whole)}, the whole search as well: it"
            f" is what these rows are paired with. {same} of its {len(whole)} episodes are those of"
            " the board to the last digit."
        )
        return [title, told, *tables]
    both = {DEFAULT: board, f"{DEFAULT} on {here}": whole}
    other = list(both)[1:]
    return [
        title,
        f"Driven on {here}, the whole search as well: it is what these rows are paired with. The"
        f" other rows of this page are of {there}.",
        *tables,
        "## The same goals on another computer",
        _table(both, other),
        _differences(both, other),
    ]


def _with_true_parts(folder: Path, board: Row) -> list[str]:
    """What the truth about one part mends of the failures; empty where it was not driven."""
    rows = {f"true {part}": _row(folder, f"true {part}") for part in ORACLES}
    table = oracle_table(
        {name: _results(row) for name, row in rows.items()} | {DEFAULT: _results(board)}
    )
    if not table:
        return []
    commits = _each(line.commit for row in rows.values() for line in row)
    title = "## With the truth about one part"
    return [title, f"The failures, and as many successes drawn by lot, at commit {commits}.", table]


def _made_with(rows: Mapping[str, Row]) -> str:
    return "\n".join(
        f"- {name}: commit {_each(line.commit for line in row)},"
        f" {_each(line.hardware for line in row)}"
        for name, row in rows.items()
    )


def _each(values: Iterable[str]) -> str:
    """The different ones, the most frequent first, and how often each occurs where they differ."""
    counts = Counter(values).most_common()
    if len(counts) == 1:
        return counts[0][0]
    return " and ".join(f"{value} ({count} episodes)" for value, count in counts)


def _results(row: Row) -> list[EpisodeResult]:
    return [line.result for line in row]


def _table(rows: Mapping[str, Row], names: Sequence[str]) -> str:
    """A table of rows; those that were driven on a part have the default on that part below."""
    lines: list[list[object]] = []
    for name in names:
        if name not in rows:
            continue
        results = _results(rows[name])
        lines.append([name, *_figures(results)])
        driven = {result.episode for result in results}
        default = [each for each in _results(rows[DEFAULT]) if each.episode in driven]
        if name != DEFAULT and len(default) < len(rows[DEFAULT]):
            lines.append([f"{DEFAULT}, the same goals", *_figures(default)])
    header = ("row", "episodes", "reached", "95 % (Wilson)", "95 % over homes", "said wrongly",
              "SPL", "95 % of SPL", "steps", "driven [m]", "shortest [m]",
              "collisions")  # fmt: skip
    return markdown_table(header, list({tuple(line): line for line in lines}.values()))


def _figures(results: Sequence[EpisodeResult]) -> list[object]:
    score = NavigationScore.from_results(results)
    weighted = interval_over_homes(
        (each.episode.home, path_weighted_success(each.goals[0])) for each in results
    )
    return [
        score.success.trials, score.success, interval_text(score.success),
        percent_range(score.success_over_homes), fraction_text(score.said_wrongly),
        percent(score.spl), percent_range(weighted),
        "-" if score.steps is None else f"{score.steps:.0f}",
        score.path_of_successes and f"{score.path_of_successes:.1f}",
        score.shortest_of_successes and f"{score.shortest_of_successes:.1f}", score.collisions,
    ]  # fmt: skip


def spl_difference(
    ours: Sequence[EpisodeResult], theirs: Sequence[EpisodeResult]
) -> tuple[float, tuple[float, float] | None]:
    """By how much SPL is higher on the goals that both have driven, and its 95 % interval."""
    other = {each.episode: each.goals[0] for each in theirs}
    pairs = [
        (
            each.episode.home,
            path_weighted_success(each.goals[0]) - path_weighted_success(other[each.episode]),
        )
        for each in ours
        if each.episode in other
    ]
    mean = sum(value for _, value in pairs) / max(len(pairs), 1)
    return mean, interval_over_homes(pairs)


def _differences(rows: Mapping[str, Row], names: Sequence[str]) -> str:
    """The default paired with each of these rows."""
    ours, lines = _results(rows[DEFAULT]), []
    for name in names:
        if name not in rows or name == DEFAULT:
            continue
        theirs = _results(rows[name])
        pairs = PairedCounts.over(
            {each.episode: each.success for each in ours},
            {each.episode: each.success for each in theirs},
        )
        mean, interval = spl_difference(ours, theirs)
        lines.append(
            [f"{DEFAULT} against {name}", pairs.wins, pairs.losses, f"{pairs.p:.2g}",
             f"{100 * mean:+.1f}", percent_range(interval)]
        )  # fmt: skip
    header = ("paired", "only default reached", "only the other reached", "p", "SPL, difference",
              "95 % over homes")  # fmt: skip
    return markdown_table(header, lines) if lines else ""


def _in_a_row(folder: Path) -> str:
    """Four goals in a row over 3 m away, by both searches; empty where none was driven."""
    lines, driven = [], dict[str, Sequence[EpisodeResult]]()
    for name in (OLD, DEFAULT):
        path = results_file(folder, multi_goal.NAME, name)
        results = _results(Store(path, EpisodeResult).fullest())
        if not results:
            continue
        driven[name] = results
        rates = multi_goal.at_least_rates(results)
        over_homes = interval_over_homes(
            (each.episode.home, each.reached >= multi_goal.GOALS) for each in results
        )
        lines.append(
            [name, len(results), *(rate.count for rate in rates), interval_text(rates[-1]),
             percent_range(over_homes)]
        )  # fmt: skip
    header = ("episodes that reach at least", "of", "1", "2", "3", "4", "95 % of the last (Wilson)",
              "95 % of the last over homes")  # fmt: skip
    title = "## Four goals in a row, each over 3 m from where the robot stands"
    parts = [title, markdown_table(header, lines), _won_in_a_row(driven)]
    return "\n\n".join(part for part in parts if part) if lines else ""


def _won_in_a_row(driven: Mapping[str, Sequence[EpisodeResult]]) -> str:
    """The episodes in which one of the searches alone reached all four; empty without both."""
    if driven.keys() != {OLD, DEFAULT}:
        return ""
    ours, theirs = (
        {each.episode: each.success for each in driven[name]} for name in (DEFAULT, OLD)
    )
    pairs = PairedCounts.over(ours, theirs)
    return (
        f"Only {DEFAULT} reached all four {pairs.wins} times, only {OLD} {pairs.losses} times"
        f" (exact paired test, p = {pairs.p:.2g})."
    )


def _overshoot(folder: Path) -> str:
    """What is driven after a stop would have done; empty where it was not asked."""
    table = overshoot_table(folder, (OLD, DEFAULT))
    title = "## Driven after the robot first stood where a stop would have been a success"
    return f"{title}\n\n{table}" if table else ""


def _arrivals(row: Row) -> str:
    """How often the robot is wrong beside how often it says it may be; empty without arrivals."""
    said = [
        (int(sure[1]) / 100, goal.success)
        for goal in (result.goals[0] for result in _results(row))
        if goal.claimed and (sure := _SURE.match(goal.answer))
    ]
    lines: list[list[object]] = []
    for low, high in pairwise(_SURE_EDGES):
        these = [(p, right) for p, right in said if low <= p < high]
        if these:
            wrong, expected = sum(not right for _, right in these), sum(1 - p for p, _ in these)
            lines.append(
                [f"{low:.1f} to {min(high, 1.0):.1f}", len(these), wrong, f"{expected:.1f}"]
            )
    header = ("probability of the place", "said that it had arrived", "wrongly",
              "wrongly, by these probabilities")  # fmt: skip
    title = "## How sure the robot was where it said that it had arrived"
    return f"{title}\n\n{markdown_table(header, lines)}" if lines else ""


def _failures(row: Row) -> str:
    lines = [
        [f"home {r.episode.home}, {r.goals[0].text}", r.goals[0].reason, r.goals[0].answer,
         r.goals[0].steps]
        for r in _results(row)
        if not r.success
    ]  # fmt: skip
    if not lines:
        return "None."
    return markdown_table(("failed", "why", "what the robot said", "steps"), lines)
