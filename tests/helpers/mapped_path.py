from tests.helpers.box_room import T_BASE_CAM, dead_reckoning, render
from vizbot.config import PerceptionConfig
from vizbot.core.simulated_clock import SimulatedClock
from vizbot.perception.perception import Perception

AT_ONCE = PerceptionConfig(embedding_latency=0.0)


def mapped(encoder, path, watch=lambda perception: None) -> Perception:
    """Work frames from a path through the box room into a new map."""
    wheels, perception = dead_reckoning(path), None
    for i, T_map_base in enumerate(path):
        frame = render(T_map_base, 0.2 * i)
        if perception is None:
            perception = Perception(frame, T_BASE_CAM, encoder, SimulatedClock(), AT_ONCE)
        perception.embed(frame, perception.update(frame, wheels[i]))
        watch(perception)
    perception.finish()
    return perception
