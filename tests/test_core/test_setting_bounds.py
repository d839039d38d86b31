"""Every number of the settings has bounds and a unit, and what is outside is told with both."""

import math
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_args

import pytest
from pydantic import BaseModel, ValidationError

from vizbot.config import Config, load_config
from vizbot.core.errors import ConfigError
from vizbot.core.settings import UNITS, bounds_of, explained, unit_of
from vizbot.rehearsal.config import RehearsalConfig

LISTS = {
    "calibration.gyro_bias": 3,
    "navigator.distant_point": 2,
    "perception.clip_mapper.scales": 1,
}
SCALES = {"1", "1/s", "px", "grey levels", "1/32 px of disparity"}


def types_in(annotation: Any) -> Iterator[Any]:
    yield annotation
    for each in get_args(annotation):
        yield from types_in(each)


def numbers(model: type[BaseModel], table: str = "") -> Iterator[tuple[str, Any, Any]]:
    """Key, field and default of every setting that is a number or has some, at any depth."""
    for name, field in model.model_fields.items():
        key, types = f"{table}{name}", list(types_in(field.annotation))
        below = [t for t in types if isinstance(t, type) and issubclass(t, BaseModel)]
        for each in below:
            yield from numbers(each, f"{key}.")
        if not below and (int in types or float in types):
            yield key, field, field.default


MODELS = (Config, RehearsalConfig)
NUMBERS = {key: (field, default) for each in MODELS for key, field, default in numbers(each)}


def table_with(key: str, value: Any) -> dict:
    """The settings that say nothing but this, with what a table must have."""
    *tables, last = key.split(".")
    settings: Any = {last: value}
    needed = {"waypoint_reaches": {"distance": 0.3, "extent": 0.1}}
    needed |= {name: {"per_radian": 0.1, "per_metre": 0.1} for name in ("gyro", "wheels")}
    for name in reversed(tables):
        settings = needed.get(name, {}) | settings
        settings = {name: [settings] if name == "waypoint_reaches" else settings}
    return settings


def test_the_walk_finds_the_settings_at_every_depth():
    assert len(NUMBERS) > 290
    for key in (
        "roomba.wheel_base", "perception.slam.dead_reckoning.gyro.least",
        "realsense.filters.temporal.delta", "objectnav.waypoint_reaches.extent",
        "calibration.gyro_bias", "perception.clip_mapper.scales", "roomba.mode_offset",
    ):  # fmt: skip
        assert key in NUMBERS


@pytest.mark.parametrize("key", NUMBERS)
def test_every_number_of_the_settings_has_two_bounds_a_unit_and_a_default_between(key):
    field, default = NUMBERS[key]
    least, most = bounds_of(field)
    assert math.isfinite(least) and math.isfinite(most) and least < most
    assert unit_of(field) is not None, field.description
    for value in default if isinstance(default, tuple) else (default,):
        if isinstance(value, int | float):
            assert least <= value <= most


@pytest.mark.parametrize("key", NUMBERS)
def test_what_lies_beyond_a_bound_is_refused_in_one_line_with_the_unit(key):
    field, _ = NUMBERS[key]
    types = list(types_in(field.annotation))
    least, most = bounds_of(field)
    entries = LISTS.get(key)
    model = RehearsalConfig if key.split(".")[0] in RehearsalConfig.model_fields else Config
    for beyond in (least - 1, most + 1):
        value: Any = int(beyond) if int in types else float(beyond)
        value = value if entries is None else [value] * entries
        with pytest.raises(ValidationError) as refusal:
            model.model_validate(table_with(key, value))
        line = explained(refusal.value, model)
        assert "\n" not in line and key.rpartition(".")[2] in line
        assert unit_of(field).name in line


NO_ROBOT = {
    "roomba.wheel_base": (235, "in metres: 235 mm are 0.235"),
    "roomba.wheel_scale": (1000, "at most 1.25"),
    "roomba.deceleration": (1e-9, "metres per second squared"),
    "mount.height": (60, "in metres: 60 cm are 0.6"),
    "mount.forward": (50.0, "in metres: 50 mm are 0.05 or 50 cm are 0.5"),
    "mount.left": (-3000.0, "in metres"),
    "perception.slam.features.count": (-5, "at least 10"),
    "perception.slam.odometry.min_inliers": (-1, "at least 4"),
    "perception.slam.odometry.pixel_sigma": (0.0, "in pixels"),
    "perception.slam.keyframes.distance": (-1.0, "in metres"),
    "realsense.width": (99999, "in pixels"),
    "realsense.fps": (100000, "in times a second"),
    "realsense.exposure_limit": (10, "in seconds: 10 ms are 0.01"),
    "recovery.back_off_distance": (1000, "in metres"),
    "recovery.undocking": (1000, "in metres: 1000 mm are 1"),
    "recovery.edge_timeout": (1e9, "in seconds"),
    "recovery.min_battery": (0, "at least 0.05"),
    "navigator.costmap.robot_radius": (1e-6, "in metres"),
    "navigator.follower.max_linear": (430, "in metres per second: 430 mm/s are 0.43"),
    "navigator.follower.max_angular": (75, "in radians per second: 75 degrees/s are 1.309"),
    "navigator.facing_tolerance": (8.6, "in radians: 8.6 degrees are 0.1501"),
    "objectnav.search.late_after_steps": (0, "at least 1"),
}


