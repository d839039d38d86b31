"""The other end of the line of a simulated Roomba."""

from drivers.roomba.serial_port import open_serial
from sim_stubs.roomba.base import SimulatedRoomba
from sim_stubs.world.body import Contacts


class PlacedBody:
    """A body that only moves when a test moves it."""

    def __init__(self):
        self.speeds = (0.0, 0.0)
        self.wheel_travel = (0.0, 0.0)
        self.contacts = Contacts()

    def set_wheel_speeds(self, left, right):
        self.speeds = (left, right)

    def advance(self, seconds):
        pass

    def roll_mm(self, left, right):
        self.wheel_travel = (
            self.wheel_travel[0] + left / 1000,
            self.wheel_travel[1] + right / 1000,
        )


class Host:
    """The other end of the line."""

    def __init__(self, encoder_counts=(0, 0)):
        self.body = PlacedBody()
        self.roomba = SimulatedRoomba(self.body, encoder_counts)
        self.port = self.roomba.lockstep_port(open_serial(self.roomba.path))

    def send(self, *sent):
        """Send bytes, let the base act on them, and return what it replies."""
        self.port.write(bytes(sent))
        self.roomba.advance(0.015)
        return list(self.port.read(self.port.in_waiting))

    def frame(self):
        self.roomba.publish()
        return list(self.port.read(self.port.in_waiting))

    def wheels_mm_s(self):
        return tuple(round(1000 * speed) for speed in self.body.speeds)


R17 = [
    2,
    0,
    0,
    0,
    1,
    0,
    0,
    8,
    17,
    0,
    161,
    4,
    255,
    221,
    0,
    12,
    0,
    59,
    217,
    251,
    93,
    31,
    6,
    114,
    10,
    136,
    0,
    5,
    4,
    176,
    5,
    131,
    0,
    38,
    5,
    22,
    0,
    0,
    0,
    0,
    2,
    1,
    0,
    0,
    255,
    56,
    1,
    244,
    0,
    250,
    0,
    150,
    128,
    8,
    4,
    210,
    50,
    0,
    33,
    1,
    146,
    0,
    19,
    0,
    0,
    3,
    9,
    7,
    255,
    164,
    168,
    0,
    215,
    255,
    58,
    0,
    0,
    0,
    64,
    1,
]
R17_SENSED = {
    14: 8, 15: 17, 17: 161, 22: 15321, 23: -1187, 24: 31, 25: 1650, 26: 2696, 27: 5,
    28: 1200, 29: 1411, 30: 38, 31: 1302, 45: 50, 46: 33, 47: 402, 48: 19, 50: 777,
    51: 2047, 52: 164, 53: 168, 54: 215, 55: -198, 57: 64, 58: 1,
}  # fmt: skip
R17_LIVED = {
    7: 2, 11: 1, 18: 4, 19: -35, 20: 12, 35: 2, 36: 1, 38: 0, 39: -200, 40: 500, 41: 250, 42: 150,
    43: -32760, 44: 1234,
}  # fmt: skip
CLIFF = Contacts(cliffs=(False, True, False, False))
