import signal
from functools import partial

import numpy as np
import pytest

from mapping import map_bundle
from mapping.clip.growing_rows import GrowingRows
from mapping.clip.mapper import ClipMap
from mapping.clip.places.belief import Belief
from mapping.clip.places.evidence import fitted_weights
from mapping.clip.places.footprint import PLACE
from mapping.clip.places.place_rows import PlaceMap
from mapping.clip.scores import Background, Query
from mapping.occupancy.depth_mapper import DepthMapper
from mapping.slam.slam import Slam
from tests.helpers.box_room import CAMERA, T_BASE_CAM, lap, mapped, render
from vizbot.config import PerceptionConfig
from vizbot.core.geometry import invert, planar, transform
from vizbot.core.program.interrupts import ending_on_signals
from vizbot.core.simulated_clock import SimulatedClock
from vizbot.perception.interfaces import PerceptionParts
from vizbot.perception.perception import Perception


@pytest.fixture
def perceive(mean_colours):
    return partial(mapped, mean_colours)


def test_frames_that_come_while_the_encoder_is_busy_are_counted(mean_colours):
    clock, config = SimulatedClock(), PerceptionConfig(embedding_latency=0.31)
    perception = None
    for i, T_map_base in enumerate(lap(100)[:8]):
        frame = render(T_map_base, 0.15 * i)
        if perception is None:
            every = PerceptionParts(every_picture=True)
            perception = Perception(frame, T_BASE_CAM, mean_colours, clock, config, every)
        perception.embed(frame, perception.update(frame, None))
        clock.sleep(0.15)
    perception.finish()
    mapped = set(perception.clip_map.elements.frames.tolist())
    assert mapped == {0, 3, 6}  # each takes two frames and a bit
    assert (perception.embedded, perception.skipped) == (3, 5)


def test_every_element_has_its_statistics_at_every_step(perceive, mean_colours):
    lengths = []
    perception = perceive(
        lap(100)[:12],
        lambda so_far: lengths.append((len(so_far.statistics), len(so_far.clip_map))),
    )
    assert all(statistics == elements for statistics, elements in lengths)
    whole = Background.embedded_by(mean_colours).statistics(perception.clip_map.embeddings)
    np.testing.assert_allclose(perception.statistics, whole, atol=1e-6)


def test_a_place_is_of_patches_of_the_frame_that_shows_it(perceive):
    perception = perceive(lap(100)[:30])
    elements, rows = perception.clip_map.elements, perception.places.rows
    assert len(rows) > 50
    assert (elements.frames[rows.elements] == rows.frames[:, None]).all()
    np.testing.assert_array_equal(elements.keyframes[rows.elements[:, 0]], rows.keyframes)
    poses, frames = perception.slam.keyframe_poses(), perception.places.frames
    cameras = frames.Ts_map_cam(poses)[frames.rows_of(rows.frames)]
    for i, T_map_cam in enumerate(cameras):
        in_map = transform(poses[int(rows.keyframes[i])], rows.points_keyframe[i][None])
        x, y, z = transform(invert(T_map_cam), in_map)[0]
        u0, v0, u1, v1 = elements.boxes[rows.elements[i, 0]]
        assert u0 <= CAMERA.fx * x / z + CAMERA.cx <= u1
        assert v0 <= CAMERA.fy * y / z + CAMERA.cy <= v1


@pytest.mark.parametrize(
    ("part", "method"),
    [
        (Slam, "track"),
        (DepthMapper, "integrate"),
        (PlaceMap, "add"),
        (ClipMap, "add"),
        (GrowingRows, "add"),
    ],
)
def test_an_interrupted_map_can_be_saved(part, method, perceive, signals, monkeypatch, tmp_path):
    """Wherever it strikes: what is half changed is changed whole before the program ends."""
    do, perceptions = getattr(part, method), []

    def done_and_signalled(*args, **named):
        result = do(*args, **named)
        if perceptions:
            signal.raise_signal(signal.SIGINT)
        return result

    monkeypatch.setattr(part, method, done_and_signalled)
    with pytest.raises(KeyboardInterrupt), ending_on_signals():
        perceive(lap(100)[:9:3], perceptions.append)
    perceptions[0].finish()
    map_bundle.save(perceptions[0].bundle(), tmp_path / "map")
    kept = map_bundle.load(tmp_path / "map")
    assert kept.statistics is not None
    assert len(kept.statistics) == len(kept.elements.keyframes) > 0
    assert len(kept.trajectory.stamps) >= 2


def test_the_same_view_again_adds_nothing(perceive):
    seen, stood = [], planar(0.2, 0.2, 0.0)
    perceive(
        [planar(0.0, 0.0, 0.0), planar(0.1, 0.1, 0.0), stood, stood, stood, planar(0.2, 0.2, 0.4)],
        lambda so_far: seen.append((len(so_far.clip_map), len(so_far.places))),
    )
    elements, places = np.array(seen).T
    for counts in (elements, places):
        assert 0 < counts[2] == counts[3] == counts[4] < counts[5]


@pytest.mark.slow
def test_a_belief_that_follows_the_map_is_what_one_of_the_whole_map_is(perceive, mean_colours):
    question = Query(mean_colours.embed_texts(["red"])[0], None)
    following = Belief(question, fitted_weights())
    perception = perceive(lap(100), lambda so_far: so_far.believe(following))
    now, whole = (
        perception.believe(each) for each in (following, Belief(question, fitted_weights()))
    )
    assert whole.seen.sum() > 100
    for believed, other in ((now, whole), (whole, now)):
        rows, columns = np.nonzero(believed.seen)
        at = np.floor(believed.xy(rows, columns) / PLACE).astype(int) - other.low
        np.testing.assert_allclose(
            believed.probabilities[rows, columns],
            other.probabilities[at[:, 1], at[:, 0]],
            atol=1e-5,
        )
