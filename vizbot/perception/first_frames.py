"""The first frames of a run, compared with what a robot's camera can deliver.

A calibration of another resolution, a wrong depth scale, or stamps that are not in seconds make a
map that looks right and is wrong.
"""

from __future__ import annotations

import logging

import numpy as np
from numpy.typing import NDArray

from mapping.calibration.floor_level import estimate_mount
from vizbot.core.camera_limits import FARTHEST_DEPTH
from vizbot.core.program.log_records import NOTICE
from vizbot.core.types import SE3, Intrinsics, RGBDFrame

log = logging.getLogger(__name__)

_FRAMES, _EVERY = 50, 10
"""Number of frames whose stamps and depth are judged, and the interval between those looked at
[frames]."""
_MOST_FRAMES, _VIEWS, _OTHER_VIEW = 600, 4, 0.1
"""Number of frames among which views of the floor are looked for, number of views that is enough,
and least mean change of depth between two of them as a fraction of depth: a bed may fill the view
of a robot at rest."""
_FARTHEST_OFF_CENTRE = 0.1
"""Largest distance of the principal point from the centre, in widths and heights of the image."""
_NEAREST_DEPTH, _LEAST_USABLE = 0.2, 0.7
"""Least depth that a camera measures [m]; least share of depth between it and `FARTHEST_DEPTH`."""
_UPRIGHT = 0.5
"""Least share of gravity along an upright image; a camera that is tilted by 60 degrees has it."""
_HEIGHTS = 0.4, 2.0
"""Heights above the floor that a camera without a base may have [m]."""
_OFF_MOUNT, _AGREEING = 0.2, 0.05
"""Largest error of a height by the settings, and of two estimates that agree, of the height."""
_PERIODS = 1 / 250, 2.0
"""Times from one frame to the next that a camera may have [s]."""


class FirstFrames:
    """Warns, in one line for each fault, where the first frames of a camera cannot be right.

    How high the camera is above the floor is said in any case.
    """

    def __init__(self, T_base_cam: SE3 | None) -> None:
        """`T_base_cam` is where the camera sits by the settings; None where that is not known."""
        self._height = None if T_base_cam is None else float(T_base_cam[2, 3])
        self._frames = 0
        self._stands = False
        self._stamps: list[float] = []
        self._usable: list[float] = []
        self._heights: list[float] = []
        self._view: NDArray[np.float32] | None = None
        self._floor_judged = False

    def note(self, frame: RGBDFrame | None) -> None:
        """Take in the next frame; None says that there are no more."""
        if self._floor_judged:
            return
        if frame is not None:
            self._look(frame)
        if self._frames == _FRAMES if frame is not None else self._frames < _FRAMES:
            self._judge_depth()
            self._judge_stamps()
        enough = self._frames >= _FRAMES and len(self._heights) >= _VIEWS
        if frame is None or enough or self._frames == _MOST_FRAMES:
            self._floor_judged = True
            self._judge_height()

    def _look(self, frame: RGBDFrame) -> None:
        if self._frames == 0:
            _judge_centre(frame.intrinsics)
        if not self._stands and len(frame.imu.accel):
            self._stands = True
            _judge_upright(frame.imu.accel)
        if self._frames < _FRAMES:
            self._stamps.append(frame.stamp)
        if self._frames % _EVERY == 0:
            self._measure(frame)
        self._frames += 1

    def _measure(self, frame: RGBDFrame) -> None:
        view = frame.depth[::16, ::16]
        measured = view[view > 0]
        if len(measured):
            usable = (measured >= _NEAREST_DEPTH) & (measured <= FARTHEST_DEPTH)
            self._usable.append(float(usable.mean()))
        if self._view is not None and not _differ(view, self._view):
            return
        if len(self._heights) < _VIEWS and (T_base_cam := estimate_mount(frame)) is not None:
            self._view = view
            self._heights.append(float(T_base_cam[2, 3]))

    def _judge_depth(self) -> None:
        if self._usable and (usable := float(np.median(self._usable))) < _LEAST_USABLE:
            log.warning(
                "%.0f %% of the depth lies within %g to %g m, which is little: check depth_scale",
                100 * usable,
                _NEAREST_DEPTH,
                FARTHEST_DEPTH,
            )

    def _judge_stamps(self) -> None:
        if len(self._stamps) < 3:
            return
        stamps = np.array(self._stamps)
        period = float(np.median(np.diff(stamps)))
        if period >= 1 and (stamps == np.rint(stamps)).all():
            log.warning(
                "the frames are stamped %s, which look like numbers or nanoseconds: give seconds",
                ", ".join(f"{stamp:.0f}" for stamp in stamps[:3]),
            )
        elif not _PERIODS[0] <= period <= _PERIODS[1]:
            log.warning(
                "the frames are stamped %.4g s apart, where a camera's are %g to %g:"
                " give stamps in seconds",
                period,
                *_PERIODS,
            )

    def _judge_height(self) -> None:
        """A shelf or a bed may be taken for the floor, never something below it: the highest."""
        highest = max(self._heights, default=0.0)
        if sum(height > (1 - _AGREEING) * highest for height in self._heights) < 2:
            log.log(
                NOTICE, "the first frames show no floor: how high the camera is was not checked"
            )
        elif self._height is None and not _HEIGHTS[0] <= highest <= _HEIGHTS[1]:
            log.warning(
                "the floor is %.2f m below the camera, where %g to %g m are usual:"
                " check depth_scale and intrinsics",
                highest,
                *_HEIGHTS,
            )
        elif self._height is not None and abs(highest / self._height - 1) > _OFF_MOUNT:
            log.warning(
                "the floor is %.2f m below the camera, by the settings %.2f m: measure the camera's"
                " height and pitch and set them in [mount]",
                highest,
                self._height,
            )
        else:
            log.log(NOTICE, "the floor is %.2f m below the camera", highest)


def _differ(view: NDArray[np.float32], other: NDArray[np.float32]) -> bool:
    """Whether two coarse depth images (h, w) [m] were taken from different places."""
    both = (view > 0) & (other > 0)
    if not both.any():
        return True
    change = np.abs(view[both] - other[both]).mean()
    return bool(change > _OTHER_VIEW * other[both].mean())


def _judge_centre(camera: Intrinsics) -> None:
    width, height = camera.width, camera.height
    off = max(abs(camera.cx / width - 0.5), abs(camera.cy / height - 0.5))
    if off > _FARTHEST_OFF_CENTRE:
        log.warning(
            "the principal point %.0f, %.0f is far from the centre of %dx%d images:"
            " give the intrinsics of this resolution",
            camera.cx,
            camera.cy,
            width,
            height,
        )


def _judge_upright(accel: NDArray[np.float64]) -> None:
    """Warn by the specific force (K, 3) in `cam` [m/s^2], whose y points down in the image."""
    force = np.median(accel, axis=0)
    if -force[1] < _UPRIGHT * float(np.linalg.norm(force)):
        log.warning(
            "the camera is mounted upside down or on its side, which is not supported: turn it"
        )
