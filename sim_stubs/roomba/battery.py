"""Battery of the simulated Roomba: it drains, and charges on a dock."""

from __future__ import annotations

from drivers.roomba.packets import ChargingState, Packet

_CAPACITY_MAH = 2696.0
_EMPTY_MV = 13200
_FULL_MV = 16400
_IDLE_MA = 250
_WHEEL_MA = 300
_CHARGE_MA = 1250


class Battery:
    """The battery, with the figures of a well-kept pack of the 600 series."""

    def __init__(self, charge: float = 1.0) -> None:
        """Start with a `charge` of 0 to 1."""
        self._charge_mah = charge * _CAPACITY_MAH
        self._wheel_ma = 0
        self._state = ChargingState.NOT_CHARGING

    @property
    def empty(self) -> bool:
        """Whether the battery is empty."""
        return self._charge_mah <= 0.0

    def advance(self, seconds: float, wheels_turn: bool, on_charger: bool) -> None:
        """Discharge or charge for `seconds`."""
        self._wheel_ma = _WHEEL_MA if wheels_turn else 0
        full = self._charge_mah >= _CAPACITY_MAH
        self._state = ChargingState.NOT_CHARGING
        if on_charger:
            self._state = ChargingState.WAITING if full else ChargingState.FULL_CHARGING
        charge = self._charge_mah + self._current_ma * seconds / 3600
        self._charge_mah = min(max(0.0, charge), _CAPACITY_MAH)

    def packets(self) -> dict[Packet, int]:
        """Packets 21 to 26, 54 and 55 as they stand."""
        fraction = self._charge_mah / _CAPACITY_MAH
        return {
            Packet.CHARGING_STATE: self._state,
            Packet.VOLTAGE: round(_EMPTY_MV + fraction * (_FULL_MV - _EMPTY_MV)),
            Packet.CURRENT: self._current_ma,
            Packet.TEMPERATURE: 25,
            Packet.BATTERY_CHARGE: round(self._charge_mah),
            Packet.BATTERY_CAPACITY: round(_CAPACITY_MAH),
            Packet.LEFT_MOTOR_CURRENT: self._wheel_ma,
            Packet.RIGHT_MOTOR_CURRENT: self._wheel_ma,
        }

    @property
    def _current_ma(self) -> int:
        """Current into the battery [mA]."""
        if self._state is ChargingState.FULL_CHARGING:
            return _CHARGE_MA
        if self._state is ChargingState.WAITING:
            return 0
        return -(_IDLE_MA + 2 * self._wheel_ma)
