"""A house of one room, in which episodes are short, and a search that begins at once."""

import numpy as np

from benchmarks.episodes.episode import Variant
from sim_stubs.homes.floor_plan.walls import RectangularRoom, build_structure
from sim_stubs.homes.furniture import procedural
from sim_stubs.homes.geometry.house import House, Instance
from vizbot.config import Config


def kitchen_with_sofa(length, width, sofa_x, start):
    """A kitchen whose sofa faces west, midway between the walls at its sides [m]."""
    room = RectangularRoom("kitchen", 0, 0, length, width, (0.5, 0.4, 0.3), 1.0, (0.6, 0.6, 0.6))
    sofa = procedural.piece("sofa", np.random.default_rng(0))
    at = Instance("sofa#1", sofa, sofa_x, width / 2, -np.pi / 2)
    lights = np.array([[length / 2, width / 2, 2.3]])
    return House((room.room,), build_structure((room,), ()), (at,), lights, start)


def kitchen_with_far_sofa():
    """The sofa is 2.3 m ahead of the robot."""
    return kitchen_with_sofa(5, 4, 4.0, (1.2, 2.0, 0.0))


def true_encoder(max_steps):
    """A search that begins at once, with the truth about what is seen."""
    settling = {"seconds": 0.0, "frames": 0}
    settings = {"look_around": False, "gyro_settling": settling, "max_steps": max_steps}
    return Variant("true encoder", Config.model_validate({"objectnav": settings}), "encoder")
