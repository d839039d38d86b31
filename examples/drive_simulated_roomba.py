"""Drive the simulated Roomba with pycreate2, a client that other people wrote.

The simulated base answers on a serial port that it prints first:

    pip install pycreate2
    vizbot stub roomba
    python examples/drive_simulated_roomba.py /dev/pts/3
"""

import argparse
import time

from pycreate2 import Create2

SPEED = 150
"""Of each wheel [mm/s]."""


def turned(began: int, ended: int) -> int:
    """Counts from one reading of an encoder, of 16 bits, to the next."""
    return (ended - began + 2**15) % 2**16 - 2**15


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("port", help="as `vizbot stub roomba` prints it")
    parser.add_argument("--seconds", type=float, default=2.0, help="how long to turn")
    arguments = parser.parse_args()

    robot = Create2(arguments.port)
    robot.start()
    robot.safe()
    began = robot.get_sensors()
    robot.drive_direct(SPEED, -SPEED)  # right wheel, left wheel: a turn to the left
    time.sleep(arguments.seconds)
    robot.drive_stop()
    ended = robot.get_sensors()

    print(f"mode {ended.open_interface_mode}, battery {ended.battery_charge} mAh")
    right = turned(began.encoder_counts_right, ended.encoder_counts_right)
    left = turned(began.encoder_counts_left, ended.encoder_counts_left)
    print(f"right wheel: {right:+d} counts")
    print(f"left wheel: {left:+d} counts")


if __name__ == "__main__":
    main()
