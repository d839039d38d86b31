"""Planners that `bench planner` compares: ours, a plain A* in C++, and published packages."""

from __future__ import annotations

import ctypes
import importlib
import math
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.planner.grids import PlannerCase
from nav.astar import plan

CPP = Path(__file__).with_name("astar.cpp")
"""The plain A*."""
_FLAGS = ("-O3", "-march=native", "-std=c++17", "-shared", "-fPIC")
_SMALL = 200
"""Largest grid that a graph of Python objects is made of [cells a side]."""
_LARGE = 2000
"""Largest grid for a planner that takes seconds there [cells a side]."""

Solve = Callable[[], float]
"""Plans once, and returns the cost of the path in metres of free floor, inf without one."""


@dataclass(frozen=True, slots=True)
class Peer:
    """A planner.

    Attributes:
        name: What it is called.
        prepare: Makes what solves a case; None where the planner cannot.
        same_rules: Whether its costs must be ours. Others count in cases where they happen to be.
    """

    name: str
    prepare: Callable[[PlannerCase], Solve | None]
    same_rules: bool = False


def ours() -> Peer:
    """`nav.astar`."""

    def prepare(case: PlannerCase) -> Solve:
        to_xy = case.costmap.grid.to_xy
        start_xy, goals_xy = to_xy(case.start), to_xy(case.goals)

        def solve() -> float:
            path = plan(case.costmap, start_xy, goals_xy)
            return math.inf if path is None else path.cost

        return solve

    return Peer("vizbot", prepare, same_rules=True)


def open_peers() -> tuple[list[Peer], list[str]]:
    """The peers that can be had here, and a line about each one that cannot or was compiled."""
    peers, lines = list[Peer](), list[str]()
    compiler = shutil.which("g++") or shutil.which("clang++")
    if compiler is None:
        lines.append("A* in C++: no compiler (g++ or clang++), left out")
    else:
        began = time.perf_counter()
        library = _compiled(compiler)
        seconds = time.perf_counter() - began
        if library is None:
            lines.append(f"A* in C++: {compiler} does not compile it, left out")
        else:
            lines.append(f"A* in C++: compiled in {seconds:.1f} s by {Path(compiler).name} -O3")
            peers += [_cpp(library, sweep=False), _cpp(library, sweep=True)]
    for module, make in (
        ("skimage.graph", _scikit_image),
        ("nano_astar", _nano_astar),
        ("pyastar2d", _pyastar2d),
        ("networkx", _networkx),
    ):
        try:
            peers.append(make(importlib.import_module(module)))
        except ImportError:
            lines.append(f"{module}: not installed, left out (pip install --group peers)")
    return peers, lines


def _compiled(compiler: str) -> ctypes.CDLL | None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "astar.so"
        command = [compiler, *_FLAGS, "-o", str(path), str(CPP)]
        if subprocess.run(command, capture_output=True).returncode:
            return None
        library = ctypes.CDLL(str(path))
    library.plan.restype = ctypes.c_double
    return library


def _cpp(library: ctypes.CDLL, *, sweep: bool) -> Peer:
    def prepare(case: PlannerCase) -> Solve:
        cost, goals = case.costmap.cost, np.ascontiguousarray(case.goals)
        terminal, path = np.zeros(len(goals)), np.empty(cost.size, np.int32)
        length, start = ctypes.c_int(), int(case.start[0] * cost.shape[1] + case.start[1])
        step = ctypes.c_double(case.costmap.grid.resolution)
        least = ctypes.c_double(case.costmap.least)

        def solve() -> float:
            return float(
                library.plan(
                    _pointer(cost), *cost.shape, step, least, start, _pointer(goals),
                    _pointer(terminal), len(goals), int(sweep), _pointer(path),
                    ctypes.byref(length),
                )
            )  # fmt: skip

        return solve

    name = "A* in C++, swept heuristic" if sweep else "A* in C++"
    return Peer(name, prepare, same_rules=True)


def _pointer(array: NDArray[Any]) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


def _scikit_image(graph: ModuleType) -> Peer:
    def prepare(case: PlannerCase) -> Solve | None:
        if case.size > _LARGE:
            return None
        cost = case.costmap.cost.astype(np.float64)
        start, goals = tuple(case.start), [tuple(goal) for goal in case.goals]

        def solve() -> float:
            search = graph.MCP_Geometric(cost)
            reached, _ = search.find_costs([start], goals, find_all_ends=False)
            return case.costmap.grid.resolution * min(float(reached[goal]) for goal in goals)

        return solve

    return Peer("scikit-image MCP", prepare)


def _nano_astar(package: ModuleType) -> Peer:
    def prepare(case: PlannerCase) -> Solve | None:
        finite = case.costmap.cost[np.isfinite(case.costmap.cost)]
        if len(case.goals) > 1 or (finite != finite[0]).any():
            return None
        grid = np.isinf(case.costmap.cost).astype(np.uint8)
        metre = case.costmap.grid.resolution * float(finite[0])

        def solve() -> float:
            found = package.astar(grid, case.start, case.goals[0])
            return math.inf if found is None else metre * float(found[1])

        return solve

    return Peer("nano-astar", prepare)


def _pyastar2d(package: ModuleType) -> Peer:
    def prepare(case: PlannerCase) -> Solve | None:
        if len(case.goals) > 1:
            return None
        cost, start, goal = case.costmap.cost, tuple(case.start), tuple(case.goals[0])

        def solve() -> float:
            path = package.astar_path(cost, start, goal, allow_diagonal=True)
            return math.inf if path is None else _cost_along(case, path)

        return solve

    return Peer("pyastar2d", prepare)


def _networkx(package: ModuleType) -> Peer:
    def prepare(case: PlannerCase) -> Solve | None:
        if case.size > _SMALL or len(case.goals) > 1:
            return None
        graph, step = _graph(package, case), case.costmap.grid.resolution
        start, goal = tuple(map(int, case.start)), tuple(map(int, case.goals[0]))

        def octile(cell: tuple[int, int], end: tuple[int, int]) -> float:
            down, right = abs(cell[0] - end[0]), abs(cell[1] - end[1])
            longer, shorter = max(down, right), min(down, right)
            return case.costmap.least * step * (longer + (math.sqrt(2.0) - 1.0) * shorter)

        return lambda: float(package.astar_path_length(graph, start, goal, octile))

    return Peer("networkx A*", prepare)


def _graph(package: ModuleType, case: PlannerCase) -> Any:
    cost, step = case.costmap.cost, case.costmap.grid.resolution
    graph = package.Graph()
    for row, col in np.argwhere(np.isfinite(cost)).tolist():
        graph.add_node((row, col))
        for down, right in ((0, 1), (1, 0), (1, 1), (1, -1)):
            there = (row + down, col + right)
            if there[0] >= cost.shape[0] or not 0 <= there[1] < cost.shape[1]:
                continue
            if not np.isfinite([cost[there], cost[row + down, col], cost[row, col + right]]).all():
                continue
            length = step * math.hypot(down, right)
            weight = 0.5 * length * (float(cost[row, col]) + float(cost[there]))
            graph.add_edge((row, col), there, weight=weight)
    return graph


def _cost_along(case: PlannerCase, path: NDArray[np.int64]) -> float:
    """What a path of cells (P, 2) costs by our rules."""
    along = case.costmap.cost[tuple(path.T)].astype(np.float64)
    lengths = np.linalg.norm(np.diff(path, axis=0), axis=1) * case.costmap.grid.resolution
    return float(0.5 * lengths @ (along[1:] + along[:-1]))
