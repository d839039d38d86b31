from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim_stubs.homes.furniture import procedural
from sim_stubs.homes.geometry.house import Instance
from sim_stubs.homes.geometry.solids import triangles

STOOL = procedural.piece("chair", np.random.default_rng(0))


@given(x=st.floats(-5, 5), y=st.floats(-5, 5), yaw=st.floats(-pi, pi))
def test_the_footprint_encloses_the_piece(x, y, yaw):
    instance = Instance("chair#1", STOOL, x, y, yaw)
    edges = np.roll(instance.footprint, -1, axis=0) - instance.footprint
    points = triangles(instance.parts())[..., :2].reshape(-1, 2)
    offsets = points[:, None] - instance.footprint
    left_of = edges[:, 0] * offsets[..., 1] - edges[:, 1] * offsets[..., 0]
    assert left_of.min() > -1e-4
    assert instance.footprint.mean(axis=0) == pytest.approx([x, y])
