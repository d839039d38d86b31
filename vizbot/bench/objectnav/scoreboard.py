"""`docs/results/scoreboard.md`: the page of the scoreboard, written from the finished episodes."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from sim_stubs.homes.furniture.catalogue import read_catalogue
from sim_stubs.homes.furniture.split import counts
from sim_stubs.homes.textures import surfaces
from sim_stubs.scoring.goals import GOALS
from vizbot.bench.episodes.episode import Episode, EpisodeResult, HomeGoals, Variant
from vizbot.bench.harness.bench_plan import BenchPlan, BenchResult, goals_of_homes, results_file
from vizbot.bench.harness.fingerprint import is_clean, is_oracle_key_of
from vizbot.bench.harness.store import Store, StoredResult
from vizbot.bench.harness.tables import markdown_table, percent
from vizbot.bench.harness.workers import in_parallel
from vizbot.bench.objectnav import multi_goal, retrieval, single_goal
from vizbot.bench.objectnav.episode_pictures import Picture, draw_episode
from vizbot.config import Config
from vizbot.core.files import write_whole

FIRST_LINE = (
    "Homes, encoder and furniture split are ours, not the paper's: these figures are no direct"
    " comparison with its own, which are quoted beside them."
)
TARGETS = (
    (single_goal.NAME, "episodes", "success_rate", "success of navigation", 0.87, 0.95),
    (single_goal.NAME, "others", "others_success_rate", "success, objects not in COCO", 0.93, None),
    (retrieval.NAME, "queries", "precision_at_1", "precision@1, where views agree", 0.83, 0.90),
    (retrieval.NAME, "queries", "most_similar_precision_at_1", "precision@1, the paper's own rule",
     0.83, 0.90),
    (multi_goal.NAME, "episodes", "four_in_a_row_rate", "four goals in a row", 0.44, 0.70),
)  # fmt: skip
"""Benchmark, keys of its summary (trials, rate), name of the rate, target, further aim."""
THREE_SCALES = (
    (single_goal.NAME, "single_scale_episodes", "single_scale_success_rate",
     "three_scale_success_rate", "success"),
    (retrieval.NAME, "queries", "single_scale_precision_at_1", "precision_at_1", "precision@1"),
)  # fmt: skip
"""Benchmark, keys of its summary (trials, best single scale, all three), name of the rate."""
_PICTURES = 6
"""Most pictures of failures, and of successes."""


def write_scoreboard_page(plan: BenchPlan, page: Path, pictures: Path) -> None:
    """Write the page and the pictures that it shows, of the scoreboard's own episodes alone.

    Args:
        plan: The plan whose folder holds the finished episodes.
        page: The file to write.
        pictures: The folder of its pictures; other pictures in it are deleted.
    """
    homes = goals_of_homes(plan, single_goal.EPISODES, single_goal.HOMES)
    episodes = single_goal.single_goal_episodes(homes)
    variants = single_goal.variants(plan.config)
    rows = {v.name: _finished(plan, single_goal.NAME, v.name, episodes) for v in variants}
    left_out = _oracles_of_another_robot(variants, rows)
    driven = {
        name: _results(lines) for name, lines in rows.items() if lines and name not in left_out
    }
    in_a_row = _finished(
        plan,
        multi_goal.NAME,
        multi_goal.DEFAULT,
        multi_goal.multi_goal_episodes(homes[: multi_goal.HOMES]),
    )
    seeds = {each.home for each in homes}
    explorations, answers = retrieval.retrieval_stores(plan.folder)
    queries = answers.fullest(lambda answer: answer.home in seeds)
    results: dict[str, BenchResult] = {}
    if driven:
        results["Object-goal navigation"] = single_goal.single_goal_result(driven)
    if queries:
        results["Retrieval"] = retrieval.retrieval_result(
            _results(queries),
            plan.config.perception.clip_mapper.scales,
            [each for each in explorations.results_with_key(queries[0].key) if each.home in seeds],
        )
    if in_a_row:
        results["Four goals in a row"] = multi_goal.multi_goal_result(_results(in_a_row))
    made: dict[str, Sequence[StoredResult[Any]]] = {
        **{f"{single_goal.NAME}, {name}": lines for name, lines in rows.items()},
        retrieval.NAME: queries,
        multi_goal.NAME: in_a_row,
    }
    parts = [FIRST_LINE, "# Scoreboard", _made_with(made)]
    if left_out:
        names = ", ".join(left_out)
        parts.append(f"Left out, as the default row was run with other sources: {names}.")
    parts.append(_targets(list(results.values())))
    for title, result in results.items():
        parts += [f"## {title}", result.text]
    default = rows[single_goal.DEFAULT]
    # Pictures show the homes of the current sources.
    if (
        default
        and default[0].key == plan.fingerprint.key_of(variants[0])
        and plan.fingerprint.still_holds()
    ):
        parts += _pictures(plan.config, pictured(_results(default)), page, pictures)
    parts += ["## Homes", _homes_table(homes), "## Furniture", _furniture_section()]
    write_whole(page, ("\n\n".join(part for part in parts if part) + "\n").encode())


def pictured(results: Sequence[EpisodeResult]) -> list[EpisodeResult]:
    """Failures, then successes, chosen by a fixed seed, each in the order of the episodes.

    An episode without a track is never chosen.
    """
    rng = np.random.default_rng(0)
    chosen: set[int] = set()
    for success in (False, True):
        alike = [
            i for i, result in enumerate(results) if result.success is success and result.track
        ]
        chosen |= set(rng.permutation(alike)[:_PICTURES].tolist())
    return [results[i] for i in sorted(chosen, key=lambda i: (results[i].success, i))]


def _finished(
    plan: BenchPlan, bench: str, row: str, episodes: Sequence[Episode]
) -> list[StoredResult[EpisodeResult]]:
    """The stored results of the episodes that are finished, in the order of the episodes."""
    wanted = set(episodes)
    store = Store(results_file(plan.folder, bench, row), EpisodeResult)
    lines = store.fullest(lambda result: result.episode in wanted)
    of_episode = {line.result.episode: line for line in lines}
    return [of_episode[episode] for episode in episodes if episode in of_episode]


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


def _targets(results: Sequence[BenchResult]) -> str:
    of_name = {result.name: result.summary for result in results}
    rows: list[list[object]] = []
    for name, of, key, what, target, further in TARGETS:
        summary = of_name.get(name, {})
        here = _rate(summary, key)
        reached = "not run" if here is None else "yes" if here >= target else "no"
        rows.append([what, percent(target), further and percent(further), percent(here),
                     summary.get(of), reached])  # fmt: skip
    for name, of, single_key, key, what in THREE_SCALES:
        summary = of_name.get(name, {})
        single, here = _rate(summary, single_key), _rate(summary, key)
        better = "not run" if single is None or here is None else "yes" if here > single else "no"
        aim = f"three scales better than every single one, {what}"
        over = f"over {percent(single)}"
        rows.append([aim, over, None, percent(here), summary.get(of), better])
    return markdown_table(("must reach", "at least", "further aim", "here", "of", "reached"), rows)


def _rate(summary: Mapping[str, object], key: str) -> float | None:
    value = summary.get(key)
    return value if isinstance(value, float) else None


def _homes_table(homes: Sequence[HomeGoals]) -> str:
    """A table of the goals that each home lacks."""
    rows = [
        [f"home {each.home}", len(each.goals),
         ", ".join(goal for goal in GOALS if goal not in each.goals) or "nothing"]
        for each in homes
    ]  # fmt: skip
    return markdown_table(("home", "goals", "lacks"), rows)


def _furniture_section() -> str:
    """A table of the models of each class: seen in training, and held out."""
    rows = [
        [label, count.training, count.held_out, "yes" if count.shapes else "no"]
        for label, count in counts(read_catalogue()).items()
    ]
    header = ("class", "models in training homes", "held out for these homes", "own shapes too")
    training, held_out = (
        sum(len(surfaces.members(family, side)) for family in surfaces.FAMILIES)
        for side in (False, True)
    )
    origin = (
        "The encoder was trained on other models of furniture than those it is judged on. Stairs"
        " that lead down have no model in the catalogue: they are procedural on both sides,"
        " which differ in their materials alone. So are the things that the catalogue has no model"
        " of: one program draws them on both sides, in other proportions, colours and materials."
    )
    floors = (
        f"Pictures of floors, walls, ceilings, doors and steps: {training} for training homes,"
        f" {held_out} held out for these, {surfaces.TRAINING_SHARE:.0%} of each of"
        f" {len(surfaces.FAMILIES)} families on the side of training."
    )
    return f"{origin}\n\n{floors}\n\n{markdown_table(header, rows)}"


def _pictures(
    config: Config, chosen: Sequence[EpisodeResult], page: Path, folder: Path
) -> list[str]:
    """Draw the chosen episodes into `folder` and return the lines of `page` that show them."""
    parts = [
        "## Pictures",
        "Left the true home from above, which the robot never sees, with its way in red from the"
        " blue dot to the red one and what was asked for in green; right its last look.",
    ]
    jobs = [(result, config) for result in chosen]
    drawn = {job[0].episode: picture for job, picture in in_parallel(
        _draw_job, jobs, "pictures", _picture_line
    )}  # fmt: skip
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("*.jpg"):
        old.unlink()
    for result in chosen:
        name = f"{result.episode.home}-{result.episode.goals[0].replace(' ', '-')}.jpg"
        write_whole(folder / name, drawn[result.episode].jpeg)
        verdict = "success" if result.success else "failure"
        alt = f"{verdict}: {result.episode.goals[0]} in home {result.episode.home}"
        parts.append(f"![{alt}]({os.path.relpath(folder / name, page.parent)})")
    authors = sorted({author for picture in drawn.values() for author in picture.attributions})
    if authors:
        parts.append(f"The furniture in these pictures: {'; '.join(authors)}.")
    return parts


def _draw_job(job: tuple[EpisodeResult, Config]) -> Picture:
    return draw_episode(*job)


def _picture_line(job: tuple[EpisodeResult, Config], picture: Picture) -> str:
    return f"home {job[0].episode.home}, {job[0].episode.goals[0]}"
