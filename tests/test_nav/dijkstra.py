"""SciPy's Dijkstra on the planner's graph."""

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra


def dijkstra_costs(cost: np.ndarray, start: np.ndarray, step: float) -> np.ndarray:
    """Cost to every cell over the graph that `nav.astar.plan` documents, built edge by edge.

    Args:
        cost: (rows, cols) of a metre; inf where the robot cannot be.
        start: (2,) row and column.
        step: Edge of a cell [m].
    """
    rows, cols = cost.shape
    number = np.arange(cost.size).reshape(cost.shape)
    sources, targets, weights = [], [], []
    for dr, dc in ((0, 1), (1, 0), (1, 1), (1, -1)):
        a = np.s_[: rows - dr, max(0, -dc) : cols - max(0, dc)]
        b = np.s_[dr:, max(0, dc) : cols + min(0, dc)]
        weight = 0.5 * (cost[a] + cost[b]) * np.hypot(dr, dc) * step
        if dr and dc:
            below = np.s_[dr:, max(0, -dc) : cols - max(0, dc)]
            beside = np.s_[: rows - dr, max(0, dc) : cols + min(0, dc)]
            weight = np.where(np.isinf(cost[below] + cost[beside]), np.inf, weight)
        usable = np.isfinite(weight)
        sources.append(number[a][usable])
        targets.append(number[b][usable])
        weights.append(weight[usable])
    graph = coo_matrix(
        (np.concatenate(weights), (np.concatenate(sources), np.concatenate(targets))),
        shape=(cost.size, cost.size),
    ).tocsr()
    return dijkstra(graph, directed=False, indices=number[tuple(start)]).reshape(cost.shape)