@pytest.mark.parametrize("key", NO_ROBOT)
def test_what_no_robot_of_this_kind_has_is_refused_with_what_may_have_been_meant(key, tmp_path):
    value, told = NO_ROBOT[key]
    table, _, name = key.rpartition(".")
    (tmp_path / "robot.toml").write_text(f"[{table}]\n{name} = {value}\n")
    with pytest.raises(ConfigError) as refusal:
        load_config(tmp_path / "robot.toml")
    line = str(refusal.value)
    assert f"{key} = {value}: " in line and told in line and "\n" not in line
    assert "max_height" not in line


@pytest.mark.parametrize(
    ("key", "factor"),
    [("roomba.wheel_base", 0.5), ("roomba.wheel_base", 2.0), ("roomba.wheel_scale", 2.0),
     ("roomba.deceleration", 0.04), ("navigator.costmap.robot_radius", 0.5),
     ("recovery.min_battery", 0.4), ("recovery.back_off_distance", 4.0)],
)  # fmt: skip
def test_what_wheels_and_stops_rest_on_leaves_little_room(key, factor, tmp_path):
    value: object = Config()
    for name in key.split("."):
        value = getattr(value, name)
    table, _, name = key.rpartition(".")
    (tmp_path / "robot.toml").write_text(f"[{table}]\n{name} = {value * factor}\n")
    with pytest.raises(ConfigError, match=rf"{key} = .*: it must be at (least|most)"):
        load_config(tmp_path / "robot.toml")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (
            "[navigator.costmap]\nrobot_radius = 0.1\nmap_tolerance = 0.2",
            "leaves nothing of robot_radius",
        ),
        ("[recovery]\nundocking = 1.0\nback_off_speed = 0.1", "takes 10.0 s, and 7.2 s are"),
        ("[recovery]\nmin_battery = 10\n", r"at most 0\.9: 10 % are 0\.1 "),
    ],
)
def test_what_does_not_fit_together_and_percent_instead_of_a_share_are_refused(
    tmp_path, text, told
):
    (tmp_path / "robot.toml").write_text(text)
    with pytest.raises(ConfigError, match=told):
        load_config(tmp_path / "robot.toml")


def test_what_people_measure_on_robots_of_this_kind_is_accepted():
    for text in (
        "[roomba]\nwheel_base = 0.258\nwheel_scale = 0.97\nmax_turn_rate = 1.0",
        "[mount]\nheight = 1.2\nforward = -0.1\n[perception.depth_mapper.scan]\nmax_height = 1.3",
        "[navigator.costmap]\nrobot_radius = 0.17\n[recovery]\nmin_battery = 0.05",
        "[realsense]\nwidth = 1280\nheight = 720\nfps = 15\n[realsense.filters]\nfarthest = 4.0",
        "[recovery]\nback_off_distance = 0.2\nundocking = 0.8\nedge_timeout = 30",
        "[navigator.follower]\nmax_linear = 0.2\nmax_angular = 0.6",
    ):
        Config.model_validate(tomllib.loads(text))


def test_the_page_of_settings_names_a_unit_and_both_bounds_of_every_number():
    page = Path("docs/settings.md").read_text(encoding="utf-8")
    rows = [line.split(" | ") for line in page.splitlines() if line.startswith("| `")]
    numeric = [row for row in rows if "> " in row[3] or ">= " in row[3]]
    assert len(numeric) > 280
    for row in numeric:
        assert row[2] in UNITS and ("<= " in row[3] or "< " in row[3]), row


def test_units_that_are_mistaken_are_of_the_same_kind():
    for symbol, unit in UNITS.items():
        assert unit.name or symbol == "1"
        assert all(0.0 < factor < 1.0 for factor in unit.mistaken.values())
        assert not (symbol in SCALES - {"1"} and unit.mistaken)
