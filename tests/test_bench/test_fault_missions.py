"""Missions with faults in one room, and what they count as reached."""

import numpy as np
import pytest

from sim_stubs.homes.floor_plan.walls import RectangularRoom, build_structure
from sim_stubs.homes.geometry.house import House
from sim_stubs.world.world import World
from vizbot.bench.faults import missions
from vizbot.bench.faults.missions import FaultMission
from vizbot.config import Config
from vizbot.core.observer import Outcome

GREY = (0.6, 0.6, 0.6)
CONFIG = Config.model_validate(
    {
        "objectnav": {
            "look_around": False,
            "max_steps": 3,
            "settling": {"seconds": 0.0, "frames": 0},
        }
    }
)


@pytest.fixture(autouse=True)
def kitchen(monkeypatch, mean_colours):
    """A robot that stands in the kitchen, which its encoder does not know."""
    room = RectangularRoom("kitchen", 0, 0, 5, 4, GREY, 1.0, GREY)
    lights = np.array([[2.5, 2.0, 2.3]])
    house = House((room.room,), build_structure((room,), ()), (), lights, (1.2, 2.0, 0.0))

    def opened(episode, config):
        return World(house, config.world, config.mount.T_base_cam, episode.home)

    monkeypatch.setattr(missions, "open_episode", opened)
    monkeypatch.setattr(missions, "encoder_of", lambda config: mean_colours)
    monkeypatch.setattr(missions, "UNATTENDED", CONFIG)


def test_a_robot_whose_steps_are_spent_has_not_reached_the_room_that_it_stands_in():
    became = missions.run_mission(FaultMission(1000, "kitchen", ()))
    assert not became.reached
    assert became.steps == 3
    assert became.crash == ""
    assert (became.happened, became.map_kept, became.stops) == (True, True, ())


@pytest.mark.parametrize(
    ("ended", "goal", "reached", "answer"),
    [
        ((Outcome.ARRIVED, "seen", ""), "kitchen", True, ""),
        ((Outcome.ARRIVED, "seen", ""), "bed", False, "no bed in this world"),
        ((Outcome.GAVE_UP, "not found", ""), "kitchen", False, "not found"),
        ((Outcome.EXPLORED, "nothing is left", ""), "kitchen", False, "nothing is left"),
        ((Outcome.GAVE_UP, "", "IndexError: no wheel"), "kitchen", False, ""),
    ],
)
def test_only_who_says_that_he_arrived_and_did_has_reached_the_goal(
    monkeypatch, ended, goal, reached, answer
):
    monkeypatch.setattr(missions, "run_to_end", lambda *_: ended)
    became = missions.run_mission(FaultMission(1000, goal, ()))
    assert (became.reached, became.answer, became.crash) == (reached, answer, ended[2])


def test_a_fault_that_does_not_happen_before_the_end_is_told():
    became = missions.run_mission(FaultMission(1000, "kitchen", ("bump",)))
    assert not became.happened
    assert became.stops == ()
    assert became.map_kept


def test_the_monitor_of_a_mission_knows_how_often_the_camera_gives_a_frame(monkeypatch):
    periods = []

    class Monitor(missions.FaultMonitor):
        def __init__(self, base, schedule, clock, camera_period):
            periods.append(camera_period)
            super().__init__(base, schedule, clock, camera_period)

    monkeypatch.setattr(missions, "FaultMonitor", Monitor)
    missions.run_mission(FaultMission(1000, "kitchen", ("bump",)))
    assert periods == [1.0 / CONFIG.sim_camera.rate]
