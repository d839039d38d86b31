"""The maps of a run as rerun shows them; only changes are sent."""

from __future__ import annotations

import cv2
import numpy as np
import rerun as rr
from numpy.typing import NDArray

from vizbot.core.geometry import back_project
from vizbot.core.observer import GoalReport, Step
from vizbot.core.types import SE3, OccupancyGrid
from vizbot.operator.figures.colour_scale import ColourScale
from vizbot.operator.figures.panels import known_cells, shaded
from vizbot.operator.figures.steps import Track

_BLOCK = 256
"""Elements that share an entity: a new one causes no more of them to be sent again."""
_MOVED = 0.02
"""Points that the graph has moved by less stay where they were shown [m]."""
_CLOUD_STRIDE = 16
"""Every so many pixels of a keyframe are in the cloud, either way."""
_CLOUD_RANGE = 4.0
"""[m]"""
_ABOVE_FLOOR = 0.03
"""Lines on the floor are drawn above the obstacle map [m]."""
_TRACK_BLOCK, _TRACK_SPACING = 64, 0.01
"""Positions of the track that share an entity, and the least distance between them [m]."""
_ENTITIES = (
    "elements", "cloud", "occupancy", "keyframes", "closures", "track", "path", "target",
    "frontiers", "answers",
)  # fmt: skip
_RED, _GREEN, _BLUE, _ORANGE, _VIOLET = (
    (205, 45, 40), (30, 150, 60), (60, 110, 220), (240, 150, 30), (150, 80, 200),
)  # fmt: skip


