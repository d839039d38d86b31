import numpy as np
import pytest

from sim_stubs.homes.floor_plan.walls import RectangularRoom, build_structure
from sim_stubs.homes.furniture import procedural
from sim_stubs.homes.geometry.house import House, Instance


@pytest.fixture
def kitchen():
    """A house of one room, a kitchen with a sofa."""
    room = RectangularRoom("kitchen", 0, 0, 4, 3, (0.5, 0.4, 0.3), 1.0, (0.6, 0.6, 0.6))
    sofa = Instance(
        "sofa#1", procedural.piece("sofa", np.random.default_rng(0)), 2.9, 1.5, -np.pi / 2
    )
    lights = np.array([[2.0, 1.5, 2.3]])
    return House((room.room,), build_structure((room,), ()), (sofa,), lights, (0.9, 1.5, 0.0))
