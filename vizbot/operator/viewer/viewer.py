"""`run.rrd`: everything a run sees, knows and decides, step by step, for the rerun viewer.

The recording is a file and nothing else: a viewer that is connected to the program and hangs
would hold the robot's loop back. To see the run under way, follow the file (`open_viewer`).
"""

from __future__ import annotations

from collections.abc import Callable
from datetime import timedelta
from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray

from vizbot.core.closeable import Closeable
from vizbot.core.geometry import invert
from vizbot.core.observer import GoalReport, Step
from vizbot.core.types import Intrinsics
from vizbot.operator.figures.colour_scale import ColourScale
from vizbot.operator.figures.image_encoding import jpeg, png
from vizbot.operator.figures.steps import StepFilter, StepRate
from vizbot.operator.report.timeline import Event, Events
from vizbot.operator.viewer.map_layers import MapLayers
from vizbot.operator.viewer.recording_file import RecordingFile

_JPEG_QUALITY = 65
_DEPTH_STRIDE = 4
"""Every fourth row and column of depth is recorded."""
_WRITTEN_EVERY = timedelta(seconds=2)
"""A chunk of a recording takes some 2 kB, however little is in it."""
_REMEMBERED = 50
"""How many steps later the elements of a frame may still arrive."""
_REST_PERIOD = 10.0
"""Between two recorded steps of a robot at rest [s]."""


