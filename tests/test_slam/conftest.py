from typing import TypeAlias

import pytest

from mapping.slam.slam import Slam
from tests.helpers.box_room import dead_reckoning, follow, lap
from vizbot.core.types import SE3, PoseEstimate

Lap: TypeAlias = tuple[Slam, list[PoseEstimate], list[SE3]]


@pytest.fixture(scope="session")
def whole_lap() -> Lap:
    Ts_map_base = lap(100)
    return *follow(Ts_map_base, dead_reckoning(Ts_map_base)), Ts_map_base
