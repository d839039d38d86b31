"""Patches of a real recording, with what is on them by a person's marks."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.encoder.contact_sheet import tile_of
from benchmarks.encoder.separation import AskedPatches
from benchmarks.questions.marks import (
    MarkedPlaces,
    places_of,
    read_questions,
)
from benchmarks.questions.poses import estimated_poses, recorded_poses
from drivers.tum_sequence import RecordedSequence
from mapping.clip.encoder import ClipEncoder
from mapping.clip.patches import patch_boxes
from vizbot.config import Config
from vizbot.core.errors import ConfigError
from vizbot.core.geometry import back_project, invert, transform
from vizbot.core.types import SE3, RGBDFrame

FRAMES = 60
"""Frames of a recording that are asked, at most, besides those with marks."""
OFF = 0.3
"""A mark is in sight where the depth at it differs by less than this [m]."""
INSIDE = 0.1
"""Share of a patch's edge along its border in which a mark shows too little of its thing."""
FILLED = 0.2
"""Share of a patch's pixels that have to lie around a mark, for the patch to show its thing."""
AROUND = 0.5
"""How far from a mark a thing may reach [m], and how far beyond that nothing is certain [m]."""
_STRIDE = 4
"""Step between the pixels whose points are looked at [px]."""


def patches_of_recording(
    sequence: Path, questions: Path, encoder: ClipEncoder, config: Config
) -> tuple[AskedPatches, tuple[str, ...], list[NDArray[np.uint8]]]:
    """The patches that the mapper cuts from frames of a recording, the things, and patches drawn.

    Args:
        sequence: Folder in TUM layout; without a `groundtruth.txt` our own SLAM makes the poses.
        questions: TOML file of the marks; things without a mark are left out.
        encoder: The encoder.
        config: Says how patches are cut, and poses estimated.

    Raises:
        ConfigError: a file cannot be used, or nothing is marked.
    """
    marked = tuple(question for question in read_questions(questions) if question.marks)
    if not marked:
        raise ConfigError(f"questions {questions}: nothing is marked; mark what the pictures show")
    names = tuple(question.text for question in marked)
    texts = encoder.embed_texts(list(names))
    several: list[AskedPatches] = []
    tiles: list[NDArray[np.uint8]] = []
    with RecordedSequence(sequence) as camera:
        Ts_world_cam = recorded_poses(camera, sequence)
        if Ts_world_cam is None:
            Ts_world_cam = estimated_poses(camera, config.perception.slam)
        places = places_of(camera, marked, Ts_world_cam)
        chosen = {mark.frame for question in marked for mark in question.marks}
        chosen.update(np.linspace(0, len(camera) - 1, FRAMES).astype(int).tolist())
        for number in sorted(chosen):
            if np.isnan(Ts_world_cam[number]).any():
                continue
            frame = camera.frame(number)
            size = frame.intrinsics.width, frame.intrinsics.height
            boxes = patch_boxes(*size, config.perception.clip_mapper)
            patches = [frame.rgb[v:b, u:r] for u, v, r, b in boxes]
            embeddings = encoder.embed_images(patches)
            tiles += map(tile_of, patches)
            several.append(
                AskedPatches(
                    embeddings @ texts.T,
                    shown_in(frame, boxes, places, Ts_world_cam[number]),
                    boxes[:, 2].astype(np.int64) - boxes[:, 0],
                    np.full(len(boxes), ""),
                )
            )
    return AskedPatches.joined(several), names, tiles


def shown_in(
    frame: RGBDFrame, boxes: NDArray[np.int32], places: Sequence[MarkedPlaces], T_world_cam: SE3
) -> NDArray[np.float32]:
    """How clearly patches (P,) of a frame show marked things (C,): 1, 0, or NaN (P, C).

    A patch shows a thing where a mark of it is in sight, not at the patch's border, and the points
    around the mark fill enough of the patch. It does not where none of its points is near a mark.
    """
    points = transform(
        T_world_cam,
        back_project(frame.depth, frame.intrinsics)[::_STRIDE, ::_STRIDE].reshape(-1, 3),
    )
    measured = (frame.depth[::_STRIDE, ::_STRIDE] > 0).ravel()
    shape = frame.depth[::_STRIDE, ::_STRIDE].shape
    shown = np.zeros((len(boxes), len(places)), np.float32)
    for column, place in enumerate(places):
        for mark in place.points:
            away = np.linalg.norm(points - mark, axis=1)
            around = (measured & (away <= AROUND)).reshape(shape)
            near = (measured & (away <= 2 * AROUND)).reshape(shape)
            pixel = _pixel_of(mark, frame, T_world_cam)
            for row, (u0, v0, u1, v1) in enumerate(-(-boxes // _STRIDE)):
                border = INSIDE * (boxes[row, 2] - boxes[row, 0])
                inside = pixel is not None and bool(
                    (boxes[row, :2] + border <= pixel).all()
                    and (pixel < boxes[row, 2:] - border).all()
                )
                if inside and around[v0:v1, u0:u1].mean() >= FILLED:
                    shown[row, column] = 1.0
                elif near[v0:v1, u0:u1].any() and shown[row, column] != 1.0:
                    shown[row, column] = np.nan
    return shown


def _pixel_of(
    mark: NDArray[np.float64], frame: RGBDFrame, T_world_cam: SE3
) -> NDArray[np.float64] | None:
    """Column and row (2,) of a mark in a frame [px]; None where it is hidden or out of it."""
    x, y, z = transform(invert(T_world_cam), mark[None])[0]
    if z <= 0.0:
        return None
    camera = frame.intrinsics
    u, v = camera.fx * x / z + camera.cx, camera.fy * y / z + camera.cy
    if not (0 <= u < camera.width and 0 <= v < camera.height):
        return None
    depth = float(frame.depth[int(v), int(u)])
    return np.array([u, v]) if abs(depth - z) < OFF else None