class Viewer(Closeable):
    """An observer that records for rerun, on the timelines `step` and `stamp` [s]."""

    def __init__(self, path: Path, battery: Callable[[], float | None] = lambda: None) -> None:
        """Begin a recording; `battery` reads the charge, 0 to 1, None where not known.

        Raises:
            ConfigError: it cannot be written.
        """
        batches = rr.ChunkBatcherConfig(flush_tick=_WRITTEN_EVERY)
        self._file = RecordingFile(path)
        self._recording = rr.RecordingStream("vizbot", batcher_config=batches)
        self._recording.save(self._file.entrance, default_blueprint=layout())
        self._recording.send_recording_name(path.parent.name)
        self._recording.set_log_tick_enabled(False)
        self._recording.set_log_time_enabled(False)
        self._recording.log("map", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        self._map = MapLayers(self._recording)
        self._map_number: int | None = None
        self._filter = StepFilter(_REST_PERIOD)
        self._battery = battery
        self._charge: int | None = None
        self._colour_scale = ColourScale()
        self._events = Events()
        self._rate = StepRate()
        self._steps_by_frame: dict[int, tuple[int, float]] = {}
        self._newest_shown = -1
        self._intrinsics: Intrinsics | None = None

    def close(self) -> None:
        """Write what is still to be written."""
        self._recording.disconnect()
        self._file.close()

    def on_step(self, step: Step) -> None:
        """Record what is new in the step."""
        self._set_time(step.index, step.frame.stamp)
        if self._map_number not in (None, step.map_number):
            self._begin_map()
        self._map_number = step.map_number
        self._colour_scale.update(step)
        for event in self._events.changes(step):
            self._log_event(event)
        self._plot_battery()
        self._rate.add(step.frame.stamp)
        if not self._filter.is_news(step):
            return
        self._log_robot(step)
        self._log_pictures(step)
        self._plot(step)
        self._map.show(step, self._colour_scale)
        self._log_matches(step)

    def on_goal(self, report: GoalReport) -> None:
        """Record the answer."""
        self._log_event(Event(f"{report.headline}: {report.reason}"))
        self._map.show_answers(report)

    def _begin_map(self) -> None:
        """Drop what belongs to the map that the run has left: ids and numbers start anew."""
        self._map.clear()
        self._colour_scale, self._filter = ColourScale(), StepFilter(_REST_PERIOD)
        self._steps_by_frame, self._newest_shown = {}, -1

    def _set_time(self, index: int, stamp: float) -> None:
        self._recording.set_time("step", sequence=index)
        self._recording.set_time("stamp", duration=stamp)

    def _log_event(self, event: Event) -> None:
        level = rr.TextLogLevel.WARN if event.warns else rr.TextLogLevel.INFO
        self._recording.log("events", rr.TextLog(event.text, level=level))

    def _log_robot(self, step: Step) -> None:
        T_map_base, T_map_cam = step.T_map_base, step.estimate.T_map_cam
        T_base_cam = invert(T_map_base) @ T_map_cam
        self._recording.log("map/robot", _transform(T_map_base))
        for name in ("camera", "depth"):
            self._recording.log(f"map/robot/{name}", _transform(T_base_cam))

    def _log_pictures(self, step: Step) -> None:
        frame = step.frame
        if frame.intrinsics != self._intrinsics:
            self._intrinsics = frame.intrinsics
            self._recording.log("map/robot/camera", _pinhole(frame.intrinsics, 1))
            self._recording.log("map/robot/depth", _pinhole(frame.intrinsics, _DEPTH_STRIDE))
        picture = jpeg(frame.rgb, _JPEG_QUALITY)
        self._recording.log(
            "map/robot/camera", rr.EncodedImage(contents=picture, media_type="image/jpeg")
        )
        coarse = frame.depth[::_DEPTH_STRIDE, ::_DEPTH_STRIDE]
        # What is finer than a centimetre is noise, and noise cannot be compressed.
        depth_cm = (100.0 * coarse).round().astype(np.uint16)
        self._recording.log(
            "map/robot/depth",
            rr.EncodedDepthImage(png(depth_cm), media_type="image/png", meter=100.0),
        )

    def _plot(self, step: Step) -> None:
        numbers = {"score/threshold": step.threshold if step.goal else None}
        numbers["score/best"] = step.best_score
        numbers["rate/steps_per_second"] = self._rate.rate(step.frame.stamp)
        if step.command is not None:
            numbers["twist/linear"] = step.command.linear
            numbers["twist/angular"] = step.command.angular
        numbers["map/elements"] = float(len(step.points))
        numbers["map/keyframes"] = float(len(step.keyframe_poses))
        for name, number in numbers.items():
            if number is not None:
                self._recording.log(f"plots/{name}", rr.Scalars(number))

    def _plot_battery(self) -> None:
        """Plot the charge in whole percent, where it has changed."""
        battery = self._battery()
        charge = None if battery is None else round(100.0 * battery)
        if charge is not None and charge != self._charge:
            self._charge = charge
            self._recording.log("plots/battery", rr.Scalars(charge))

    def _log_matches(self, step: Step) -> None:
        """Box matching patches in the pictures they were cut from, which are some steps old."""
        self._steps_by_frame[step.frame_number] = step.index, step.frame.stamp
        if len(self._steps_by_frame) > _REMEMBERED:
            del self._steps_by_frame[next(iter(self._steps_by_frame))]
        self._box(step, np.zeros(0, np.int64))
        first = int(np.searchsorted(step.frames, self._newest_shown, side="right"))
        fresh = slice(first, len(step.points))
        self._newest_shown = int(step.frames.max(initial=self._newest_shown))
        if step.scores is None:
            return
        frames, scores = step.frames[fresh], step.scores.look_up(step.points[fresh])
        for number in np.unique(frames).tolist():
            taken_at = self._steps_by_frame.get(number)
            if taken_at is None:
                continue  # a patch of the saved map, whose pictures are not here
            inside = np.flatnonzero(frames == number)
            found = inside[scores[inside] > step.threshold]
            shown = found if len(found) else inside[[np.argmax(scores[inside])]]
            self._set_time(*taken_at)
            self._box(step, fresh.start + shown)
        self._set_time(step.index, step.frame.stamp)

    def _box(self, step: Step, elements: NDArray[np.int64]) -> None:
        scores = np.zeros(0, np.float32)
        if step.scores is not None:
            scores = step.scores.look_up(step.points[elements])
        self._recording.log(
            "map/robot/camera/matches",
            rr.Boxes2D(
                array=step.boxes[elements],
                array_format=rr.Box2DFormat.XYXY,
                colors=self._colour_scale.colours(scores),
                labels=[step.measure.text(score) for score in scores.tolist()],
            ),
        )


def _transform(T_a_b: NDArray[np.float64]) -> rr.Transform3D:
    return rr.Transform3D(translation=T_a_b[:3, 3], mat3x3=T_a_b[:3, :3])


def _pinhole(intrinsics: Intrinsics, stride: int) -> rr.Pinhole:
    """The pinhole of a picture that holds every `stride`-th pixel."""
    return rr.Pinhole(
        focal_length=(intrinsics.fx / stride, intrinsics.fy / stride),
        principal_point=(intrinsics.cx / stride, intrinsics.cy / stride),
        resolution=(intrinsics.width / stride, intrinsics.height / stride),
        camera_xyz=rr.ViewCoordinates.RDF,
        image_plane_distance=0.4,
    )


def layout() -> rrb.Blueprint:
    """The map on the left; camera, plots and events on the right."""
    return rrb.Blueprint(
        rrb.Horizontal(
            rrb.Spatial3DView(
                origin="map",
                contents=["$origin/**", "- $origin/robot/depth/**"],
                name="Map",
            ),
            rrb.Vertical(
                rrb.Tabs(
                    rrb.Spatial2DView(origin="map/robot/camera", name="Camera, and what matched"),
                    rrb.Spatial2DView(origin="map/robot/depth", name="Depth"),
                ),
                rrb.TimeSeriesView(origin="plots/score", name="Score of the best place"),
                rrb.Tabs(
                    rrb.TextLogView(origin="events", name="Events"),
                    rrb.TimeSeriesView(origin="plots/rate", name="Steps per second"),
                    rrb.TimeSeriesView(origin="plots/twist", name="Twist [m/s, rad/s]"),
                    rrb.TimeSeriesView(origin="plots/map", name="Size of the map"),
                    rrb.TimeSeriesView(origin="plots/battery", name="Battery [%]"),
                ),
                row_shares=[3, 2, 2],
            ),
            column_shares=[3, 2],
        ),
        rrb.TimePanel(state="collapsed", timeline="step"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.BlueprintPanel(state="collapsed"),
    )
