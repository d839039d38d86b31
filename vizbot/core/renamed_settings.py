"""Former names of settings, which are read for one release."""

from __future__ import annotations

from collections.abc import Mapping

from vizbot.core.errors import ConfigError

RENAMED = {
    "docking": {"before": "search_distance", "patience": "contact_timeout"},
    "frontier": {
        "gain_worth": "path_per_gain", "good_view": "min_gain_share",
        "keep_worth": "frontier_change_saving", "most_gain": "max_gain",
    },
    "navigator.costmap": {"slack": "map_tolerance"},
    "navigator.follower": {"hold": "twist_duration"},
    "objectnav": {"found": "answer_probability", "settling": "gyro_settling"},
    "objectnav.search": {
        "candidate": "candidate_probability", "findings": "finding_density",
        "last": "arrival_probability_last", "patience": "late_after_steps",
        "settled": "arrival_probability_late", "sure": "arrival_probability_early",
        "worth": "min_probability_per_metre",
    },
    "perception": {"surroundings": "local_map"},
    "perception.clip_mapper": {"least_depth": "min_depth_share"},
    "perception.local_map": {
        "contradiction": "min_image_agreement", "reach": "max_distance",
        "repeated_rival": "max_repeated_rival", "rival": "max_rival", "same": "same_pose_distance",
        "turn": "comparison_angle",
    },
    "perception.local_map.match": {
        "apart": "different_distance", "in_free": "free_space_penalty", "least": "min_cells",
        "on_obstacle": "missed_obstacle_penalty", "turned": "different_angle",
    },
    "perception.slam": {
        "closure_search": "closure_search_radius", "places": "place_index",
        "search": "search_radius", "solid": "depth_consistency",
        "wide_search": "wide_search_radius",
    },
    "perception.slam.dead_reckoning": {"vote": "gyro_vote", "watch": "gyro_faults"},
    "perception.slam.dead_reckoning.gyro_faults": {
        "carried": "carried_rate", "span": "averaging_time", "spans": "averages",
    },
    "perception.slam.dead_reckoning.gyro_vote": {
        "share": "max_wheel_share", "span": "turning_time",
    },
    "perception.slam.depth_consistency": {"corners": "min_corners", "share": "min_share"},
    "perception.slam.gates": {"spin": "wheel_only_error"},
    "perception.slam.kidnapping": {
        "broken": "break_corners", "corners": "plenty_corners", "patience": "lost_frames",
        "patience_in_place": "lost_frames_in_place",
    },
    "perception.slam.odometry": {"least_error": "min_error", "unmodelled": "covariance_factor"},
    "perception.slam.relocalisation": {
        "above_floor": "above_floor_radius", "alone": "single_frame_inliers", "aside": "min_turn",
        "beside": "same_place", "guesses": "remembered_frames", "shown": "min_shown_share",
    },
    "recovery": {
        "battery_floor": "min_battery", "blind_patience": "depth_timeout",
        "edge_patience": "edge_timeout", "lift_patience": "lift_timeout",
        "passive_patience": "safe_mode_timeout",
    },
}  # fmt: skip
"""Today's names of settings and tables by their former ones, for each table by today's name."""


def with_names_of_today(
    settings: Mapping[str, object], table: str = ""
) -> tuple[dict[str, object], list[str]]:
    """Settings of a file, and which of them have another name today, as `FORMER is NOW`.

    Raises:
        ConfigError: a setting has its former name and the one of today.
    """
    found, renamed = dict[str, object](), list[str]()
    names = RENAMED.get(table, {})
    for former, value in settings.items():
        name = names.get(former, former)
        path, today = (".".join(filter(None, (table, each))) for each in (former, name))
        if name != former:
            renamed.append(f"{path} is {today}")
            if name in settings:
                raise ConfigError(f"{path} is {today} today, and both are set: remove {path}")
        if isinstance(value, Mapping) and any(each.startswith(today) for each in RENAMED):
            value, below = with_names_of_today(value, today)
            renamed += below
        found[name] = value
    return found, renamed
