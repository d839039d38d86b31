from sim_stubs.clock import SimulatedClock
from tests.helpers.box_room import T_BASE_CAM, lap, render
from vizbot.config import PerceptionConfig
from vizbot.perception.perception import Perception


def test_frames_that_come_while_the_encoder_is_busy_are_counted(mean_colours):
    clock, config = SimulatedClock(), PerceptionConfig(embedding_latency=0.31)
    perception = None
    for i, T_map_base in enumerate(lap(100)[:8]):
        frame = render(T_map_base, 0.15 * i)
        if perception is None:
            perception = Perception(frame, T_BASE_CAM, mean_colours, clock, config)
        perception.embed(frame, perception.update(frame, None))
        clock.sleep(0.15)
    perception.finish()
    mapped = set(perception.clip_map.elements.frames.tolist())
    assert mapped == {0, 3, 6}  # each takes two frames and a bit
    assert (perception.embedded, perception.skipped) == (3, 5)
