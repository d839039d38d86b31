"""A saved map as a recording of rerun: `map export --format rrd`."""

from __future__ import annotations

import numpy as np
import rerun as rr

from mapping.map_bundle import MapBundle
from vizbot.operator.viewer.map_layers import MapLayers


def map_recording(bundle: MapBundle) -> bytes:
    """The content of an `.rrd` file with the cloud, the obstacle map, the elements and the way."""
    recording = rr.RecordingStream("vizbot_map")
    memory = recording.memory_recording()
    recording.log("map", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    recording.log(
        "map/cloud", rr.Points3D(bundle.cloud_points(), colors=bundle.cloud.rgb, radii=0.01)
    )
    MapLayers(recording).show_grid(bundle.grid)
    recording.log("map/elements", rr.Points3D(bundle.element_points(), radii=0.02))
    way = bundle.final_poses()[:, :3, 3]
    recording.log("map/camera", rr.LineStrips3D([way]) if len(way) else rr.LineStrips3D([]))
    for number, zone in enumerate(bundle.keep_out):
        corners = np.column_stack([zone, np.zeros(len(zone))])
        outline = np.vstack([corners, corners[:1]])
        recording.log(f"map/keep_out/{number}", rr.LineStrips3D([outline]))
    recording.flush()
    return memory.drain_as_bytes()
