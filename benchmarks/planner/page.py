"""`docs/results/planner.md`: how fast paths are planned."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from statistics import median

from benchmarks.harness.reference_kernel import DESCRIPTION
from benchmarks.harness.store import Store, StoredResult
from benchmarks.harness.tables import markdown_table
from benchmarks.planner.bench import CaseTimes, PlannerRun, planner_result

_TEXT = """Times are medians over the cases of a line, after compilation; each case is the median of
several runs in turns, in one process and with one thread. The speedup is the time of the fastest
rival over ours. All planners solve the same cases (`vizbot bench planner`): the same
grid, costs, start and goals, on 8-connected cells, a move at its length times the mean cost of its
two cells, no corner cut. Grids are an empty hall, rooms of 3 m with doors, a maze of corridors, and
the obstacle maps of recorded runs in homes 1101 and 1104, in a grid of 1000 x 1000. Goals are 2 m
away as the crow flies (near), or at least 0.6 of the grid (far).

| planner | how its rules differ |
|---|---|
| vizbot | times include the conversion from metres to cells and back |
| A* in C++ | the same rules; it looks for the nearest goal in each opened cell |
| A* in C++, swept heuristic | the same rules; two sweeps over the grid, as for many goals |
| scikit-image MCP | cuts corners; up to 2000 x 2000 |
| nano-astar | one goal, every cell at the same cost: the hall alone |
| pyastar2d | one goal; a move costs what the cell it enters does; cuts corners |
| networkx A* | one goal, up to 200 x 200; its graph is made beforehand |

A planner whose path costs something else than ours in a case is no rival there. The A* in C++ is
made for this comparison (`benchmarks/planner/astar.cpp`, flat arrays that it keeps from call to
call, -O3); the other packages come by `pip install --group peers`. It is ahead on small grids with
one goal, and above all where few goals lie far off across an empty hall: there very many paths cost
the same, and ours opens more cells, because it breaks ties by its rule."""


def planner_page(folder: Path, page: Path) -> str:
    """The page of the newest run; empty without any."""
    kept = Store(folder / "runs.jsonl", PlannerRun).all()
    if not kept:
        return ""
    newest, run = kept[-1], kept[-1].result
    summary = planner_result(run).summary
    groups: dict[tuple[str, str], list[CaseTimes]] = {}
    for case in run.cases:
        groups.setdefault((case.kind, case.distance), []).append(case)
    header = ("map, distance", "cases", "vizbot [ms]", "fastest rival [ms]", "median speedup",
              "least speedup")  # fmt: skip
    rows = [_row(*group) for group in groups.items()]
    return "\n\n".join(
        [
            "# The planner beside others",
            markdown_table(header, rows),
            f"Over all {summary['cases']} cases the median speedup is"
            f" {summary['median_speedup_over_best_peer']}, the least"
            f" {summary['worst_case_speedup']}; of the kinds of map and the distances the worst has"
            f" {summary['worst_speedup_over_best_peer']}. Costmap and navigation on a recorded map"
            f" take {run.home_map_ms:.1f} ms. {_made_with(newest)}",
            _TEXT,
            "",
        ]
    )


def _row(group: tuple[str, str], cases: Sequence[CaseTimes]) -> list[object]:
    rivals = [case.rival.ms for case in cases if case.rival is not None]
    speedups = [case.speedup for case in cases if case.speedup is not None]
    return [
        ", ".join(group), len(cases), f"{median(case.times[0].ms for case in cases):.3g}",
        f"{median(rivals):.3g}" if rivals else None, median(speedups) if speedups else None,
        min(speedups, default=None),
    ]  # fmt: skip


def _made_with(line: StoredResult[PlannerRun]) -> str:
    return (
        f"The reference kernel ({DESCRIPTION}) takes {line.result.reference:.1f} ms. Commit"
        f" {line.commit}, {line.hardware}."
    )
