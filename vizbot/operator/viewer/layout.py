"""How the rerun viewer is laid out when it opens a run."""

from __future__ import annotations

import rerun.blueprint as rrb


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
