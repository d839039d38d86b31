"""Questions to maps of explored homes, on the page of the search: for what is there, and is not."""

from __future__ import annotations

from pathlib import Path

from benchmarks.episodes.absent_things import ThingAnswer
from benchmarks.episodes.encoder_scale import EncoderScale
from benchmarks.episodes.episode import EpisodeResult
from benchmarks.harness.bench_plan import ENCODER_ROWS, SEARCHED, results_file
from benchmarks.harness.scores import Rate
from benchmarks.harness.store import Store
from benchmarks.harness.tables import markdown_table
from benchmarks.objectnav import absent, retrieval
from benchmarks.objectnav.scale_comparison import scales_verdict
from benchmarks.objectnav.single_goal import SCALES

_ABSENT_NOTE = (
    '"elsewhere" are things that other homes have and this one has not, "nowhere" things that are'
    " in no home. `by searching` the robot drives; only its own decision that there is none counts,"
    " not that its steps are used up; for what is there it searches in the row `default` above."
)


def map_sections(folder: Path, page: Path) -> list[str]:
    """The sections of what maps were asked; none where they were not.

    Args:
        folder: Folder of the kept rows.
        page: The file that they are for.
    """
    return [*_present(folder, page), *_absent(folder)]


def _present(folder: Path, page: Path) -> list[str]:
    """Questions for what the home has, by each encoder's cosines."""
    scales: tuple[EncoderScale | None, ...] = (None, *ENCODER_ROWS)
    lines: list[list[object]] = []
    whole = verdict = ""
    for scale in scales:
        explorations, queries = retrieval.retrieval_stores(folder, scale)
        stored = queries.fullest()
        if not stored:
            continue
        answers = [line.result for line in stored]
        driven = [line.result for line in explorations.fullest()]
        result = retrieval.retrieval_result(answers, SCALES, driven)
        whole = whole or f"Commit {stored[0].commit}.\n\n{result.text}"
        if scale is None:
            better = [
                shown
                for prefix in ("", "most_similar_")
                if (shown := result.summary[f"{prefix}three_scales_better"]) is not None
            ]
            verdict = scales_verdict(better, "embedded", page)
        present = [each for each in answers if each.scales == SCALES and each.exists]
        lines.append([
            "default" if scale is None else ENCODER_ROWS[scale], len(present),
            retrieval.precision(present), Rate.over(each.most_similar_correct for each in present),
            _decimals(result.summary["calibration_error"]), _decimals(result.summary["log_loss"]),
        ])  # fmt: skip
    header = ("encoder", "queries", "P@1", "P@1, the most similar element", "calibration error",
              "log loss")  # fmt: skip
    if not lines:
        return []
    return ["## Questions to maps of explored homes", whole, verdict, markdown_table(header, lines)]


def _decimals(value: object) -> str:
    return "-" if value is None else f"{value:.3f}"


def _absent(folder: Path) -> list[str]:
    """Questions for what the home has, and has not, and searches for what it has not."""
    answers = {
        row: [line.result for line in stored]
        for row in absent.ROWS
        if (stored := Store(results_file(folder, absent.NAME, row), ThingAnswer).fullest())
    }
    searches = Store(results_file(folder, absent.NAME, SEARCHED), EpisodeResult).fullest()
    if not answers and not searches:
        return []
    result = absent.absent_result(answers, [line.result for line in searches])
    return ["## What is not there", _ABSENT_NOTE, result.text]
