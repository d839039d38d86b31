"""`docs/results/search.md`: the search on the board, beside the former one and the paper's."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import pairwise
from pathlib import Path

from benchmarks.episodes.absent_things import ThingAnswer
from benchmarks.episodes.episode import EpisodeResult, HomeGoals, QueryResult
from benchmarks.episodes.oracles import ORACLES
from benchmarks.harness.bench_plan import (
    ENCODER_ROWS,
    PAPER,
    QUICK_SHARE,
    QUICK_SHARE_ROWS,
    SEARCHED,
    results_file,
)
from benchmarks.harness.scores import (
    NavigationScore,
    PairedCounts,
    Rate,
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
from benchmarks.objectnav import absent, multi_goal, retrieval
from benchmarks.objectnav.home_tables import homes_table, models_section, seen_section
from benchmarks.objectnav.overshoot import overshoot_table
from benchmarks.objectnav.scale_comparison import scales_verdict
from benchmarks.objectnav.single_goal import DEFAULT, NAME, SCALES, oracle_table

FORMER = "former"
"""The row of the search before this one, driven at its last commit."""
_THIRD = {
    ENCODER_ROWS["clip"]: "cosines lie where those of ViT-L/14 do, in the same order, and the"
    " search knows their scale and bias",
    ENCODER_ROWS["offset"]: "in addition each text has an offset, and each pair of patch and text"
    " an error (0.01 each)",
    ENCODER_ROWS["unknown"]: "cosines as of ViT-L/14, but the search knows neither scale nor bias"
    " and has z-scores alone",
    "true encoder": "the truth about what each patch shows",
}
"""Rows that are driven on a third of the episodes, and what each one is."""
TRUE, AGAIN = "_true", "_again"
"""Endings of the folders beside that of the rows: failures, and as many successes, driven with the
truth about one part; and episodes driven again on the computer that drove the row `scaled`."""
_INTRODUCTION = """Rows are `default`, the search by belief; `former`, the search before it; and
`paper`, the paper's method on our poses, planner and encoder, which stops where the first view
reaches the threshold. A wrong arrival is an episode in which the robot says that it has arrived and
has not. SPL is success weighted by path length [%]. Intervals over homes draw whole homes again
(cluster bootstrap, fixed seed); with so few homes they are rough. The exact paired test (McNemar)
decides differences of success. Nobody had looked at these homes before a search drove in them;
homes, encoder and furniture split are ours."""
_ABSENT = """`elsewhere` are things that other homes have, `nowhere` things that no home has. In
the row `by searching` the robot drives, and only its own decision that there is none counts."""
_SURE = re.compile(r"(\d+)% sure")
"""How the robot says the probability of the place at which it stops."""
_SURE_EDGES = (0.0, 0.6, 0.7, 0.8, 0.9, 1.01)
"""Edges of the rows of the table of these probabilities."""

Row = Sequence[StoredResult[EpisodeResult]]


def search_page(folder: Path, page: Path) -> str:
    """The page of the kept rows of a folder; empty without the default row."""
    driven = FORMER, PAPER, DEFAULT, *_THIRD
    rows = {name: row for name in driven if (row := kept_row(folder, name))}
    if DEFAULT not in rows:
        return ""
    surveyed = Store(folder / "homes.jsonl", HomeGoals).fullest()
    homes = sorted((line.result for line in surveyed), key=lambda each: str(each.home))
    third = [name for name in _THIRD if name in rows]
    parts = [
        "# Search",
        _table(rows, (FORMER, PAPER, DEFAULT)),
        differences(rows, (FORMER, PAPER)),
        _wrong_arrivals_text(folder),
        _INTRODUCTION,
        made_with(rows),
        *_of_today(folder.with_name(QUICK_SHARE_ROWS)),
    ]
    if third:
        parts += [
            "## Other encoders, on a third of the goals",
            _table(rows, third),
            differences(rows, third),
            "\n".join(f"- `{name}`: {_THIRD[name]}." for name in third),
            _same_paths(folder, rows),
        ]
    parts += _with_true_parts(folder, rows[DEFAULT])
    parts += [_overshoot(folder), *_questions(folder, page), _in_a_row(folder)]
    vain = kept_row(folder, SEARCHED, absent.NAME)
    parts += _not_there(folder, vain)
    parts += [_arrivals(rows[DEFAULT]), seen_section(results_of(rows[DEFAULT]), results_of(vain))]
    parts += ["## Failures", _failures(rows[DEFAULT])]
    parts += ["## Homes", homes_table(homes), models_section(homes)]
    return "\n\n".join(part for part in parts if part) + "\n"


def kept_row(folder: Path, name: str, bench: str = NAME) -> list[StoredResult[EpisodeResult]]:
    """The kept episodes of a row; empty where it was not driven."""
    return Store(results_file(folder, bench, name), EpisodeResult).fullest()


def results_of(row: Row) -> list[EpisodeResult]:
    """The results of a row, without what they were made with."""
    return [line.result for line in row]


def paired(ours: Row, theirs: Row) -> PairedCounts:
    """Two rows on the episodes that both have driven."""
    return PairedCounts.over(
        {line.result.episode: line.result.success for line in ours},
        {line.result.episode: line.result.success for line in theirs},
    )


def wrong_arrivals(folder: Path) -> tuple[Rate, tuple[float, float] | None]:
    """How often the search says wrongly that it has arrived, and the 95 % interval over homes.

    Counted over all goals of the board that exist: single ones, and four in a row.
    """
    wrong = [
        (line.result.episode.home, goal.claimed and not goal.success)
        for bench in (NAME, multi_goal.NAME)
        for line in kept_row(folder, DEFAULT, bench)
        for goal in line.result.goals
    ]
    return Rate.over(each for _, each in wrong), interval_over_homes(wrong)


def _wrong_arrivals_text(folder: Path) -> str:
    rate, over_homes = wrong_arrivals(folder)
    return (
        f"Of all {rate.trials} goals that this search was given on the board, single ones and in a"
        f" row, it said {rate.count} times ({percent(rate.value)} %, over homes"
        f" {percent_range(over_homes)}) wrongly that it had arrived."
    )


def _of_today(folder: Path) -> list[str]:
    """Today's search beside the former one, in homes of development; empty where not driven."""
    rows = {name: row for name in (FORMER, DEFAULT) if (row := kept_row(folder, name))}
    if DEFAULT not in rows:
        return []
    return [
        "## Today's search, in homes of development",
        _table(rows, list(rows)),
        differences(rows, (FORMER,)),
        f"The quick share: every third goal of homes {QUICK_SHARE[0]} to {QUICK_SHARE[-1]}, in"
        " which the search is developed. It shows what the search has become since the board was"
        " driven, and is no figure for other homes.",
        made_with(rows),
    ]


