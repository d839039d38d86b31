"""Examination of a base without moving it, for `vizbot doctor`."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from drivers.roomba.commands import Opcode, encode
from drivers.roomba.control import WAKE_UP
from drivers.roomba.drive_command import SURE_STOP
from drivers.roomba.packets import Packet
from drivers.roomba.serial_port import SerialPort
from drivers.roomba.state import STREAMED, base_state
from drivers.roomba.stream import PERIOD, OddValues, StreamParser, encoded_size
from vizbot.core.interfaces import Clock
from vizbot.core.types import BaseMode, BaseState

_SETTLING = 0.2
"""Time after waking the base whose bytes are not counted [s]."""
_BOOT = 6.0
"""Time after a reset within which the base names its firmware [s]."""
_FIRMWARE = re.compile(rb"(?:release|stm32)-[\w.-]*\w")


@dataclass(frozen=True, slots=True, eq=False)
class BaseExamination:
    """Findings about a base.

    Attributes:
        rate: Sound sensor frames a second; 67 are sent.
        spoilt: Share of the received bytes that belong to no sound frame; 0 without any bytes.
        state: The last frame, in Passive mode; None when none came.
        mode_offset: Offset of the mode that the firmware reports.
        firmware: Version that the base names after a reset; None without a reset or an answer.
    """

    rate: float
    spoilt: float
    state: BaseState | None
    mode_offset: int
    firmware: str | None


def examine_base(port: SerialPort, clock: Clock, seconds: float = 2.0) -> BaseExamination:
    """Wake the base up, listen to its stream, and reset it unless it is charging.

    It is left in Passive or Off mode, in which it charges.

    The open port stays the caller's to close.

    Raises:
        OSError: the port is gone.
    """
    port.write(SURE_STOP + WAKE_UP)
    clock.sleep(_SETTLING)
    port.read(port.in_waiting)
    parser, odd_values, received = StreamParser(STREAMED), OddValues(port.name or "the base"), 0
    frames: list[Mapping[Packet, int]] = []
    end = clock.now() + seconds
    while clock.now() < end:
        clock.sleep(PERIOD)
        heard = port.read(port.in_waiting)
        received += len(heard)
        for values in parser.feed(heard):
            # Its mode may be one too high.
            sound = odd_values.corrected(dict(values) | {Packet.OI_MODE: 0})
            if sound is not None:
                frames.append({**sound, Packet.OI_MODE: values[Packet.OI_MODE]})
    state, offset = None, 0
    if frames:
        newest = frames[-1]
        offset = 1 if newest[Packet.OI_MODE] == BaseMode.PASSIVE + 1 else 0
        mode = BaseMode(min(max(newest[Packet.OI_MODE] - offset, 0), 3))
        state = base_state(newest, clock.now(), np.eye(4), mode)
    whole = len(frames) * encoded_size(STREAMED)
    spoilt = 1.0 - min(whole / received, 1.0) if received else 0.0
    firmware = None if state is None or state.on_charger else _reset(port, clock)
    port.write(encode(Opcode.START))
    return BaseExamination(len(frames) / seconds, spoilt, state, offset, firmware)


def _reset(port: SerialPort, clock: Clock) -> str | None:
    port.write(encode(Opcode.RESET))
    reply, end = b"", clock.now() + _BOOT
    while clock.now() < end:
        clock.sleep(PERIOD)
        reply += port.read(port.in_waiting)
        found = _FIRMWARE.search(reply)
        if found is not None and reply.endswith(b"\n"):
            return found[0].decode()
    return None
