"""Fewer triangles for models that were drawn for close-ups."""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from sim_stubs.homes.furniture.wavefront import Surface
from vizbot.core.program.kernels import kernel

_NEIGHBOURS = 24
"""Original corners looked at for the triangle under a new corner: enough for a fan or two."""


def decimated(surfaces: Sequence[Surface], max_triangles: int) -> tuple[Surface, ...]:
    """The same shape with at most about `max_triangles`; a model below that comes back as it is.

    Edges collapse onto one of their ends in the order of the quadric error (Garland and Heckbert,
    "Surface simplification using quadric error metrics", 1997) over all surfaces together, so that
    flat ones pay for round ones. Texture coordinates are looked up on the original surface.
    Surfaces left without triangles are dropped.
    """
    if sum(len(surface.corners) for surface in surfaces) <= max_triangles:
        return tuple(surfaces)
    points, faces, owners = _welded(surfaces)
    kept = _collapse_edges(points, faces, _quadrics(points, faces), max_triangles)
    kept_owners = owners[kept[:, 0]]
    return tuple(
        replace(surface, corners=corners, texcoords=_texcoords(surface, corners))
        for index, surface in enumerate(surfaces)
        if len(corners := points[kept[kept_owners == index]])
    )


def _welded(
    surfaces: Sequence[Surface],
) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]:
    """Distinct points (N, 3), faces (F, 3) into them, and the surface of each point (N,)."""
    owners = np.repeat(np.arange(len(surfaces)), [3 * len(s.corners) for s in surfaces])
    corners = np.concatenate([surface.corners.reshape(-1, 3) for surface in surfaces])
    # Rounding to a hundred-thousandth of the model joins what the file wrote twice.
    keys = np.round(corners / np.ptp(corners, axis=0).max() * 1e5).astype(np.int64)
    _, first, inverse = np.unique(
        np.column_stack([owners, keys]), axis=0, return_index=True, return_inverse=True
    )
    faces = inverse.reshape(-1, 3)
    faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
    # Sheets drawn from both sides become single: conversion draws their backs anew.
    _, distinct = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
    return corners[first], faces[np.sort(distinct)], owners[first]


def _quadrics(points: NDArray[np.float64], faces: NDArray[np.int64]) -> NDArray[np.float64]:
    """(N, 4, 4) sums of squared distance to the planes around each point, weighted by area.

    A border edge adds the plane through it and across its face, or flat sheets would shrink.
    """
    corners = points[faces]
    facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    quadrics = np.zeros((len(points), 4, 4))
    for corner in range(3):
        np.add.at(quadrics, faces[:, corner], _planes(facing, corners[:, 0]))
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    _, inverse, uses = np.unique(
        np.sort(edges, axis=1), axis=0, return_inverse=True, return_counts=True
    )
    border = uses[inverse.ravel()] == 1
    start, end = points[edges[border, 0]], points[edges[border, 1]]
    normal = np.tile(facing, (3, 1))[border]
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
    length = np.linalg.norm(end - start, axis=1, keepdims=True)
    across = _planes(np.cross(end - start, normal) * length, start)
    for column in range(2):
        np.add.at(quadrics, edges[border, column], across)
    return quadrics


