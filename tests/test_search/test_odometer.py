"""How long the search takes, and how far it drives."""

import numpy as np

from vizbot.core.geometry import planar
from vizbot.core.observer import Effort
from vizbot.goal_reports import Odometer
from vizbot.objectnav.tasks import Goal

SOFA, TV = (Goal(text, np.ones(4, np.float32), 0.5) for text in ("sofa", "tv"))


def test_time_and_way_are_those_since_the_goal_began_whatever_moved_the_robot():
    odometer = Odometer()
    assert odometer.effort(SOFA) is None
    for now, goal, x in ((1.0, TV, 0.0), (2.0, SOFA, 0.5), (3.0, None, 1.5), (5.0, SOFA, 1.0)):
        odometer.observe(goal, planar(x, 0.0, 0.0), now)
    assert odometer.effort(SOFA) == Effort(3.0, 1.5)
    assert odometer.effort(TV) is None
    odometer.observe(TV, planar(4.0, 0.0, 0.0), 6.0)
    assert odometer.effort(TV) == Effort(0.0, 0.0)
