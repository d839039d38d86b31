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

    def close(self):
        self.port.close()
        self.roomba.close()

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


_R17 = """
02 00 00 00 01 00 00 08 11 00 a1 04 ff dd 00 0c 00 3b d9 fb
5d 1f 06 72 0a 88 00 05 04 b0 05 83 00 26 05 16 00 00 00 00
02 01 00 00 ff 38 01 f4 00 fa 00 96 80 08 04 d2 32 00 21 01
92 00 13 00 00 03 09 07 ff a4 a8 00 d7 ff 3a 00 00 00 40 01
"""
R17 = [*bytes.fromhex(_R17)]
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
