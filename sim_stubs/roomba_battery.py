"""Battery of the simulated Roomba: it only ever drains, slowly."""

from __future__ import annotations

from drivers.roomba_packets import Packet

_CAPACITY_MAH = 2696.0
_EMPTY_MV = 13200
_FULL_MV = 16400
_IDLE_MA = 250
_WHEEL_MA = 300


class Battery:
    """Charge, and what draws on it; figures of a well-kept pack of the 600 series."""

    def __init__(self) -> None:
        self._charge_mah = _CAPACITY_MAH
        self._wheel_ma = 0

    def advance(self, seconds: float, wheels_turn: bool) -> None:
        """Draw on the charge for `seconds`."""
        self._wheel_ma = _WHEEL_MA if wheels_turn else 0
        drawn = (_IDLE_MA + 2 * self._wheel_ma) * seconds / 3600
        self._charge_mah = max(0.0, self._charge_mah - drawn)

    def packets(self) -> dict[Packet, int]:
        """Packets 22 to 26, 54 and 55 as they stand."""
        fraction = self._charge_mah / _CAPACITY_MAH
        return {
            Packet.VOLTAGE: round(_EMPTY_MV + fraction * (_FULL_MV - _EMPTY_MV)),
            Packet.CURRENT: -(_IDLE_MA + 2 * self._wheel_ma),
            Packet.TEMPERATURE: 25,
            Packet.BATTERY_CHARGE: round(self._charge_mah),
            Packet.BATTERY_CAPACITY: round(_CAPACITY_MAH),
            Packet.LEFT_MOTOR_CURRENT: self._wheel_ma,
            Packet.RIGHT_MOTOR_CURRENT: self._wheel_ma,
        }