class MapLayers:
    """Sends the layers of the map to a recording, and knows what it already holds."""

    def __init__(self, recording: rr.RecordingStream) -> None:
        self._recording = recording
        self._shown: dict[str, NDArray[np.float64]] = {}
        self._clouds: set[int] = set()
        self._blocks = 0
        self._track = Track(_TRACK_BLOCK, _TRACK_SPACING)
        self._track_block = 0

    def clear(self) -> None:
        """Clear all layers: the run has left this map, and another one begins."""
        for name in _ENTITIES:
            self._recording.log(f"map/{name}", rr.Clear(recursive=True))
        self._shown, self._clouds = {}, set()
        self._track, self._track_block = Track(_TRACK_BLOCK, _TRACK_SPACING), 0

    def show(self, step: Step, colour_scale: ColourScale) -> None:
        """Send what is new in a step."""
        self._show_elements(step, colour_scale)
        self.show_grid(step.grid)
        self._show_graph(step)
        self._show_cloud(step)
        self._show_plan(step)
        self._show_track(step.T_map_base[:2, 3])

    def show_answers(self, report: GoalReport) -> None:
        """Send the best places for a goal that has ended."""
        self._recording.log(
            "map/answers",
            rr.Points3D(
                np.array([candidate.position for candidate in report.candidates]).reshape(-1, 3),
                colors=_GREEN,
                radii=0.1,
                labels=[
                    f"{report.text}: {rank}, {report.measure} {report.measure.text(each.score)}"
                    for rank, each in enumerate(report.candidates, 1)
                ],
            ),
        )

    def _show_elements(self, step: Step, colour_scale: ColourScale) -> None:
        starts = range(0, len(step.points), _BLOCK)
        for block in range(len(starts), self._blocks):  # the map was compacted
            self._recording.log(f"map/elements/{block:04d}", rr.Clear(recursive=False))
        self._blocks = len(starts)
        for block, start in enumerate(starts):
            points = step.points[start : start + _BLOCK]
            scores = (
                np.zeros(len(points), np.float32)
                if step.scores is None
                else step.scores.look_up(points)
            )
            entity = f"map/elements/{block:04d}"
            moved = self._is_new(entity, points)
            if not self._is_new(f"{entity}/score", scores, 0.0) and not moved:
                continue
            self._recording.log(
                entity,
                rr.Points3D(
                    points,
                    colors=colour_scale.colours(scores),
                    radii=0.025 + 0.045 * colour_scale.levels(scores),
                ),
                rr.AnyValues(score=scores),
            )

    def show_grid(self, grid: OccupancyGrid) -> None:
        """Send the obstacle map."""
        (top, left), (bottom, right) = known_cells(grid, 0.0)
        shade = shaded(grid)[top:bottom, left:right]
        if not self._is_new("map/occupancy", shade, 0.0):
            return
        rows, cols = shade.shape
        image_format = rr.components.ImageFormat(
            width=cols, height=rows, color_model="L", channel_datatype="U8"
        )
        # Row 0 of a picture is its upper edge, row 0 of the grid the southern one.
        self._recording.log(
            "map/occupancy",
            rr.GridMap(
                data=np.ascontiguousarray(shade[::-1]).tobytes(),
                format=image_format,
                cell_size=grid.resolution,
                colormap=rr.components.Colormap.Grayscale,
                translation=[*(grid.origin + grid.resolution * np.array([left, top])), 0.0],
            ),
        )

    def _show_graph(self, step: Step) -> None:
        places, ends = step.keyframe_places, step.closure_ends
        if self._is_new("map/keyframes", places):
            self._recording.log("map/keyframes", rr.Points3D(places, colors=_BLUE, radii=0.03))
            self._recording.log(
                "map/keyframes/in_order", rr.LineStrips3D([places], colors=_BLUE, radii=0.006)
            )
        if self._is_new("map/closures", ends):
            self._recording.log(
                "map/closures", rr.LineStrips3D(list(ends), colors=_ORANGE, radii=0.012)
            )

    def _show_cloud(self, step: Step) -> None:
        """Send the coloured points of a new keyframe; all clouds move with their keyframes."""
        estimate = step.estimate
        for keyframe in self._clouds:
            self._place_cloud(keyframe, step.keyframe_poses[keyframe])
        if not estimate.is_keyframe or estimate.keyframe in self._clouds:
            return
        stride = _CLOUD_STRIDE
        points = back_project(step.frame.depth, step.frame.intrinsics)[::stride, ::stride]
        near = (points[..., 2] > 0.0) & (points[..., 2] < _CLOUD_RANGE)
        rgb = cv2.blur(step.frame.rgb, (5, 5))[::stride, ::stride]
        self._clouds.add(estimate.keyframe)
        self._place_cloud(estimate.keyframe, step.keyframe_poses[estimate.keyframe])
        self._recording.log(
            f"map/cloud/{estimate.keyframe}",
            rr.Points3D(points[near], colors=rgb[near], radii=0.01),
        )

    def _place_cloud(self, keyframe: int, T_map_cam: SE3) -> None:
        entity = f"map/cloud/{keyframe}"
        if self._is_new(entity, T_map_cam):
            self._recording.log(
                entity, rr.Transform3D(translation=T_map_cam[:3, 3], mat3x3=T_map_cam[:3, :3])
            )

    def _show_track(self, xy: NDArray[np.float64]) -> None:
        """Draw the track on to x, y (2,)."""
        if not self._track.add(xy):
            return
        size = len(self._track.xy)
        if size > 1:
            self._recording.log(
                f"map/track/{self._track_block:04d}",
                rr.LineStrips3D([_on_floor(self._track.xy)], colors=_RED, radii=0.015),
            )
        if size == _TRACK_BLOCK:
            self._track = Track(_TRACK_BLOCK, _TRACK_SPACING)
            self._track.add(xy)
            self._track_block += 1

    def _show_plan(self, step: Step) -> None:
        path = _on_floor(np.zeros((0, 2)) if step.path is None else step.path)
        if self._is_new("map/path", path):
            strips = [path] if len(path) else []
            self._recording.log("map/path", rr.LineStrips3D(strips, colors=_GREEN, radii=0.02))
        target = _on_floor(np.zeros((0, 2)) if step.target is None else step.target[None])
        if self._is_new("map/target", target):
            self._recording.log("map/target", rr.Points3D(target, colors=_GREEN, radii=0.12))
        frontiers = _on_floor(step.frontiers)
        if self._is_new("map/frontiers", frontiers):
            self._recording.log("map/frontiers", rr.Points3D(frontiers, colors=_VIOLET, radii=0.08))

    def _is_new(
        self,
        entity: str,
        value: NDArray[np.floating] | NDArray[np.uint8],
        tolerance: float = _MOVED,
    ) -> bool:
        """Whether a value has another shape than the one shown, or differs by over `tolerance`."""
        shown = self._shown.get(entity)
        if (
            shown is not None
            and shown.shape == value.shape
            and not (np.abs(value.astype(np.float64) - shown) > tolerance).any()
        ):
            return False
        self._shown[entity] = value.astype(np.float64)
        return True


def _on_floor(xy: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N, 3) of (N, 2) x, y."""
    return np.column_stack([xy, np.full(len(xy), _ABOVE_FLOOR)])
