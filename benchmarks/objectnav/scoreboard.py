"""`docs/results/scoreboard.md`: the page of the scoreboard, written from the finished episodes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from benchmarks.episodes.episode import Episode, EpisodeResult, HomeGoals, Variant
from benchmarks.episodes.homes import survey
from benchmarks.harness.bench_plan import (
    BOARD,
    QUICK_SHARE,
    QUICK_SHARE_ROWS,
    UNATTENDED,
    results_file,
)
from benchmarks.harness.fingerprint import is_clean, is_oracle_key_of
from benchmarks.harness.store import Store, StoredResult
from benchmarks.harness.tables import markdown_table, percent
from benchmarks.objectnav import multi_goal, retrieval, single_goal
from benchmarks.objectnav.calibration_cost import EXACT, calibration_section
from benchmarks.objectnav.home_tables import (
    board_note,
    furniture_section,
    homes_table,
    models_section,
)
from benchmarks.objectnav.picture_section import drawn_pictures, kept_pictures, pictured
from benchmarks.objectnav.scale_comparison import scales_verdict
from vizbot.config import Config
from vizbot.core.files import write_whole

FIRST_LINE = (
    "Homes, encoder and furniture split are ours, not the paper's: these figures are no direct"
    " comparison with its own, which are quoted beside them."
)
TARGETS = (
    (single_goal.NAME, "episodes", "success_rate", "success of navigation", 0.87, 0.95),
    (single_goal.NAME, "others", "others_success_rate", "success, objects not in COCO", 0.93, None),
    (retrieval.NAME, "queries", "precision_at_1", "precision@1, the robot's answer", 0.83, 0.90),
    (retrieval.NAME, "queries", "most_similar_precision_at_1", "precision@1, the paper's own rule",
     0.83, 0.90),
    (multi_goal.NAME, "episodes", "four_in_a_row_rate", "four goals in a row", 0.44, 0.70),
)  # fmt: skip
"""Benchmark, keys of its summary (trials, rate), name of the rate, target, further aim."""
THREE_SCALES = (
    (single_goal.NAME, "single_scale_episodes", "single_scale_success_rate",
     "three_scale_success_rate", "", "success"),
    (retrieval.NAME, "queries", "single_scale_precision_at_1", "precision_at_1", "",
     "precision@1, the robot's answer"),
    (retrieval.NAME, "queries", "most_similar_single_scale_precision_at_1",
     "most_similar_precision_at_1", "most_similar_", "precision@1, the paper's own rule"),
)  # fmt: skip
"""Benchmark, keys of its summary (trials, best single scale, all three, prefix of the paired test),
name of the rate."""


def write_scoreboard_page(folder: Path, page: Path, config: Config = UNATTENDED) -> bool:
    """Write the page of a folder of episodes, and draw its pictures where its homes are the same.

    Without the whole default row of object-goal navigation nothing is written.

    Args:
        folder: Folder of the finished episodes.
        page: The file to write; its pictures lie in `pictures`, in a folder of its name.
        config: Settings of the robot that drove them.

    Returns:
        Whether the page was written.
    """
    default = _default_row(folder)
    if not default:
        return False
    chosen, section = pictured(_results(default)), None
    shown = {result.episode.home for result in chosen}
    # Pictures are drawn in homes as they are made today; of other ones the kept pictures stay.
    if all(survey(each.home) == each for each in _homes(folder) if each.home in shown):
        section = "\n\n".join(drawn_pictures(config, chosen, page, _pictures_of(page)))
    text = scoreboard_page(folder, page, config, section)
    write_whole(page, text.encode())
    return True


def scoreboard_page(
    folder: Path, page: Path, config: Config = UNATTENDED, pictures: str | None = None
) -> str:
    """The page of the scoreboard's own episodes; empty without the whole default row.

    Args:
        folder: The folder of the finished episodes.
        page: The file that the text is for; its links begin there.
        config: Settings of the robot that drove them.
        pictures: The section of its pictures; None for the section of the page as it is.
    """
    homes = _homes(folder)
    episodes = single_goal.single_goal_episodes(homes)
    if not _default_row(folder):
        return ""
    variants = [each for each in single_goal.variants(config) if not each.exact]
    rows = {v.name: _finished(folder, single_goal.NAME, v.name, episodes) for v in variants}
    left_out = _oracles_of_another_robot(variants, rows)
    driven = {
        name: _results(lines) for name, lines in rows.items() if lines and name not in left_out
    }
    count = multi_goal.episodes_in(homes)
    in_a_row = {
        row: _finished(
            folder,
            multi_goal.NAME,
            row,
            multi_goal.multi_goal_episodes(homes, count, far=row == multi_goal.OVER_3_M),
        )
        for row in (each.name for each in multi_goal.variants(config))
    }
    quick, exact = (_of_quick_share(folder, name) for name in (single_goal.DEFAULT, EXACT))
    seeds = {each.home for each in homes}
    explorations, answers = retrieval.retrieval_stores(folder)
    queries = answers.fullest(lambda answer: answer.home in seeds)
    results = {"Object-goal navigation": single_goal.single_goal_result(driven)}
    if queries:
        results["Retrieval"] = retrieval.retrieval_result(
            _results(queries),
            config.perception.clip_mapper.scales,
            [each for each in explorations.results_with_key(queries[0].key) if each.home in seeds],
        )
    if any(in_a_row.values()):
        results["Four goals in a row"] = multi_goal.multi_goal_result(
            {row: _results(lines) for row, lines in in_a_row.items() if lines}
        )
    made: dict[str, Sequence[StoredResult[Any]]] = {
        **{f"{single_goal.NAME}, {name}": lines for name, lines in rows.items()},
        retrieval.NAME: queries,
        **{f"{multi_goal.NAME}, {row}": lines for row, lines in in_a_row.items()},
        "quick share, default": quick,
        f"quick share, {EXACT}": exact,
    }
    parts = [FIRST_LINE, "# Scoreboard", _made_with(made)]
    if left_out:
        names = ", ".join(left_out)
        parts.append(f"Left out, as the default row was run with other sources: {names}.")
    parts.append(board_note(homes))
    summaries = {result.name: result.summary for result in results.values()}
    parts += [_targets(summaries), _scales_verdict(summaries, config.clip, page)]
    parts.append(_intervals_note(len(homes)))
    for title, result in results.items():
        parts += [f"## {title}", result.text]
    cost = calibration_section(_results(quick), _results(exact))
    parts += ["## What calibration and latency cost", cost] if cost else []
    chosen = pictured(_results(rows[single_goal.DEFAULT]))
    parts.append(kept_pictures(chosen, page, _pictures_of(page)) if pictures is None else pictures)
    parts += ["## Homes", homes_table(homes), models_section(homes)]
    parts += ["## Furniture", furniture_section()]
    return "\n\n".join(part for part in parts if part) + "\n"


def _pictures_of(page: Path) -> Path:
    return page.parent / "pictures" / page.stem


def _homes(folder: Path) -> list[HomeGoals]:
    """The homes of the board, as they were surveyed when it was driven."""
    lines = Store(folder / "homes.jsonl", HomeGoals).fullest(lambda goals: goals.home in BOARD)
    return sorted((line.result for line in lines), key=lambda goals: goals.home)


def _default_row(folder: Path) -> list[StoredResult[EpisodeResult]]:
    """The default row of the whole board; empty where it is not whole."""
    homes = _homes(folder)
    episodes = single_goal.single_goal_episodes(homes)
    row = _finished(folder, single_goal.NAME, single_goal.DEFAULT, episodes)
    return row if len(homes) == len(BOARD) and len(row) == len(episodes) else []


def _finished(
    folder: Path, bench: str, row: str, episodes: Sequence[Episode]
) -> list[StoredResult[EpisodeResult]]:
    """The stored results of the episodes that are finished, in the order of the episodes."""
    wanted = set(episodes)
    store = Store(results_file(folder, bench, row), EpisodeResult)
    lines = store.fullest(lambda result: result.episode in wanted)
    of_episode = {line.result.episode: line for line in lines}
    return [of_episode[episode] for episode in episodes if episode in of_episode]


def _of_quick_share(folder: Path, row: str) -> list[StoredResult[EpisodeResult]]:
    """The stored results of a row of the quick share, in the folder beside that of the board."""
    path = results_file(folder.with_name(QUICK_SHARE_ROWS), single_goal.NAME, row)
    return Store(path, EpisodeResult).fullest(lambda result: result.episode.home in QUICK_SHARE)


def _oracles_of_another_robot(
    variants: Sequence[Variant], rows: Mapping[str, Sequence[StoredResult[EpisodeResult]]]
) -> list[str]:
    """Oracle rows of a robot that did not drive the default row and cannot explain it."""
    robot = next((line.key for line in rows[single_goal.DEFAULT]), "none")
    return [
        variant.name
        for variant in variants
        if variant.oracle is not None
        and rows[variant.name]
        and not is_oracle_key_of(rows[variant.name][0].key, robot)
    ]


def _results(lines: Sequence[StoredResult[Any]]) -> list[Any]:
    return [line.result for line in lines]


def _made_with(rows: Mapping[str, Sequence[StoredResult[Any]]]) -> str:
    """The commits of the rows, and the machines."""
    of_commit: dict[str, list[str]] = {}
    for name, lines in rows.items():
        if lines:
            of_row = " and ".join(dict.fromkeys(line.commit for line in lines))
            of_commit.setdefault(of_row, []).append(name)
    machines = dict.fromkeys(line.hardware for lines in rows.values() for line in lines)
    parts = [f"Run on {', '.join(machines)}, at these commits of the sources:", ""]
    parts += [f"- {commit}: {'; '.join(names)}" for commit, names in of_commit.items()]
    commits = {line.commit for lines in rows.values() for line in lines}
    one = "All rows share one commit." if len(commits) == 1 else "Not all rows share one commit."
    parts += ["", one]
    if not all(map(is_clean, commits)):
        parts[-1] += " Where a + stands the sources differed from the commit: no claim."
    return "\n".join(parts)


def _targets(summaries: Mapping[str, Mapping[str, object]]) -> str:
    rows: list[list[object]] = []
    for name, of, key, what, target, further in TARGETS:
        summary = summaries.get(name, {})
        here = _rate(summary, key)
        reached = "not run" if here is None else "yes" if here >= target else "no"
        rows.append([what, percent(target), further and percent(further), percent(here),
                     summary.get(of), None, reached])  # fmt: skip
    for name, of, single_key, key, prefix, what in THREE_SCALES:
        summary = summaries.get(name, {})
        single, here = _rate(summary, single_key), _rate(summary, key)
        aim, over = f"three scales better than every single one, {what}", f"over {percent(single)}"
        pairs, better = None, "not run"
        if single is not None:
            wins, losses, p = (summary[f"{prefix}three_scale_{k}"] for k in ("wins", "losses", "p"))
            pairs = f"{wins} to {losses}, p = {p:.2g}"
            better = "yes" if summary[f"{prefix}three_scales_better"] else "not shown"
        rows.append([aim, over, None, percent(here), summary.get(of), pairs, better])
    header = ("must reach", "at least", "further aim", "here", "of", "won and lost pairs, p",
              "reached")  # fmt: skip
    return markdown_table(header, rows)


def _scales_verdict(summaries: Mapping[str, Mapping[str, object]], encoder: str, page: Path) -> str:
    """Whether the paper's central result is shown by the comparisons that were run."""
    better = [
        summaries.get(name, {}).get(f"{prefix}three_scales_better")
        for name, *_, prefix, _ in THREE_SCALES
    ]
    return scales_verdict([each for each in better if each is not None], encoder, page)


def _intervals_note(homes: int) -> str:
    return (
        "Wilson's intervals take each goal for a draw of its own. Intervals over homes draw whole"
        f" homes again (cluster bootstrap, fixed seed); with {homes} homes they are rough, and too"
        " narrow where the homes happen to be alike. Of the two intervals the wider one counts."
    )


def _rate(summary: Mapping[str, object], key: str) -> float | None:
    value = summary.get(key)
    return value if isinstance(value, float) else None
