"""Pages with figures: the rows make most of them, README's table, and sentences of the others."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path

from benchmarks.claims.claims import kept_facts, read_claims
from benchmarks.encoder.page import encoder_page
from benchmarks.episodes.absent_things import ThingAnswer
from benchmarks.faults.bench import faults_page
from benchmarks.harness.bench_plan import ENCODER_ROWS, PAPER, SEARCHED, results_file
from benchmarks.harness.scores import NavigationScore, Rate, interval_over_homes
from benchmarks.harness.store import Store
from benchmarks.harness.tables import fraction_text, percent_range
from benchmarks.objectnav import absent, multi_goal, retrieval
from benchmarks.objectnav.others_page import others_page
from benchmarks.objectnav.paper_figures import MULTI, OBJECT_NAVIGATION, RETRIEVAL
from benchmarks.objectnav.search_page import (
    FORMER,
    Row,
    kept_row,
    paired,
    results_of,
    search_page,
    three_and_coarsest,
    wrong_arrivals,
)
from benchmarks.objectnav.single_goal import DEFAULT, SCALES
from benchmarks.planner.bench import planner_page
from benchmarks.questions.bench import questions_page
from benchmarks.slam.page import slam_page
from vizbot.core.errors import ConfigError
from vizbot.core.files import write_whole

BEGIN, END = "<!-- results: begin -->\n", "<!-- results: end -->"
"""What the table stands between."""
RESULTS = Path("docs/results")
"""Folder of the pages, from the root of the repository; its rows and claims are in it."""
ROWS = RESULTS / "rows"
"""Folder of the folders of published rows."""
README = Path("README.md")
"""The page whose table of results is made."""
MADE: Mapping[str, Callable[[Path, Path], str]] = {
    "encoder": encoder_page,
    "faults": faults_page,
    "others": others_page,
    "planner": planner_page,
    "questions": questions_page,
    "search": search_page,
    "slam": slam_page,
}
"""What makes a page from its folder of rows and its own path, by the name of both; it makes nothing
where rows are missing that the page cannot do without."""


def with_table(page: str, rows: Path) -> str:
    """The text of a page with the table between its markers; as it is where it has none."""
    before, begin, rest = page.partition(BEGIN)
    _, end, after = rest.partition(END)
    return f"{before}{begin}{_table(rows)}\n{end}{after}" if end else page


def _table(rows: Path) -> str:
    board = rows / "search"
    default = kept_row(board, DEFAULT)
    office = json.loads((rows / "slam/hololens_office/results.json").read_text(encoding="utf-8"))
    offset = kept_row(board, ENCODER_ROWS["offset"])
    drawn_by_others = kept_row(rows / "others", DEFAULT)
    driven_by_both = [
        line for line in default if line.result.episode in {r.episode for r in results_of(offset)}
    ]
    searched = results_of(kept_row(board, SEARCHED, absent.NAME))
    answers = Store(results_file(board, absent.NAME, DEFAULT), ThingAnswer).fullest()
    lines = [
        ("in simulated homes, with our own encoder", "vizbot (95 % over homes)"),
        ("---", "---"),
        ("goals reached in eight homes that nobody had looked at", _navigation(default)),
        ("the same by the paper's method, with our encoder",
         _beside(default, kept_row(board, PAPER))),
        ("the robot says wrongly that it has arrived", _counted(*wrong_arrivals(board))),
        ("today's search in eight newer homes", _navigation(kept_row(rows / "newer", DEFAULT))),
        ("a third of the goals; with errors in each cosine, as another encoder has",
         f"{_reached(driven_by_both)}; {_reached(offset)}"),
        ("goals reached in four homes that others drew", _navigation(drawn_by_others)),
        ("the same by the paper's method, with our encoder",
         _beside(drawn_by_others, kept_row(rows / "others", PAPER))),
        *_questions(board),
        ("things that are not there, refused by maps; by searching",
         f"{fraction_text(absent.refused_rate([line.result for line in answers]))};"
         f" {fraction_text(Rate.over(absent.is_refusal(r.goals[0]) for r in searched))}"),
        ("four goals in a row, each over 3 m away; by the former search", "; ".join(
            _reached(kept_row(board, name, multi_goal.NAME)) for name in (DEFAULT, FORMER)
        )),
        (f"error of poses on a real walk of {office['summary']['path_length']:.0f} m, tuned on it",
         f"{office['summary']['ate_rmse']:.2f} m"),
        ("the paper's own goals, questions and four in a row, in other homes with another encoder:"
         " no direct comparison",
         f"{OBJECT_NAVIGATION[-1][1]:.0f}, {RETRIEVAL[-1][1]:.0f} and {MULTI[-1][1][-1]} %"),
    ]  # fmt: skip
    return "\n".join(f"| {what} | {figure} |" for what, figure in lines)


def _navigation(row: Row) -> str:
    """What is reached, SPL, and the way of the successes beside the shortest."""
    score = NavigationScore.from_results(results_of(row))
    return (
        f"{_reached(row)}, SPL {score.spl or 0.0:.3f}, {score.path_of_successes or 0.0:.0f} m"
        f" driven where {score.shortest_of_successes or 0.0:.1f} m would do"
    )


def _beside(ours: Row, theirs: Row) -> str:
    """Another row's figures, and the goals that one of both alone reached."""
    pairs = paired(ours, theirs)
    alone = f"ours alone reached {pairs.wins}, that alone {pairs.losses} (p = {pairs.p:.2g})"
    return f"{_navigation(theirs)}; {alone}"


def _reached(row: Row) -> str:
    outcomes = [(result.episode.home, result.success) for result in results_of(row)]
    return _counted(Rate.over(right for _, right in outcomes), interval_over_homes(outcomes))


def _counted(rate: Rate, over_homes: tuple[float, float] | None) -> str:
    """A rate as 9 of 10, 90 % (80 to 100)."""
    return f"{fraction_text(rate)}, {100 * (rate.value or 0.0):.2g} % ({percent_range(over_homes)})"


def _questions(board: Path) -> list[tuple[str, str]]:
    """Questions to maps by both rules, and three scales beside the coarsest one alone."""
    answers = [line.result for line in retrieval.retrieval_stores(board)[1].fullest()]
    asked = [each for each in answers if each.exists and each.scales == SCALES]
    over_homes = (
        interval_over_homes((each.home, each.correct) for each in asked),
        interval_over_homes((each.home, each.most_similar_correct) for each in asked),
    )
    compared = three_and_coarsest(answers)
    return [
        ("questions to maps of the eight homes answered rightly; by the paper's rule",
         "; ".join(
             _counted(three, of_homes)
             for (three, *_), of_homes in zip(compared, over_homes, strict=True)
         )),
        ("of these by three scales and by the coarsest alone; by the paper's rule",
         "; ".join(
             f"{three.count} and {alone.count} (p = {p:.2f})" for three, alone, p in compared
         )),
    ]  # fmt: skip


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