def _same_paths(folder: Path, rows: Mapping[str, Row]) -> str:
    """How many paths the order of cosines alone leaves as they are; empty without the rows."""
    scaled = rows.get(ENCODER_ROWS["clip"], ())
    if not (again := kept_row(folder.with_name(folder.name + AGAIN), DEFAULT)):
        return ""
    tracks = {line.result.track for line in [*rows[DEFAULT], *again]}
    same = sum(line.result.track in tracks for line in scaled)
    return (
        f"With the cosines of `{ENCODER_ROWS['clip']}` {same} of {len(scaled)} paths are those of"
        f" the default to the last digit; for {len(again)} of them the default was driven again on"
        " the computer of that row, because floors differ there in single pixels."
    )


def _with_true_parts(folder: Path, board: Row) -> list[str]:
    """How many failures the truth about one part turns into successes; empty where not driven."""
    true = folder.with_name(folder.name + TRUE)
    rows = {f"true {part}": kept_row(true, f"true {part}") for part in ORACLES}
    table = oracle_table(
        {name: results_of(row) for name, row in rows.items()} | {DEFAULT: results_of(board)}
    )
    if not table:
        return []
    commits = _each(line.commit for row in rows.values() for line in row)
    text = f"These are the failures, and as many successes drawn by lot, at commit {commits}."
    if in_a_row := kept_row(true, "true encoder", multi_goal.NAME):
        reached = sum(line.result.success for line in in_a_row)
        text += (
            f" Of the {len(in_a_row)} failed episodes of four goals in a row the true encoder"
            f" reaches all four in {reached}."
        )
    return ["## With the truth about one part", table, text]


