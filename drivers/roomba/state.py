"""Sensor frames of the Roomba as `BaseState`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from drivers.roomba.packets import (
    BumpsAndWheelDrops,
    Buttons,
    ChargingSources,
    ChargingState,
    LightBumper,
    Overcurrents,
    Packet,
    Stasis,
)
from vizbot.core.types import SE3, BaseMode, BaseState, Button, Charging

STREAMED = (
    Packet.BUMPS_AND_WHEEL_DROPS,
    Packet.CLIFF_LEFT,
    Packet.CLIFF_FRONT_LEFT,
    Packet.CLIFF_FRONT_RIGHT,
    Packet.CLIFF_RIGHT,
    Packet.VIRTUAL_WALL,
    Packet.OVERCURRENTS,
    Packet.IR_OMNI,
    Packet.BUTTONS,
    Packet.CHARGING_STATE,
    Packet.VOLTAGE,
    Packet.CURRENT,
    Packet.BATTERY_CHARGE,
    Packet.BATTERY_CAPACITY,
    Packet.CHARGING_SOURCES,
    Packet.OI_MODE,
    Packet.SONG_PLAYING,
    Packet.REQUESTED_RIGHT_VELOCITY,
    Packet.REQUESTED_LEFT_VELOCITY,
    Packet.LEFT_ENCODER,
    Packet.RIGHT_ENCODER,
    Packet.LIGHT_BUMPER,
    Packet.IR_LEFT,
    Packet.IR_RIGHT,
    Packet.STASIS,
)
"""Packets of every frame: 61 of the 172 bytes that the line carries in a period.

Redundant packets are left out: the wall (packet 8) is the right light bumper, and the signal
strengths of walls, cliffs and light bumpers would double the delay of every frame.
"""

# The bits as bare numbers: what flags give is a flag again, which takes ten times as long.
_BUMP_RIGHT, _BUMP_LEFT, _DROP_RIGHT, _DROP_LEFT = (int(bit) for bit in BumpsAndWheelDrops)
_RIGHT_STUCK, _LEFT_STUCK = int(Overcurrents.RIGHT_WHEEL), int(Overcurrents.LEFT_WHEEL)
_PLUGGED_IN, _DOCKED = int(ChargingSources.INTERNAL_CHARGER), int(ChargingSources.HOME_BASE)
_TOGGLING, _DISABLED = int(Stasis.TOGGLING), int(Stasis.DISABLED)
_LIGHT_BUMPERS = tuple(int(bumper) for bumper in LightBumper)
_BUTTONS = tuple((int(button), button.name or "") for button in Buttons)
_CHARGING = {int(state): Charging[state.name] for state in ChargingState}


def base_state(
    values: Mapping[Packet, int], stamp: float, T_odom_base: SE3, mode: BaseMode
) -> BaseState:
    """Decode the bits of a frame.

    `values` are within their ranges; the firmware's offset is taken out of `mode`.
    """
    contacts = values[Packet.BUMPS_AND_WHEEL_DROPS]
    overcurrents, power = values[Packet.OVERCURRENTS], values[Packet.CHARGING_SOURCES]
    capacity, near = values[Packet.BATTERY_CAPACITY], values[Packet.LIGHT_BUMPER]
    left, front_left, centre_left, centre_right, front_right, right = (
        bool(near & bumper) for bumper in _LIGHT_BUMPERS
    )
    stasis, pressed = values[Packet.STASIS], values[Packet.BUTTONS]
    return BaseState(
        stamp=stamp,
        T_odom_base=T_odom_base,
        bump_left=bool(contacts & _BUMP_LEFT),
        bump_right=bool(contacts & _BUMP_RIGHT),
        cliffs=(
            values[Packet.CLIFF_LEFT] == 1,
            values[Packet.CLIFF_FRONT_LEFT] == 1,
            values[Packet.CLIFF_FRONT_RIGHT] == 1,
            values[Packet.CLIFF_RIGHT] == 1,
        ),
        wheel_drops=(bool(contacts & _DROP_LEFT), bool(contacts & _DROP_RIGHT)),
        battery=min(1.0, values[Packet.BATTERY_CHARGE] / capacity) if capacity else None,
        mode=mode,
        virtual_wall=values[Packet.VIRTUAL_WALL] == 1,
        overcurrents=(bool(overcurrents & _LEFT_STUCK), bool(overcurrents & _RIGHT_STUCK)),
        light_bumpers=(left, front_left, centre_left, centre_right, front_right, right),
        rolls=None if stasis & _DISABLED else bool(stasis & _TOGGLING),
        buttons=frozenset(Button[name] for bit, name in _BUTTONS if bit & pressed),
        charging=_CHARGING[values[Packet.CHARGING_STATE]],
        docked=bool(power & _DOCKED),
        plugged_in=bool(power & _PLUGGED_IN),
        infrared=(values[Packet.IR_OMNI], values[Packet.IR_LEFT], values[Packet.IR_RIGHT]),
        voltage=values[Packet.VOLTAGE] / 1000,
        current=values[Packet.CURRENT] / 1000,
        song_playing=values[Packet.SONG_PLAYING] == 1,
    )


def why_passive(state: BaseState) -> str:
    """The likely reason why a base has left Safe mode by itself (manual, page 8)."""
    if any(state.wheel_drops):
        return "wheel drop"
    if any(state.cliffs):
        return "cliff"
    return "its charger" if state.on_charger else "its charger or one of its buttons"


def with_contacts(state: BaseState, before: BaseState) -> BaseState:
    """The newer state with every contact of the older one, since some last for one frame only."""
    if not (before.blocked or any(before.cliffs) or any(before.wheel_drops) or before.buttons):
        return state
    left, front_left, front_right, right = (
        any(seen) for seen in zip(state.cliffs, before.cliffs, strict=True)
    )
    drop_left, drop_right = (
        any(seen) for seen in zip(state.wheel_drops, before.wheel_drops, strict=True)
    )
    stuck_left, stuck_right = (
        any(seen) for seen in zip(state.overcurrents, before.overcurrents, strict=True)
    )
    return replace(
        state,
        bump_left=state.bump_left or before.bump_left,
        bump_right=state.bump_right or before.bump_right,
        cliffs=(left, front_left, front_right, right),
        wheel_drops=(drop_left, drop_right),
        virtual_wall=state.virtual_wall or before.virtual_wall,
        overcurrents=(stuck_left, stuck_right),
        buttons=state.buttons | before.buttons,
    )
