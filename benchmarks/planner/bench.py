"""Times of planners on the same grids, with the same goals, by the same rules."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median

import numpy as np

from benchmarks.harness.bench_plan import BenchResult
from benchmarks.harness.fingerprint import (
    REFERENCE_KERNEL,
    commit,
    hardware,
    key_of_sources,
    reference_ms,
)
from benchmarks.harness.store import Store, StoredResult
from benchmarks.harness.tables import markdown_table
from benchmarks.planner.grids import (
    SIZES,
    PlannerCase,
    known_floor,
    planner_cases,
    random_goals,
    recorded_map,
    recorded_maps,
)
from benchmarks.planner.peers import Peer, Solve, open_peers, ours
from nav.config import NavigatorConfig, Reach
from nav.costmap import LiveCostmap
from nav.navigator import GoalPoints, navigate
from vizbot.core.errors import VizbotError
from vizbot.core.geometry import planar
from vizbot.operator.printing import echo

NAME = "planner"
REPETITIONS = 7
"""Number of times that each planner solves a case."""
_PATIENCE = 1.0
"""Time of a run beyond which a planner solves the case no second time [s]."""
_HOME_GOALS = 100
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


@dataclass(frozen=True, slots=True)
class PlannerTime:
    """How long a planner took for a case.

    Attributes:
        planner: Its name.
        equal: Whether its path costs what ours does.
        ms: Median time [ms].
        fastest: Least time [ms].
        slowest: Largest time [ms].
    """

    planner: str
    equal: bool
    ms: float
    fastest: float
    slowest: float


@dataclass(frozen=True, slots=True)
class CaseTimes:
    """All times of a case.

    Attributes:
        name: What was solved, in words.
        kind: What the grid shows.
        distance: `near` or `far`.
        cost: Of the path; None without one.
        times: Ours first.
    """

    name: str
    kind: str
    distance: str
    cost: float | None
    times: tuple[PlannerTime, ...]

    @property
    def rival(self) -> PlannerTime | None:
        """The fastest of the others whose path costs the same."""
        equal = [each for each in self.times[1:] if each.equal]
        return min(equal, key=lambda each: each.ms, default=None)

    @property
    def speedup(self) -> float | None:
        """Time of the rival over ours."""
        return None if self.rival is None else self.rival.ms / self.times[0].ms


@dataclass(frozen=True, slots=True)
class PlannerRun:
    """A whole run.

    Attributes:
        cases: All cases.
        home_map_ms: Median time to make the costmap of the largest recorded map and to navigate on
            it [ms].
        lines: What was compiled or left out.
        reference: Time of the reference kernel [ms].
    """

    cases: tuple[CaseTimes, ...]
    home_map_ms: float
    lines: tuple[str, ...]
    reference: float


def run_planner(quick: bool, folder: Path | None) -> BenchResult:
    """Time all planners on all cases, small grids alone if `quick`, and print their table.

    Without `folder` no results are kept.

    Raises:
        VizbotError: a planner by the same rules finds another cost.
    """
    began = time.perf_counter()
    home_map_ms = home_map_time()
    compiled = (
        f"vizbot: first call (compiles or loads its kernels) {time.perf_counter() - began:.1f} s"
    )
    peers, lines = open_peers()
    cases = []
    for case in planner_cases(SIZES[:1] if quick else SIZES):
        cases.append(case_times(case, [ours(), *peers]))
        echo(_line(cases[-1]), err=True)
    run = PlannerRun(tuple(cases), home_map_ms, (compiled, *lines), reference_ms())
    if folder is not None:
        here = "benchmarks/planner"
        key = key_of_sources("nav", here, f"{here}/astar.cpp")
        Store(folder / "runs.jsonl", PlannerRun).add(key, commit(), hardware(), run)
    return planner_result(run)


def case_times(case: PlannerCase, planners: Sequence[Peer]) -> CaseTimes:
    """Let planners, ours first, solve a case in turns.

    Raises:
        VizbotError: a planner by the same rules finds another cost.
    """
    solvers: dict[str, Solve] = {}
    for planner in planners:
        solve = planner.prepare(case)
        if solve is not None:
            solvers[planner.name] = solve
    times: dict[str, list[float]] = {name: [] for name in solvers}
    costs: dict[str, float] = {}
    for repetition in range(REPETITIONS + 1):
        for name, solve in solvers.items():
            if repetition and times[name] and min(times[name]) > _PATIENCE:
                continue
            began = time.perf_counter()
            costs[name] = solve()
            took = time.perf_counter() - began
            # The first run warms up, and counts where it stays the only one.
            if repetition == 1 and times[name]:
                times[name] = []
            times[name].append(took)
    own = costs[planners[0].name]
    equal = {name: _agree(own, cost) for name, cost in costs.items()}
    for planner in planners:
        if planner.same_rules and not equal.get(planner.name, True):
            raise VizbotError(
                f"{case.name}: {planner.name} finds a path of {costs[planner.name]:.6f}, vizbot one"
                f" of {own:.6f}, which is a bug; report it"
            )
    rows = tuple(
        PlannerTime(name, equal[name], *(round(1000 * f(each), 4) for f in (np.median, min, max)))
        for name, each in times.items()
    )
    found = None if math.isinf(own) else round(own, 3)
    return CaseTimes(case.name, case.kind, case.distance, found, rows)


def home_map_time() -> float:
    """Median time from the largest recorded map to a twist towards one of 100 goals [ms]."""
    config, grid = NavigatorConfig(), recorded_map(recorded_maps()[0])
    costmap = LiveCostmap(config.costmap).update(grid)
    cells = known_floor(costmap)
    start = cells[0]
    goals_xy = costmap.grid.to_xy(random_goals(cells, start, _HOME_GOALS, 100.0, math.inf))
    x, y = costmap.grid.to_xy(start)
    T_map_base = planar(float(x), float(y), 0.0)
    times = []
    for _ in range(2 * REPETITIONS + 1):
        began = time.perf_counter()
        costmap = LiveCostmap(config.costmap).update(grid)
        reach = Reach(distance=0.5, extent=0.2)
        navigation = navigate(costmap, GoalPoints(goals_xy), T_map_base, reach, config)
        times.append(time.perf_counter() - began)
        assert navigation is not None and len(navigation.path) > 1
    return round(1000 * float(np.median(times[1:])), 2)


def planner_result(run: PlannerRun) -> BenchResult:
    """Rows, summary and tables of a run."""
    speedups = _speedups(run.cases)
    groups = {
        group: float(np.median(_speedups(case for case in run.cases if group in _groups(case))))
        for group in dict.fromkeys(group for case in run.cases for group in _groups(case))
        if _speedups(case for case in run.cases if group in _groups(case))
    }
    worst = min(speedups, default=None)
    summary: dict[str, object] = {
        "cases": len(run.cases),
        "median_speedup_over_best_peer": _rounded(np.median(speedups)) if speedups else None,
        "worst_speedup_over_best_peer": _rounded(min(groups.values())) if groups else None,
        "worst_case_speedup": None if worst is None else _rounded(worst),
        "home_map_ms": run.home_map_ms,
    }
    rows: list[dict[str, object]] = [
        {
            "row": case.name,
            "cost": case.cost,
            "ms": case.times[0].ms,
            "rival": None if case.rival is None else case.rival.planner,
            "speedup": case.speedup,
            "times": {each.planner: each.ms for each in case.times},
        }
        for case in run.cases
    ]
    planners = list(dict.fromkeys(each.planner for case in run.cases for each in case.times))
    table = markdown_table(
        ("case", *(f"{name} [ms]" for name in planners), "speedup"),
        [_table_row(case, planners) for case in run.cases],
    )
    by_group = markdown_table(
        ("kind of map or distance", "median speedup"), [[k, v] for k, v in groups.items()]
    )
    notes = [
        f"Median of {REPETITIONS} runs in turns, fastest to slowest in brackets; ~ where the path"
        " costs something else, so that the planner counts as no rival in that case. The speedup is"
        " the time of the fastest rival over ours.",
        f"Recorded map in a grid of 1000 x 1000, costmap and navigation to {_HOME_GOALS} goals:"
        f" {run.home_map_ms:.1f} ms."
        f" Reference kernel ({REFERENCE_KERNEL}): {run.reference:.1f} ms.",
        *run.lines,
    ]
    return BenchResult(NAME, rows, summary, "\n\n".join([*notes, by_group, table]))


def _groups(case: CaseTimes) -> tuple[str, str]:
    return case.kind, case.distance


def _speedups(cases: Iterable[CaseTimes]) -> list[float]:
    return [case.speedup for case in cases if case.speedup is not None]


def _agree(cost: float, other: float) -> bool:
    return cost == other or abs(cost - other) <= 1e-6 * cost


def _rounded(value: float | np.floating) -> float:
    return round(float(value), 3)


def _table_row(case: CaseTimes, planners: Sequence[str]) -> list[object]:
    times = {each.planner: each for each in case.times}
    return [case.name, *(_shown(times.get(name)) for name in planners), case.speedup]


def _shown(each: PlannerTime | None) -> str | None:
    if each is None:
        return None
    mark = "" if each.equal else "~ "
    return f"{mark}{each.ms:.3g} ({each.fastest:.3g} to {each.slowest:.3g})"


def _line(case: CaseTimes) -> str:
    rival = case.rival
    beside = "no rival" if rival is None else f"{rival.planner} {rival.ms:.3g} ms"
    return f"{case.name}: {case.times[0].ms:.3g} ms, {beside}"


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
        f"The reference kernel ({REFERENCE_KERNEL}) takes {line.result.reference:.1f} ms. Commit"
        f" {line.commit}, {line.hardware}."
    )
