"""A map whose pictures are taken again does not grow with time."""

from dataclasses import replace

import numpy as np
import pytest

from mapping.clip import compaction
from mapping.clip.places.belief import Belief
from mapping.clip.places.evidence import fitted_weights
from mapping.clip.places.view_age import LATER
from mapping.clip.scores import Query
from mapping.map_bundle import load, save
from tests.helpers.box_room import AT_ONCE, T_BASE_CAM, dead_reckoning, lap, render
from tests.helpers.bundles import assert_same
from vizbot.core.simulated_clock import SimulatedClock
from vizbot.perception import perception as module
from vizbot.perception.perception import Perception


@pytest.fixture
def soon_due(monkeypatch):
    for where in (compaction, module):
        monkeypatch.setattr(where, "LEAST", 5)


def laps(encoder, number, watch=lambda perception: None):
    """Perception after the same lap again and again, with long pauses between."""
    path = lap(60)
    clock, perception = SimulatedClock(), None
    wheels = dead_reckoning(path)
    for turn in range(number):
        for i, T_map_base in enumerate(path):
            frame = render(T_map_base, turn * 2 * LATER + 0.2 * i)
            if perception is None:
                perception = Perception(frame, T_BASE_CAM, encoder, clock, AT_ONCE)
            perception.embed(frame, perception.update(frame, wheels[i]))
            watch(perception)
            clock.sleep(0.2)
    perception.finish()
    return perception


@pytest.mark.slow
def test_pictures_that_were_taken_again_leave_the_map_and_beliefs_follow(
    mean_colours, soon_due, tmp_path
):
    question, frames = Query(mean_colours.embed_texts(["red"])[0], None), []
    following = Belief(question, fitted_weights())

    def watch(perception):
        perception.believe(following)
        frames.append(len(perception.places.frames))

    perception = laps(mean_colours, 4, watch)
    assert frames[-1] < 1.5 * frames[59], "one lap's pictures, and those not dropped yet"
    elements, rows = perception.clip_map.elements, perception.places.rows
    assert (elements.frames[rows.elements] == rows.frames[:, None]).all()
    assert set(elements.frames.tolist()) <= set(perception.places.frames.numbers.tolist())
    assert len(perception.statistics) == len(elements.frames) == len(perception.points())
    now, anew = (
        perception.believe(each) for each in (following, Belief(question, fitted_weights()))
    )
    np.testing.assert_allclose(now.probabilities, anew.probabilities, atol=1e-3)
    save(perception.bundle(), tmp_path / "home")
    assert_same(
        load(tmp_path / "home"),
        replace(perception.bundle(), created=load(tmp_path / "home").created),
    )
