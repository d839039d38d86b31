"""`docs/results/planner.md`: how fast paths are planned."""

from __future__ import annotations

from pathlib import Path

from benchmarks.harness.store import Store
from benchmarks.planner.bench import PlannerRun, planner_result

_TITLE = """# The planner beside others

`vizbot bench planner` lets planners solve the same cases in turns, in one process and with one
thread: the same grid, costs, start and goals, on 8-connected cells, a move at its length times the
mean cost of its two cells, no corner cut. Grids are an empty hall, rooms of 3 m with doors, a maze
of corridors, and the obstacle maps of recorded runs in home 1101 (after 126 steps) and 1104
(explored to the end), in a grid of 1000 x 1000. Goals are 2 m away as the crow flies (near), or at
least 0.6 of the grid (far).

| planner | in what its rules differ |
|---|---|
| vizbot | times include the conversion from metres to cells and back |
| A* in C++ | the same rules; the nearest goal is looked for in each opened cell |
| A* in C++, swept heuristic | the same rules; two sweeps over the grid, as for many goals |
| scikit-image MCP | cuts corners; up to 2000 x 2000 |
| nano-astar | one goal, every cell at the same cost: the hall alone |
| pyastar2d | one goal; a move costs what the cell it enters does; cuts corners |
| networkx A* | one goal, up to 200 x 200; its graph is made beforehand |

The A* in C++ is made for this comparison (`benchmarks/planner/astar.cpp`, flat arrays that are
kept from call to call, -O3). A planner whose path costs something else than ours in a case is shown
with a ~ and is no rival there.

`median_speedup_over_best_peer` is over all cases, `worst_speedup_over_best_peer` that of the worst
kind of map or distance, `worst_case_speedup` that of the worst single case. The A* in C++ is ahead
on small grids with one goal, and above all where few goals lie far off across an empty hall: there
very many paths cost the same, and ours opens more cells, because it breaks ties by its rule.

Packages come by `pip install --group peers`; the times are those after compilation."""


def planner_page(folder: Path, page: Path) -> str:
    """The page of the newest run; empty without any.

    Args:
        folder: Folder of the kept runs.
        page: The file that the text is for.
    """
    kept = Store(folder / "runs.jsonl", PlannerRun).all()
    if not kept:
        return ""
    newest, summary = kept[-1], planner_result(kept[-1].result)
    figures = ", ".join(f"`{name}` {value}" for name, value in summary.summary.items())
    return "\n\n".join(
        [_TITLE, f"Commit {newest.commit}, {newest.hardware}.", f"{figures}.", summary.text, ""]
    )
