"""Post-processing of depth by the SDK's own filters, before depth is registered to colour.

In disparity, as Intel recommends, where the error of a stereo camera does not depend on distance:
a step that counts as an edge is then the same near and far.
"""

from __future__ import annotations

import time
from typing import Any

from drivers.realsense.config import DepthFilterConfig, SpatialFilterConfig, TemporalFilterConfig
from drivers.realsense.sdk import rs

_FARTHEST = 16.0
"""Of the SDK's threshold filter [m]."""


class DepthFilters:
    """The configured filters, in order; without any, frames pass unchanged."""

    def __init__(self, config: DepthFilterConfig) -> None:
        """Build a chain for one run of the streams: temporal filters have state."""
        self._chain: list[Any] = []
        self._seconds = 0.0
        self._frames = 0
        if config.nearest is not None or config.farthest is not None:
            farthest = _FARTHEST if config.farthest is None else config.farthest
            nearest = min(config.nearest or 0.0, _FARTHEST)
            self._chain.append(rs.threshold_filter(nearest, min(farthest, _FARTHEST)))
        smoothing = []
        if config.spatial is not None:
            smoothing.append(_spatial(config.spatial))
        if config.temporal is not None:
            smoothing.append(_temporal(config.temporal))
        if smoothing:
            to_disparity, to_depth = rs.disparity_transform(True), rs.disparity_transform(False)
            self._chain += [to_disparity, *smoothing, to_depth]

    @property
    def cost(self) -> float:
        """Mean time per frame on this machine so far [s]; 0 without filters."""
        return self._seconds / self._frames if self._frames else 0.0

    def process(self, frames: Any) -> Any:
        """The frameset with its depth filtered."""
        if not self._chain:
            return frames
        began = time.perf_counter()
        for stage in self._chain:
            frames = stage.process(frames)
        self._seconds += time.perf_counter() - began
        self._frames += 1
        return frames.as_frameset()


def _spatial(config: SpatialFilterConfig) -> Any:
    stage = rs.spatial_filter()
    stage.set_option(rs.option.filter_magnitude, config.passes)
    stage.set_option(rs.option.filter_smooth_alpha, config.alpha)
    stage.set_option(rs.option.filter_smooth_delta, config.delta)
    return stage


def _temporal(config: TemporalFilterConfig) -> Any:
    stage = rs.temporal_filter()
    stage.set_option(rs.option.filter_smooth_alpha, config.alpha)
    stage.set_option(rs.option.filter_smooth_delta, config.delta)
    stage.set_option(rs.option.holes_fill, config.persistence)
    return stage