def made_with(rows: Mapping[str, Row]) -> str:
    """Commit and computer of each row, in a list."""
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


def _table(rows: Mapping[str, Row], names: Sequence[str]) -> str:
    header = ("row", "episodes", "reached [%]", "95 % (Wilson)", "95 % over homes",
              "wrong arrivals", "SPL", "95 % over homes", "steps", "driven [m]", "shortest [m]",
              "collisions")  # fmt: skip
    return markdown_table(header, with_default_beside(rows, names, _figures))


def with_default_beside(
    rows: Mapping[str, Row],
    names: Sequence[str],
    figures: Callable[[Sequence[EpisodeResult]], list[object]],
) -> list[list[object]]:
    """Rows of a table; those that were driven on a part have the default on that part below."""
    lines: list[list[object]] = []
    for name in names:
        if name not in rows:
            continue
        results = results_of(rows[name])
        lines.append([name, *figures(results)])
        driven = {result.episode for result in results}
        default = [each for each in results_of(rows[DEFAULT]) if each.episode in driven]
        if name != DEFAULT and len(default) < len(rows[DEFAULT]):
            lines.append([f"{DEFAULT}, the same goals", *figures(default)])
    return list({tuple(line): line for line in lines}.values())


def spl_over_homes(results: Sequence[EpisodeResult]) -> tuple[float, float] | None:
    """The 95 % interval of SPL over homes; None with fewer than two homes."""
    return interval_over_homes(
        (each.episode.home, path_weighted_success(each.goals[0])) for each in results
    )


