"""The state of the base as JSON of the API, both ways."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from vizbot.core.types import BaseMode, BaseState, Charging


def base_report(state: BaseState) -> dict[str, object]:
    """The state of the base, ready for JSON."""
    return {
        "mode": state.mode.name.lower(),
        "battery": None if state.battery is None else round(state.battery, 3),
        "charging": str(state.charging),
        "docked": state.docked,
        "plugged_in": state.plugged_in,
        "bumps": [state.bump_left, state.bump_right],
        "cliffs": list(state.cliffs),
        "wheel_drops": list(state.wheel_drops),
        "overcurrents": list(state.overcurrents),
        "virtual_wall": state.virtual_wall,
        "maybe_moved": state.maybe_moved,
    }


def base_state_of(report: Mapping[str, Any], stamp: float) -> BaseState:
    """The state of the base from its JSON, which has no odometry: that stays at the origin.

    Raises:
        KeyError: a field is missing.
    """
    left, front_left, front_right, right = (bool(missing) for missing in report["cliffs"])
    return BaseState(
        stamp=stamp,
        T_odom_base=np.eye(4),
        bump_left=bool(report["bumps"][0]),
        bump_right=bool(report["bumps"][1]),
        cliffs=(left, front_left, front_right, right),
        wheel_drops=(bool(report["wheel_drops"][0]), bool(report["wheel_drops"][1])),
        battery=report["battery"],
        mode=BaseMode[str(report["mode"]).upper()],
        virtual_wall=bool(report["virtual_wall"]),
        overcurrents=(bool(report["overcurrents"][0]), bool(report["overcurrents"][1])),
        charging=Charging(report["charging"]),
        docked=bool(report["docked"]),
        plugged_in=bool(report["plugged_in"]),
        maybe_moved=bool(report.get("maybe_moved", False)),
    )
