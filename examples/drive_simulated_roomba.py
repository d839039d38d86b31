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
    print(f"right wheel: {ended.encoder_counts_right - began.encoder_counts_right:+d} counts")
    print(f"left wheel:  {ended.encoder_counts_left - began.encoder_counts_left:+d} counts")


if __name__ == "__main__":
    main()
