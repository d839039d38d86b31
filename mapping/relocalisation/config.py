"""Settings of relocalisation."""

from __future__ import annotations

from pydantic import Field

from vizbot.core.settings import Settings


class DepthConsistencyConfig(Settings):
    """How many corners decide for or against a pose."""

    min_corners: int = Field(default=20, ge=1, le=10000)
    """At least this number of corners above the floor must agree, or differ, to decide about a pose
    [1]."""
    min_share: float = Field(default=0.5, ge=0.01, le=1.0)
    """At least this share of the corners above the floor must agree, or differ, to decide [1]."""


class KidnappingConfig(Settings):
    """When a robot counts as carried away, and so as lost."""

    plenty_corners: int = Field(default=80, ge=1, le=10000)
    """An image shows plenty from this number of corners on [1]."""
    break_corners: int = Field(default=250, ge=1, le=10000)
    """A break in tracking is where this number of corners of one frame should be in view in the
    next, none is, and depth differs there [1]."""
    lost_frames: int = Field(default=2, ge=1, le=1000)
    """The robot is lost after this number of frames in a row that show plenty, but not what they
    should; somebody who walks by is in view for fewer [1]."""
    lost_frames_in_place: int = Field(default=8, ge=1, le=1000)
    """The robot is lost after this number of frames that show plenty, but not what they should,
    where depth confirms the pose or did at the break, since blur and plain walls match nothing
    [1]."""


class ScanMatchConfig(Settings):
    """How a local grid is compared with a map."""

    cell: float = Field(default=0.1, ge=0.01, le=1.0)
    """Poses that are tried lie on a lattice of this spacing [m]."""
    angle: float = Field(default=0.05, ge=0.005, le=1.6)
    """Poses that are tried differ by this angle; the best is then refined to the cells [rad]."""
    sigma: float = Field(default=0.1, ge=0.01, le=2.0)
    """At the right pose obstacles deviate from the map's by this (standard deviation) [m]."""
    free_space_penalty: float = Field(default=0.3, ge=0.0, le=10.0)
    """An obstacle in free space costs this share of an obstacle's reward on one [1]."""
    missed_obstacle_penalty: float = Field(default=0.4, ge=0.0, le=10.0)
    """A free cell on an obstacle of the map costs this share of an obstacle's reward on one [1]."""
    different_distance: float = Field(default=0.6, ge=0.01, le=20.0)
    """Two poses count as different from this distance on [m]."""
    different_angle: float = Field(default=0.45, ge=0.01, le=3.2)
    """Two poses count as different from this angle on [rad]."""
    min_cells: int = Field(default=20, ge=1, le=100000)
    """A pose is judged where at least this number of obstacle cells lie on known cells [1]."""


class LocalMapConfig(Settings):
    """Relocalisation by obstacles."""

    match: ScanMatchConfig = ScanMatchConfig()
    """These settings say how obstacles are compared."""
    max_distance: float = Field(default=2.0, ge=0.1, le=100.0)
    """The local map starts anew after this distance, since dead reckoning drifts [m]."""
    comparison_angle: float = Field(default=1.0, ge=0.05, le=6.3)
    """Obstacles are compared with the whole map again after a turn by this angle [rad]."""
    agreement: float = Field(default=0.7, ge=0.01, le=1.0)
    """A pose by obstacles has at least this agreement with the map [1]."""
    max_rival: float = Field(default=0.75, ge=0.01, le=1.0)
    """The agreement of any other pose is at most this share of the best one's, unless images
    confirm that [1]."""
    repeats: int = Field(default=3, ge=1, le=1000)
    """A pose must be the best this often in a row for `max_repeated_rival` to hold [1]."""
    max_repeated_rival: float = Field(default=0.85, ge=0.01, le=1.0)
    """The agreement of any other pose is at most this share of that of one which was the best
    `repeats` times, since along a wall a step aside fits nearly as well [1]."""
    same_pose_distance: float = Field(default=0.3, ge=0.01, le=10.0)
    """Two poses count as the same within this distance [m, rad]."""
    min_image_agreement: float = Field(default=0.6, ge=0.01, le=1.0)
    """A pose by images is rejected where its agreement with the obstacles is below this [1]."""
    translation_sigma: float = Field(default=0.05, ge=0.001, le=2.0)
    """The position of a pose by obstacles has this standard deviation [m]."""
    rotation_sigma: float = Field(default=0.03, ge=0.001, le=1.6)
    """The angle of a pose by obstacles has this standard deviation [rad]."""


class RelocalisationConfig(Settings):
    """When a lost robot counts as relocalised."""

    candidates: int = Field(default=5, ge=1, le=1000)
    """A frame is compared with this number of keyframes, those that look most like it [1]."""
    inliers: int = Field(default=40, ge=1, le=10000)
    """At least this number of matches must agree on the pose of a lost robot [1]."""
    inlier_fraction: float = Field(default=0.5, ge=0.01, le=1.0)
    """At least this share of all matches must agree on the pose of a lost robot [1]."""
    min_shown_share: float = Field(default=0.1, ge=0.001, le=1.0)
    """Matches that agree are at least this share of the corners that both images show [1]."""
    above_floor_radius: float = Field(default=0.03, ge=0.001, le=1.0)
    """The pose must also be found by corners above the floor alone, within this radius as a
    fraction of the image's width, since boards and tiles repeat [1]."""
    single_frame_inliers: int = Field(default=120, ge=1, le=100000)
    """A single frame is believed from this number of agreeing matches on, unless it looks like
    another place as well or an earlier frame led elsewhere; with fewer, more earlier frames must
    have led to the same place than elsewhere [1]."""
    agreement: float = Field(default=0.15, ge=0.0, le=10.0)
    """An earlier frame leads to the same place where it does so within this distance [m, rad]."""
    min_turn: float = Field(default=0.35, ge=0.0, le=3.2)
    """The frame and one of those that led to the same place must differ by this turn, so that they
    show different things; there is more than one window with the same view [rad]."""
    remembered_frames: int = Field(default=50, ge=1, le=100000)
    """The places of this number of earlier frames are remembered, the newest ones, since a robot
    may stand lost for hours [1]."""
    same_place: float = Field(default=0.3, ge=0.01, le=10.0)
    """Images confirm a pose by obstacles where they find it within this distance [m, rad]."""
