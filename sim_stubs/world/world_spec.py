"""What `--world` and `--start` say, checked before anything of a world is made or read."""

from __future__ import annotations

from math import isfinite, nan, radians
from pathlib import Path

from sim_stubs.homes.sweet_home.plan import is_home
from vizbot.core.errors import ConfigError

MJCF = (".xml", ".mjcf")
"""Endings of MuJoCo's files."""
SDF = (".world", ".sdf")
"""Endings of Gazebo's."""
OFFICE = "office"
"""The world with this name is the office."""
_FARTHEST, _TURNED = 1000.0, 3600.0
"""Farthest coordinate [m] and largest angle [degrees] of a start."""
BARE = "+bare"
"""After a seed: its home without pictures, with white doors and a mirror."""
_MOST_DIGITS = 18
"""Of a seed."""


def seed_of(spec: str) -> int | None:
    """The seed that names a home, bare or not; None where a world is named otherwise.

    Raises:
        ConfigError: the seed has too many digits, or there is no such modifier.
    """
    seed, plus, modifier = spec.partition("+")
    if not (seed.isascii() and seed.isdigit()):
        return None
    if len(seed) > _MOST_DIGITS:
        raise ConfigError(f"world {seed[:9]}...: a seed has {_MOST_DIGITS} digits at most")
    if plus + modifier not in ("", BARE):
        raise ConfigError(
            f"world {spec!r}: {plus + modifier!r} changes no home; give {seed}, or {seed}{BARE} for"
            " bare walls"
        )
    return int(seed)


def is_bare(spec: str) -> bool:
    """Whether a world is the home of a seed with bare walls.

    Raises:
        ConfigError: as `seed_of` raises it.
    """
    return seed_of(spec) is not None and spec.endswith(BARE)


def require_world(spec: str, labels: Path | None = None) -> None:
    """Refuse a world that cannot be one, and labels for one that has its own.

    Args:
        spec: A seed, alone or with `BARE`; `office`; or a file.
        labels: TOML file with labels of what is in an MJCF or SDF file.

    Raises:
        ConfigError: there is no such world, or the labels are not for it.
    """
    path = Path(spec)
    if labels is not None and path.suffix not in (*MJCF, *SDF):
        raise ConfigError(f"labels {labels} are for an MJCF or SDF file, not for world {spec!r}")
    if spec == OFFICE or seed_of(spec) is not None:
        return
    if spec.endswith(BARE) and not path.exists():
        raise ConfigError(f"world {spec!r}: {BARE} is for the home of a seed, as in 1100{BARE}")
    if path.suffix not in (*MJCF, *SDF) and not is_home(path):
        raise ConfigError(f"unknown world {spec!r}; give a seed, or an MJCF, SDF or .sh3d file")
    file = path.parent if path.parent.suffix == ".jar" else path
    if not file.is_file():
        raise ConfigError(f"world {file} is not there; give an MJCF, SDF or .sh3d file")


def parse_start(text: str) -> tuple[float, float, float]:
    """A start x, y [m], yaw [rad] from "X,Y,YAW_DEGREES".

    Raises:
        ConfigError: these are no three finite numbers, or none of a home.
    """
    try:
        x, y, degrees = (float(number) for number in text.split(","))
    except ValueError:
        x = y = degrees = nan
    if not isfinite(x + y + degrees):
        raise ConfigError(
            f"--start {text!r} is no place; give X,Y,YAW_DEGREES, for example 1.5,-2,90"
        )
    if max(abs(x), abs(y)) > _FARTHEST or abs(degrees) > _TURNED:
        raise ConfigError(
            f"--start {text!r} is in no home; give X,Y in metres, at most {_FARTHEST:g} either"
            f" way, and the yaw in degrees, at most {_TURNED:g}"
        )
    return x, y, radians(degrees)
