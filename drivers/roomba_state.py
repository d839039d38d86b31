"""What a sensor frame of the Roomba says, as `BaseState`."""

from __future__ import annotations

from collections.abc import Mapping

from drivers.roomba_packets import BumpsAndWheelDrops, Packet
from vizbot.core.types import SE3, BaseMode, BaseState


def base_state(
    values: Mapping[Packet, int], stamp: float, T_odom_base: SE3, mode: BaseMode
) -> BaseState:
    """Name the bits of a frame (manual, packets 7, 9-12, 25 and 26).

    Args:
        values: Of the streamed packets, within their ranges.
        stamp: When the frame was read [s].
        T_odom_base: Odometry up to this frame.
        mode: Open Interface mode, the firmware's offset taken out.
    """
    contacts = BumpsAndWheelDrops(values[Packet.BUMPS_AND_WHEEL_DROPS])
    capacity = values[Packet.BATTERY_CAPACITY]
    return BaseState(
        stamp=stamp,
        T_odom_base=T_odom_base,
        bump_left=BumpsAndWheelDrops.BUMP_LEFT in contacts,
        bump_right=BumpsAndWheelDrops.BUMP_RIGHT in contacts,
        cliffs=(
            values[Packet.CLIFF_LEFT] == 1,
            values[Packet.CLIFF_FRONT_LEFT] == 1,
            values[Packet.CLIFF_FRONT_RIGHT] == 1,
            values[Packet.CLIFF_RIGHT] == 1,
        ),
        wheel_drops=(
            BumpsAndWheelDrops.WHEEL_DROP_LEFT in contacts,
            BumpsAndWheelDrops.WHEEL_DROP_RIGHT in contacts,
        ),
        battery=min(1.0, values[Packet.BATTERY_CHARGE] / capacity) if capacity else None,
        mode=mode,
    )


def why_passive(state: BaseState) -> str:
    """The likely reason for a base that has left Safe mode by itself (manual p. 8)."""
    if any(state.wheel_drops):
        return "wheel drop"
    return "cliff" if any(state.cliffs) else "its charger or one of its buttons"