def _planes(
    weighted_normals: NDArray[np.float64], points: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(M, 4, 4) squared distance to planes through `points`, times the length of the normal."""
    weight = np.linalg.norm(weighted_normals, axis=1, keepdims=True)
    normal = weighted_normals / np.maximum(weight, 1e-30)
    plane = np.hstack([normal, -(normal * points).sum(axis=1, keepdims=True)])
    return np.asarray(weight[:, :, None] * plane[:, :, None] * plane[:, None, :])


@kernel()
def _collapse_edges(
    points: NDArray[np.float64], faces: NDArray[np.int64], quadrics: NDArray[np.float64], most: int
) -> NDArray[np.int64]:
    """Faces (F', 3) left of `faces` (F, 3) after collapsing the cheapest edges."""
    faces = faces.copy()
    quadrics = quadrics.copy()
    alive = np.ones(len(faces), np.bool_)
    version = np.zeros(len(points), np.int64)
    # The corners at each point as linked lists, so that the lists of two points join at once.
    first = np.full(len(points), -1)
    last = np.full(len(points), -1)
    following = np.full(3 * len(faces), -1)
    queue = [(0.0, 0, 0, 0, 0) for _ in range(0)]
    for corner in range(3 * len(faces)):
        point, other = faces[corner // 3, corner % 3], faces[corner // 3, (corner + 1) % 3]
        following[corner] = first[point]
        if first[point] < 0:
            last[point] = corner
        first[point] = corner
        queue.append((_cost(points, quadrics, point, other), point, other, 0, 0))
        queue.append((_cost(points, quadrics, other, point), other, point, 0, 0))
    heapq.heapify(queue)
    count = len(faces)
    while count > most and len(queue) > 0:
        _, gone, kept, gone_version, kept_version = heapq.heappop(queue)
        if version[gone] != gone_version or version[kept] != kept_version:
            continue
        if _folds(points, faces, alive, first[gone], following, gone, kept):
            continue
        corner = first[gone]
        while corner >= 0:
            face = corner // 3
            if alive[face]:
                faces[face, corner % 3] = kept
                if (faces[face] == kept).sum() > 1:
                    alive[face] = False
                    count -= 1
            corner = following[corner]
        following[last[kept]] = first[gone]
        last[kept] = last[gone]
        quadrics[kept] += quadrics[gone]
        version[gone] += 1
        version[kept] += 1
        corner = first[kept]
        while corner >= 0:
            if alive[corner // 3]:
                for other in faces[corner // 3]:
                    if other != kept:
                        ours, theirs = version[kept], version[other]
                        cost = _cost(points, quadrics, kept, other)
                        heapq.heappush(queue, (cost, kept, other, ours, theirs))
                        cost = _cost(points, quadrics, other, kept)
                        heapq.heappush(queue, (cost, other, kept, theirs, ours))
            corner = following[corner]
    return faces[alive]


@kernel()
def _cost(
    points: NDArray[np.float64], quadrics: NDArray[np.float64], gone: Any, kept: Any
) -> float:
    """Quadric error of moving `gone` to `kept`; of equal ones the shorter edge is cheaper."""
    x, y, z = points[kept]
    q = quadrics[gone] + quadrics[kept]
    error = (
        q[0, 0] * x * x
        + q[1, 1] * y * y
        + q[2, 2] * z * z
        + 2.0 * (q[0, 1] * x * y + q[0, 2] * x * z + q[1, 2] * y * z)
        + 2.0 * (q[0, 3] * x + q[1, 3] * y + q[2, 3] * z)
        + q[3, 3]
    )
    edge = points[gone] - points[kept]
    return float(max(error, 0.0) + 1e-6 * (edge * edge).sum() ** 2)


@kernel()
def _folds(
    points: NDArray[np.float64],
    faces: NDArray[np.int64],
    alive: NDArray[np.bool_],
    corner: np.int64,
    following: NDArray[np.int64],
    gone: Any,
    kept: Any,
) -> bool:
    """Whether a face around `gone` would turn by more than 75 degrees or become a line."""
    while corner >= 0:
        face = faces[corner // 3]
        if alive[corner // 3] and not (face == kept).any():
            turn = corner % 3
            one, two = points[face[(turn + 1) % 3]], points[face[(turn + 2) % 3]]
            before = np.cross(one - points[gone], two - points[gone])
            after = np.cross(one - points[kept], two - points[kept])
            product = np.sqrt((before * before).sum() * (after * after).sum())
            if (before * after).sum() < 0.25 * product or (after * after).sum() < 1e-24:
                return True
        corner = following[corner]
    return False


def _texcoords(source: Surface, corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Texture coordinates (F, 3, 2) of new `corners` (F, 3, 3), from the nearest source triangle.

    Each corner asks from slightly inside its face, so that the corners of a face on a seam find
    the face's own side of it.
    """
    if not source.texcoords.any():
        return np.zeros((*corners.shape[:2], 2))
    inside = corners + 0.02 * (corners.mean(axis=1, keepdims=True) - corners)
    queries = inside.reshape(-1, 3)
    count = min(_NEIGHBOURS, 3 * len(source.corners))
    _, nearest = cKDTree(source.corners.reshape(-1, 3)).query(queries, k=count)
    candidates = nearest // 3
    weights = _barycentric(source.corners[candidates], queries[:, None])
    feet = np.einsum("qkc,qkcd->qkd", weights, source.corners[candidates])
    best = np.linalg.norm(feet - queries[:, None], axis=-1).argmin(axis=1)
    chosen = candidates[np.arange(len(queries)), best]
    weights = _barycentric(source.corners[chosen], corners.reshape(-1, 3))
    texcoords = np.einsum("qc,qcd->qd", weights, source.texcoords[chosen])
    return np.asarray(texcoords.reshape(-1, 3, 2))


def _barycentric(
    triangles: NDArray[np.float64], points: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Weights (..., 3) of the point of each triangle (..., 3, 3) near each point (..., 3)."""
    origin = triangles[..., 0, :]
    along, across = triangles[..., 1, :] - origin, triangles[..., 2, :] - origin
    offset = points - origin
    aa, ab, bb = (along * along).sum(-1), (along * across).sum(-1), (across * across).sum(-1)
    oa, ob = (offset * along).sum(-1), (offset * across).sum(-1)
    area = np.maximum(aa * bb - ab * ab, 1e-30)
    second, third = (bb * oa - ab * ob) / area, (aa * ob - ab * oa) / area
    weights = np.stack([1.0 - second - third, second, third], axis=-1).clip(0.0)
    return np.asarray(weights / weights.sum(axis=-1, keepdims=True))
