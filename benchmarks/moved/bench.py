"""`vizbot bench moved`: things move between two visits, and the map is asked where they are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from benchmarks.episodes.episode import Variant
from benchmarks.harness.bench_plan import BenchPlan, BenchResult, require_unchanged, results_file
from benchmarks.harness.fingerprint import key_of_sources
from benchmarks.harness.scores import PairedCounts, Rate, interval_over_homes
from benchmarks.harness.store import Store
from benchmarks.harness.tables import (
    fraction_text,
    interval_text,
    markdown_table,
    percent_range,
)
from benchmarks.harness.workers import in_parallel
from benchmarks.moved.visits import HomeVisits, MovedAnswer, kinds_of, visit_twice

NAME = "moved"
HOMES = tuple(range(1110, 1140))
"""Homes that are visited twice."""
QUICK_HOMES = 6
DEFAULT, NOTHING_FORGOTTEN = "default", "nothing forgotten"
ROWS = DEFAULT, NOTHING_FORGOTTEN
"""The robot's map, and the same one as if all of it had been seen at one time."""
MAPS = Path("runs/moved")
"""Folder of the maps of the first visits."""


def run_moved(plan: BenchPlan) -> BenchResult:
    """Visit the homes that have no answers yet, and print the table."""
    require_unchanged(plan)
    fingerprint = plan.fingerprint
    robot = fingerprint.key_of(Variant(DEFAULT, plan.config))
    key = f"{robot}-{key_of_sources('benchmarks/moved')}"
    stores = {row: Store(results_file(plan.folder, NAME, row), MovedAnswer) for row in ROWS}
    homes = [home for home in plan.seeds if isinstance(home, int)]
    done = [{each.home for each in store.results_with_key(key)} for store in stores.values()]
    jobs = [
        HomeVisits(plan.config, home, MAPS / robot / f"home-{home}")
        for home in homes
        if not all(home in of_row for of_row in done)
    ]
    for _, answers in in_parallel(visit_twice, jobs, NAME, _home_line):
        for store, of_row in zip(stores.values(), answers, strict=True):
            store.add(key, fingerprint.commit, fingerprint.hardware, *of_row)
    return moved_result(
        {
            row: [each for each in store.results_with_key(key) if each.home in homes]
            for row, store in stores.items()
        },
        smoke_test=plan.quick,
    )


def moved_result(
    results: Mapping[str, Sequence[MovedAnswer]], *, smoke_test: bool = False
) -> BenchResult:
    """Rows, summary and table of the answers of each row; the summary is that of the first."""
    rows = [{"row": row, **_figures(answers)} for row, answers in results.items()]
    table = [
        [
            row, kind, len(answers), Rate.over(each.right for each in answers),
            interval_text(Rate.over(each.right for each in answers)),
            percent_range(interval_over_homes((each.home, each.right) for each in answers)),
            fraction_text(_claimed_old(answers)),
            sum(not each.seen for each in answers),
        ]
        for row, all_answers in results.items()
        for kind, answers in kinds_of(all_answers)
    ]  # fmt: skip
    header = (
        "row", "things", "asked for", "right", "95 % (Wilson)", "95 % over homes",
        "claimed where they were, of those looked at again", "new place not seen",
    )  # fmt: skip
    parts = [markdown_table(header, table)]
    parts += [
        f"{row}: unmoved things that one of both maps alone answers rightly:"
        f" {paired.wins} the first, {paired.losses} the second (p = {paired.p:.2f})"
        for row, answers in results.items()
        for paired in [_unmoved(answers)]
    ]
    if smoke_test:
        parts.insert(0, "A smoke test on a part of the homes: no claim.")
    return BenchResult(NAME, rows, _figures(next(iter(results.values()))), "\n\n".join(parts))


def _figures(answers: Sequence[MovedAnswer]) -> dict[str, object]:
    moved = [each for each in answers if each.kind in ("within its room", "to another room")]
    gone = [each for each in answers if each.kind == "gone"]
    known = [each for each in answers if each.kind == "unmoved" and each.right_before]
    found, refused = (Rate.over(each.right for each in of_kind) for of_kind in (moved, gone))
    low, high = found.interval()
    return {
        "moved": len(moved),
        "found_at_new_place": found.value,
        "found_low": low,
        "found_high": high,
        "claimed_at_old_place": _claimed_old([*moved, *gone]).value,
        "gone": len(gone),
        "gone_refused": refused.value,
        "unmoved": len(known),
        "lost_unmoved": Rate.over(not each.right for each in known).value,
        "lost_unmoved_p": _unmoved(answers).p,
    }


def _claimed_old(answers: Sequence[MovedAnswer]) -> Rate:
    """How many things are claimed at the old place, of those where it was looked at again."""
    return Rate.over(each.claimed_old for each in answers if each.looked_again)


def _unmoved(answers: Sequence[MovedAnswer]) -> PairedCounts:
    """Unmoved things that the first map answers rightly, against the second."""
    unmoved = [each for each in answers if each.kind == "unmoved"]
    return PairedCounts.over(
        {(each.home, each.text): each.right_before for each in unmoved},
        {(each.home, each.text): each.right for each in unmoved},
    )


def _home_line(job: HomeVisits, answers: tuple[list[MovedAnswer], list[MovedAnswer]]) -> str:
    changed = [each for each in answers[0] if each.kind != "unmoved"]
    right = ", ".join(
        f"{each.text} {each.kind}: {'right' if each.right else 'wrong'}" for each in changed
    )
    return f"home {job.home}: {right}"