def _figures(results: Sequence[EpisodeResult]) -> list[object]:
    score = NavigationScore.from_results(results)
    return [
        score.success.trials, score.success, interval_text(score.success),
        percent_range(score.success_over_homes), fraction_text(score.said_wrongly),
        percent(score.spl), percent_range(spl_over_homes(results)),
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


def differences(rows: Mapping[str, Row], names: Sequence[str]) -> str:
    """The default paired with each of these rows; empty where none was driven."""
    lines = []
    for name in names:
        if name not in rows:
            continue
        pairs = paired(rows[DEFAULT], rows[name])
        mean, interval = spl_difference(results_of(rows[DEFAULT]), results_of(rows[name]))
        lines.append(
            [f"{DEFAULT} and {name}", pairs.wins, pairs.losses, f"{pairs.p:.2g}",
             f"{100 * mean:+.1f}", percent_range(interval)]
        )  # fmt: skip
    header = ("paired", "only the first reached", "only the second reached", "p",
              "SPL, first minus second", "95 % over homes")  # fmt: skip
    return markdown_table(header, lines) if lines else ""


def _in_a_row(folder: Path) -> str:
    """Four goals in a row over 3 m away, by both searches; empty where none was driven."""
    rows = {
        name: row for name in (FORMER, DEFAULT) if (row := kept_row(folder, name, multi_goal.NAME))
    }
    if not rows:
        return ""
    lines = []
    for name, row in rows.items():
        results = results_of(row)
        rates = multi_goal.at_least_rates(results)
        over_homes = interval_over_homes((each.episode.home, each.success) for each in results)
        wrong = sum(goal.claimed and not goal.success for each in results for goal in each.goals)
        lines.append(
            [name, len(results), *(rate.count for rate in rates), interval_text(rates[-1]),
             percent_range(over_homes), wrong]
        )  # fmt: skip
    header = ("row", "episodes", "reached 1", "2", "3", "all 4", "95 % of all 4 (Wilson)",
              "95 % over homes", "wrong arrivals")  # fmt: skip
    title = "## Four goals in a row, each over 3 m from where the robot stands"
    parts = [title, markdown_table(header, lines)]
    if rows.keys() == {FORMER, DEFAULT}:
        pairs = paired(rows[DEFAULT], rows[FORMER])
        parts.append(
            f"Only {DEFAULT} reached all four in {pairs.wins} episodes, only {FORMER} in"
            f" {pairs.losses} (exact paired test, p = {pairs.p:.2g}). A wrong arrival ends the row."
        )
    return "\n\n".join(parts)


def _questions(folder: Path, page: Path) -> list[str]:
    """Questions to maps for what the homes have; none where no map was asked."""
    _, queries = retrieval.retrieval_stores(folder)
    if not (stored := queries.fullest()):
        return []
    result = retrieval.retrieval_result([line.result for line in stored], SCALES)
    better = [result.summary[f"{rule}three_scales_better"] for rule in ("", "most_similar_")]
    error, loss = (result.summary[key] for key in ("calibration_error", "log_loss"))
    ours, papers = (
        f"{three.count} and {alone.count} of {three.trials} (p = {p:.2f})"
        for three, alone, p in three_and_coarsest([line.result for line in stored])
    )
    return [
        "## Questions to maps of explored homes",
        result.text,
        f"Three scales and the coarsest alone answer {ours} rightly by the robot's rule, and"
        f" {papers} by the paper's own, which takes the most similar element.",
        f"Expected calibration error {_decimals(error)}, log loss {_decimals(loss)}; commit"
        f" {_each(line.commit for line in stored)}.",
        scales_verdict([each for each in better if each is not None], page),
    ]


def three_and_coarsest(answers: Sequence[QueryResult]) -> list[tuple[Rate, Rate, float]]:
    """Questions that three scales, and the coarsest alone, answer rightly, and p of their pairs.

    First by the robot's rule, then by the paper's.
    """
    compared = []
    for rule in ("correct", "most_similar_correct"):
        three, alone = (
            {(a.home, a.text): getattr(a, rule) for a in answers if a.exists and a.scales == scales}
            for scales in (SCALES, SCALES[:1])
        )
        pairs = PairedCounts.over(three, alone)
        compared.append((Rate.over(three.values()), Rate.over(alone.values()), pairs.p))
    return compared


def _decimals(value: object) -> str:
    return "-" if value is None else f"{value:.3f}"


def _not_there(folder: Path, searches: Row) -> list[str]:
    """Questions and searches for what the homes have not; none where nothing was asked."""
    answers = {
        row: [line.result for line in stored]
        for row in absent.ROWS
        if (stored := Store(results_file(folder, absent.NAME, row), ThingAnswer).fullest())
    }
    if not answers and not searches:
        return []
    result = absent.absent_result(answers, results_of(searches))
    return ["## What is not there", result.text, _ABSENT]


def _overshoot(folder: Path) -> str:
    """What is driven after a stop would have done; empty where it was not asked."""
    table = overshoot_table(folder, (FORMER, DEFAULT))
    title = "## Way before and after a stop would have been a success"
    return f"{title}\n\n{table}" if table else ""


def _arrivals(row: Row) -> str:
    """How often the robot is wrong beside how often it says it may be; empty without arrivals."""
    said = [
        (int(sure[1]) / 100, goal.success)
        for goal in (result.goals[0] for result in results_of(row))
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
    header = ("probability of the place", "arrivals", "wrong ones",
              "wrong ones to expect by it")  # fmt: skip
    title = "## How sure the robot is when it says that it has arrived"
    return f"{title}\n\n{markdown_table(header, lines)}" if lines else ""


def _failures(row: Row) -> str:
    lines = [
        [f"home {r.episode.home}, {r.goals[0].text}", r.goals[0].reason, r.goals[0].answer,
         r.goals[0].steps]
        for r in results_of(row)
        if not r.success
    ]  # fmt: skip
    if not lines:
        return "None."
    return markdown_table(("goal", "verdict", "what the robot said", "steps"), lines)
