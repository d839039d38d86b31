"""`docs/results/ranking.md`: searches in the whole loop, and in the fast world, side by side.

The fast world is worth thinking in as long as it ranks searches as the whole loop does.
"""

from __future__ import annotations

from pathlib import Path

from scipy.stats import spearmanr

from benchmarks.episodes.episode import EpisodeResult
from benchmarks.fast_world.bench import standard_error
from benchmarks.harness.bench_plan import results_file
from benchmarks.harness.scores import NavigationScore, spl
from benchmarks.harness.store import Store, StoredResult
from benchmarks.harness.tables import markdown_table, percent

SEARCHES = ("paper", "old", "old, choosy 1.0", "old, true evidence", "default", "true evidence")
"""Names of the searches, of which rows are kept as `whole-NAME.jsonl` and `fast-NAME.jsonl`."""
_TITLE = "# The fast world beside the whole loop"
_NOTE = (
    "Every search on the same episodes, those of the quick share, in homes of development: here"
    " rules are compared, and nothing is claimed. `old` is the search before the present one;"
    " `choosy 1.0` believes a place from 1.0 of the encoder's threshold on instead of 1.3. SPL in"
    " percent, with its standard error; commits of the whole loop and of the fast world, where they"
    " differ."
)


def ranking_page(folder: Path, page: Path) -> str:
    """The page of the kept rows of a folder; empty where fewer than two searches are kept.

    Args:
        folder: Folder of the kept rows.
        page: The file that the text is for.
    """
    lines: list[list[object]] = []
    whole_spl, fast_spl = list[float](), list[float]()
    for name in SEARCHES:
        whole, fast = (_stored(folder, world, name) for world in ("whole", "fast"))
        both = whole.keys() & fast.keys()
        if not both:
            continue
        line: list[object] = [name, len(both)]
        for kept, means in ((whole, whole_spl), (fast, fast_spl)):
            results = [kept[episode].result for episode in both]
            score = NavigationScore.from_results(results)
            assert score.spl is not None
            means.append(score.spl)
            line += _figures(score, standard_error([spl(each.goals) or 0.0 for each in results]))
        commits = dict.fromkeys(each.commit for kept in (whole, fast) for each in kept.values())
        lines.append([*line, " and ".join(commits)])
    if len(lines) < 2:
        return ""
    header = ("search", "episodes", "reached", "SPL", "steps", "reached, fast", "SPL, fast",
              "steps, fast", "commits")  # fmt: skip
    rank = float(spearmanr(whole_spl, fast_spl).statistic)
    agreement = f"Rank correlation of the SPL of both worlds (Spearman): {rank:.2f}."
    return f"{_TITLE}\n\n{_NOTE}\n\n{markdown_table(header, lines)}\n\n{agreement}\n"


def _stored(folder: Path, world: str, name: str) -> dict[object, StoredResult[EpisodeResult]]:
    """The kept results by episode."""
    path = results_file(folder, world, name.replace(",", ""))
    lines = Store(path, EpisodeResult).fullest()
    return {line.result.episode: line for line in lines}


def _figures(score: NavigationScore, error: float | None) -> list[object]:
    """What is reached, SPL with its standard error, and steps."""
    spread = "" if error is None else f" ± {percent(error)}"
    steps = "-" if score.steps is None else f"{score.steps:.0f}"
    return [score.success, f"{percent(score.spl)}{spread}", steps]
