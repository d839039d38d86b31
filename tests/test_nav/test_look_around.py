import numpy as np
import pytest

from vizbot.core.geometry import planar
from vizbot.objectnav.looks import LookAround


@pytest.mark.parametrize("start", [0.0, 3.0, -2.0])
def test_it_turns_once_wherever_it_begins(start):
    look, yaw, turned = LookAround(0.9), start, 0.0
    while (twist := look.twist(planar(1.0, 2.0, yaw))) is not None:
        assert twist.linear == 0.0
        yaw, turned = yaw + 0.2 * twist.angular, turned + 0.2 * twist.angular
    assert turned == pytest.approx(2 * np.pi, abs=0.2)
    assert look.twist(planar(1.0, 2.0, yaw)) is None


def test_a_robot_that_is_held_fast_has_not_looked_around():
    look = LookAround(0.9)
    for _ in range(100):
        assert look.twist(planar(0.0, 0.0, 0.0)) is not None
