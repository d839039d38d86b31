"""What errors of calibration and latency cost: the default row against one without them."""

from __future__ import annotations

from collections.abc import Sequence
from math import degrees

from benchmarks.episodes.calibration_error import ANGLE, FOCAL_LENGTH, OFFSET, WHEELS
from benchmarks.episodes.episode import EpisodeResult
from benchmarks.episodes.latency import Latencies
from benchmarks.harness.scores import NavigationScore, PairedCounts
from benchmarks.harness.tables import interval_text, markdown_table, percent

EXACT = "exact calibration"
"""Name of the row without errors of calibration and without measured latency."""


def calibration_cost(
    default: Sequence[EpisodeResult], exact: Sequence[EpisodeResult]
) -> dict[str, object]:
    """For programs: the episodes that both rows have driven, and what only one of them reached.

    Args:
        default: Episodes with the errors.
        exact: Episodes without them.
    """
    ours, theirs = _common(default, exact)
    pairs = _pairs(ours, theirs)
    return {
        "exact_episodes": len(ours),
        "lost_by_errors": pairs.losses,
        "won_by_errors": pairs.wins,
        "errors_p": pairs.p,
    }


def calibration_section(default: Sequence[EpisodeResult], exact: Sequence[EpisodeResult]) -> str:
    """A table of both rows on the episodes that both have driven; empty without any."""
    ours, theirs = _common(default, exact)
    if not ours:
        return ""
    rows = []
    for name, results in (("with the errors", ours), (EXACT, theirs)):
        score = NavigationScore.from_results(results)
        rows.append(
            [name, score.success.trials, score.success, interval_text(score.success),
             percent(score.spl), round(score.steps or 0), score.collisions, score.ate]
        )  # fmt: skip
    header = ("row", "episodes", "SR", "95 % (Wilson)", "SPL", "steps", "collisions",
              "median ATE [m]")  # fmt: skip
    pairs = _pairs(ours, theirs)
    return (
        f"{_errors()}\n\nThe same episodes with and without: {pairs.losses} are reached only"
        f" without the errors, {pairs.wins} only with them (exact paired test, p ="
        f" {pairs.p:.2g}).\n\n{markdown_table(header, rows)}"
    )


def _errors() -> str:
    """Which errors every episode has."""
    kept = Latencies.kept()
    embedding, decision = (
        f"{1000 * sorted(values)[len(values) // 2]:.0f} ms"
        for values in (kept.embedding, kept.decision)
    )
    return (
        "Robot and world differ by what a calibration leaves, drawn by the episode: the mount is"
        f" turned by {degrees(ANGLE):.1f} degrees about any axis and off by"
        f" {1000 * OFFSET:.0f} mm in any direction, wheel base and wheel scale are each off by"
        f" {100 * WHEELS:.1f} %, the focal length by {100 * FOCAL_LENGTH:.1f} %, signs drawn. Every"
        " embedding and every decision takes a time drawn from those measured on"
        f" {kept.hardware} (medians {embedding} and {decision}). The row `{EXACT}` has none of"
        " that: its embeddings all take the configured time, its decisions none."
    )


def _common(
    default: Sequence[EpisodeResult], exact: Sequence[EpisodeResult]
) -> tuple[list[EpisodeResult], list[EpisodeResult]]:
    """The results of the episodes that both have driven, in one order."""
    other = {result.episode: result for result in exact}
    ours = [result for result in default if result.episode in other]
    return ours, [other[result.episode] for result in ours]


def _pairs(ours: Sequence[EpisodeResult], theirs: Sequence[EpisodeResult]) -> PairedCounts:
    return PairedCounts.over(
        {result.episode: result.success for result in ours},
        {result.episode: result.success for result in theirs},
    )
