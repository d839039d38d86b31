"""The planner's bench: equal problems, costs checked, what is missing said, figures added up."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.harness.store import Store
from benchmarks.planner import bench, peers
from benchmarks.planner.bench import (
    CaseTimes,
    PlannerRun,
    PlannerTime,
    planner_page,
    planner_result,
)
from benchmarks.planner.grids import planner_cases, recorded_map, recorded_maps
from tests.helpers.failing import raising
from tests.test_benchmarks.printed_table import rows_in
from vizbot.core.errors import VizbotError


@pytest.fixture(scope="module")
def cases():
    return {case.name: case for case in planner_cases((200,))}


def case_of(name, distance, *times):
    rows = tuple(PlannerTime(f"p{i}", equal, ms, ms, ms) for i, (ms, equal) in enumerate(times))
    return CaseTimes(f"{name}, {distance}", name, distance, 1.0, rows)


def test_goals_are_where_a_case_says(cases):
    assert {case.kind for case in cases.values()} == {"open", "rooms", "maze", "home"}
    for case in cases.values():
        assert np.isfinite(case.costmap.cost[tuple(case.goals.T)]).all()
        away = np.linalg.norm(case.goals - case.start, axis=1)
        if case.distance == "near":
            assert ((away >= 38) & (away <= 42)).all()
        else:
            assert away.min() > 100


def test_the_peer_in_cpp_finds_the_same_costs(cases):
    found, lines = peers.open_peers()
    ours, cpp = peers.ours(), [peer for peer in found if peer.same_rules]
    if not cpp:
        pytest.skip("no compiler")
    assert len(cpp) == 2 and any("compiled" in line for line in lines)
    for case in cases.values():
        if len(case.goals) <= 100:
            expected = ours.prepare(case)()
            assert math.isfinite(expected)
            for peer in cpp:
                assert peer.prepare(case)() == pytest.approx(expected, rel=1e-9)


def test_a_peer_by_the_same_rules_must_find_the_same_cost(cases):
    case = cases["open, 200 x 200, near, 1 goal"]
    ours = peers.ours()
    cost = ours.prepare(case)()
    cheaper = peers.Peer("cheaper", lambda case: lambda: 0.99 * cost)
    times = bench.case_times(case, [ours, cheaper])
    assert [each.equal for each in times.times] == [True, False]
    assert times.rival is None and times.speedup is None
    wrong = peers.Peer("wrong", lambda case: lambda: 0.99 * cost, same_rules=True)
    with pytest.raises(VizbotError, match=r"wrong finds a path of"):
        bench.case_times(case, [ours, wrong])


def test_what_no_way_leads_to_costs_nothing_that_could_be_told(cases):
    case = cases["open, 200 x 200, near, 1 goal"]
    for cost, found in ((math.inf, None), (12.34567, 12.346)):
        only = peers.Peer("only", lambda case, cost=cost: lambda: cost)
        times = bench.case_times(case, [only])
        assert times.cost == found and [each.equal for each in times.times] == [True]


def test_nano_astar_is_asked_in_cells_where_every_cell_costs_the_same(cases):
    case = next(
        case for case in cases.values()
        if len(case.goals) == 1 and len(set(case.costmap.cost[np.isfinite(case.costmap.cost)])) == 1
    )  # fmt: skip
    asked = []
    module = SimpleNamespace(astar=lambda grid, start, goal: asked.append(grid) or ([], 40.0))
    metre = case.costmap.grid.resolution * case.costmap.cost[tuple(case.start)]
    assert peers._nano_astar(module).prepare(case)() == pytest.approx(40.0 * metre)
    assert np.array_equal(asked[0] == 1, np.isinf(case.costmap.cost))
    module.astar = lambda *_: None
    assert peers._nano_astar(module).prepare(case)() == math.inf
    several = next(case for case in cases.values() if len(case.goals) > 1)
    assert peers._nano_astar(module).prepare(several) is None


def test_pyastar2d_finds_a_path_that_is_priced_by_our_rules(cases):
    case = cases["open, 200 x 200, near, 1 goal"]
    row, column = case.start
    module = SimpleNamespace(
        astar_path=lambda *_, **__: np.array([(row, column), (row + 1, column)])
    )
    expected = case.costmap.grid.resolution * case.costmap.cost[row + 1, column]
    assert peers._pyastar2d(module).prepare(case)() == pytest.approx(expected, rel=0.5)
    module.astar_path = lambda *_, **__: None
    assert peers._pyastar2d(module).prepare(case)() == math.inf


@pytest.mark.parametrize(("quick", "sizes"), [(True, {200}), (False, set(bench.SIZES))])
def test_a_quick_run_leaves_out_the_large_grids(monkeypatch, quick, sizes):
    asked = []
    monkeypatch.setattr(bench, "planner_cases", lambda sizes: asked.extend(sizes) or [])
    monkeypatch.setattr(bench, "home_map_time", lambda: 1.0)
    monkeypatch.setattr(bench, "reference_ms", lambda: 1.0)
    monkeypatch.setattr(bench, "open_peers", lambda: ([], []))
    monkeypatch.setattr(bench, "planner_result", lambda run: run)
    assert bench.run_planner(quick, None).cases == () and set(asked) == sizes


def test_a_missing_package_or_compiler_is_a_line(monkeypatch):
    monkeypatch.setattr(peers.importlib, "import_module", raising(ImportError("nowhere")))
    monkeypatch.setattr(peers.shutil, "which", lambda name: None)
    found, lines = peers.open_peers()
    assert found == []
    assert len(lines) == 5 and all("left out" in line for line in lines)
    monkeypatch.setattr(peers.shutil, "which", lambda name: "false")
    found, lines = peers.open_peers()
    assert found == [] and "does not compile" in lines[0]


RUN = PlannerRun(
    (
        case_of("open", "near", (1.0, True), (4.0, True), (0.5, False)),
        case_of("open", "far", (1.0, True), (3.0, True), (2.0, True)),
        case_of("maze", "near", (2.0, True), (1.0, True)),
        case_of("maze", "far", (1.0, True), (0.9, False)),
    ),
    12.5,
    ("a line",),
    40.0,
)


def test_the_summary_has_the_median_and_the_worst_group():
    result = planner_result(RUN)
    assert result.summary == {
        "cases": 4,
        "median_speedup_over_best_peer": 2.0,
        "worst_speedup_over_best_peer": 0.5,
        "worst_case_speedup": 0.5,
        "home_map_ms": 12.5,
    }
    assert [row["rival"] for row in result.rows] == ["p1", "p2", "p1", None]
    assert "~ 0.5" in result.text and "a line" in result.text


def test_recorded_maps_are_maps_of_homes():
    for path in recorded_maps():
        grid = recorded_map(path)
        known = grid.occupancy != 0.5
        assert set(np.unique(grid.occupancy)) == {0.0, 0.5, 1.0}
        assert 10_000 < known.sum() < 0.1 * known.size
    assert bench.home_map_time() > 0.0


def test_the_page_has_a_line_for_each_kind_of_map_and_distance(tmp_path):
    assert planner_page(tmp_path, tmp_path / "planner.md") == ""
    Store(tmp_path / "runs.jsonl", PlannerRun).add("key", "c0ffee", "2 cores", RUN)
    text = planner_page(tmp_path, tmp_path / "planner.md")
    assert ["open, near", "1", "1", "4", "4.00", "4.00"] in rows_in(text)
    assert ["maze, far", "1", "1", "-", "-", "-"] in rows_in(text)
    assert "Over all 4 cases the median speedup is 2.0" in text and "Commit c0ffee" in text
