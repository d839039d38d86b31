"""A run that begins in the map of another."""

from copy import deepcopy
from dataclasses import replace

import numpy as np
import pytest

from mapping.clip.mapped_frames import MappedFrame
from mapping.clip.mapper import ClipMap, FrameElements
from mapping.clip.scores import NO_PICTURES
from mapping.keyframes.anchors import Keyframes
from mapping.map_bundle import MapBundle, load, save, with_background
from mapping.occupancy.config import DepthMapperConfig
from mapping.occupancy.depth_mapper import DepthMapper
from tests.conftest import MeanColours
from tests.helpers.box_room import AT_ONCE, T_BASE_CAM, dead_reckoning, lap, mapped, render
from tests.helpers.boxes import LOW_BOX, MOUNT, see
from tests.helpers.bundles import Encoder, bundle_of
from vizbot.config import Config
from vizbot.core.errors import MapError
from vizbot.core.geometry import invert, planar, rotation_angle
from vizbot.core.simulated_clock import SimulatedClock
from vizbot.core.types import OccupancyGrid, Tracking
from vizbot.perception.interfaces import PerceptionParts
from vizbot.perception.perception import Perception
from vizbot.perception.run_record import RunRecord
from vizbot.pipeline import Pipeline

CONFIG = DepthMapperConfig()


def known(grid: OccupancyGrid) -> dict[tuple[float, float], float]:
    """Occupancy of the cells that are not unknown, by their centres."""
    cells = np.argwhere(np.abs(grid.occupancy - 0.5) > 1e-3)
    xy = grid.to_xy(cells).round(3).tolist()
    return {
        (x, y): float(grid.occupancy[tuple(cell)]) for (x, y), cell in zip(xy, cells, strict=True)
    }


@pytest.fixture
def kept_grid() -> OccupancyGrid:
    mapper = DepthMapper(CONFIG)
    see(mapper, planar(-1.0, 0.5, 0.4), [LOW_BOX], frames=3)
    mapper.mark_obstacle(planar(-1.0, 0.5, 0.4), np.array([[0.2, 0.0]]))
    return mapper.grid()


def test_the_obstacle_map_goes_on_from_a_kept_one(kept_grid):
    again = known(DepthMapper(CONFIG, kept_grid).grid())
    before = known(kept_grid)
    assert again.keys() == before.keys()
    assert max(abs(again[cell] - before[cell]) for cell in before) < 1e-4


def test_what_is_kept_stays_when_the_graph_moves_and_depth_does_not_clear_contacts(kept_grid):
    mapper = DepthMapper(CONFIG, kept_grid)
    see(mapper, planar(-1.0, 0.5, 0.4), keyframe=3, frames=30)
    felt = (kept_grid.to_xy(np.argwhere(kept_grid.occupancy == 1.0)).round(3)).tolist()
    assert len(felt) == 1
    assert known(mapper.grid())[tuple(felt[0])] == 1.0
    away = planar(40.0, 0.0, 0.0) @ planar(-1.0, 0.5, 0.4) @ MOUNT
    assert mapper.follow({3: away})
    after = known(mapper.grid())
    assert all(abs(after[cell] - value) < 1e-4 for cell, value in known(kept_grid).items())


def test_a_map_with_other_cells_is_refused(kept_grid):
    with pytest.raises(MapError, match=r"0\.1 m wide.*resolution to 0\.1") as error:
        DepthMapper(CONFIG, replace(kept_grid, resolution=0.1))
    assert "\n" not in str(error.value)


def test_elements_are_added_to_those_that_are_kept():
    kept = bundle_of(3, frames=9).elements
    clip_map = ClipMap(4, kept)
    assert len(clip_map) == len(kept.keyframes)
    fresh = FrameElements(np.ones((2, 3)), np.ones((2, 4), np.float32), np.ones((2, 4), np.int32))
    clip_map.add(MappedFrame(9, 7, np.eye(4), 0.0), fresh)
    np.testing.assert_array_equal(clip_map.elements.keyframes[:-2], kept.keyframes)
    np.testing.assert_array_equal(clip_map.elements.frames[-2:], [9, 9])
    np.testing.assert_array_equal(kept.keyframes, bundle_of(3, frames=9).elements.keyframes)


def test_a_kept_run_is_older_than_the_one_that_goes_on():
    bundle = bundle_of(1, frames=9)
    for began, late in ((0.0, 1.8), (100.0, 0.0)):
        record = RunRecord.going_on(bundle.trajectory, bundle.cloud, bundle.keyframes, before=began)
        stamps = record.trajectory.stamps
        np.testing.assert_allclose(stamps, bundle.trajectory.stamps - late)
        assert stamps[-1] < began
        again = Keyframes.with_poses(bundle.keyframes.poses(), record.keyframe_stamps)
        np.testing.assert_array_equal(again.ids, bundle.keyframes.ids)
        np.testing.assert_allclose(again.stamps, bundle.keyframes.stamps - late)


def test_a_map_of_another_encoder_is_refused_before_anything_is_read():
    with pytest.raises(MapError, match="--clip ViT-B/32"):
        Pipeline(None, Encoder("embedded"), Config(), [], saved_map=bundle_of(model_id="ViT-B/32"))


@pytest.fixture(scope="module")
def kept_run() -> MapBundle:
    return mapped(MeanColours(), lap(100)).bundle()


@pytest.fixture
def first_run(kept_run) -> MapBundle:
    return deepcopy(kept_run)


@pytest.mark.slow
def test_a_robot_finds_itself_in_a_kept_map_and_maps_on(first_run, mean_colours, tmp_path):
    save(first_run, tmp_path / "home")
    kept, path = load(tmp_path / "home"), lap(100)
    onward = [path[30] @ planar(0.05, 0.1, 0.05 * i) for i in range(25)]
    wheels = dead_reckoning(onward)
    frames = [render(T, 0.2 * i) for i, T in enumerate(onward)]
    perception = Perception(
        frames[0],
        T_BASE_CAM,
        mean_colours,
        SimulatedClock(),
        AT_ONCE,
        PerceptionParts(every_pose=True),
        kept,
    )
    before = perception.points()
    np.testing.assert_allclose(before, first_run.element_points(), atol=1e-6)
    np.testing.assert_array_equal(perception.statistics, first_run.statistics)
    np.testing.assert_array_equal(perception.places.rows.elements, first_run.places.elements)
    states = []
    for i, frame in enumerate(frames):
        estimate = perception.update(frame, wheels[i])
        perception.embed(frame, estimate)
        states.append(estimate.tracking)
    perception.finish()
    assert Tracking.RELOCALISED in states[:3]
    assert set(states[3:]) <= {Tracking.TRACKING, Tracking.RELOCALISED}
    off = invert(invert(path[0]) @ onward[-1] @ T_BASE_CAM) @ estimate.T_map_cam
    assert np.linalg.norm(off[:3, 3]) < 0.05
    assert rotation_angle(off) < 0.03
    bundle = perception.bundle()
    np.testing.assert_allclose(bundle.element_points()[: len(before)], before, atol=1e-3)
    assert len(bundle.statistics) == len(bundle.elements.keyframes) > len(before)
    assert len(bundle.places) > len(first_run.places)
    assert bundle.places.elements[len(first_run.places) :].min() >= len(before)
    assert len(bundle.trajectory.stamps) == len(kept.trajectory.stamps) + len(onward)
    assert (np.diff(bundle.trajectory.stamps) > 0).all()
    assert set(first_run.keyframes.ids) <= set(bundle.keyframes.ids)
    assert len(bundle.cloud.points_keyframe) >= len(first_run.cloud.points_keyframe)
    save(bundle, tmp_path / "home")
    assert len(load(tmp_path / "home").elements.frames) == len(bundle.elements.frames)


@pytest.mark.slow
@pytest.mark.parametrize("lost", [{"statistics": None}, {"pictures": NO_PICTURES}])
def test_what_a_map_lacks_of_its_background_is_computed_when_it_is_continued(
    first_run, mean_colours, lost
):
    frame, lacking = render(lap(100)[30], 0.0), replace(first_run, **lost)
    perception = Perception(
        frame, T_BASE_CAM, mean_colours, SimulatedClock(), AT_ONCE, saved_map=lacking
    )
    asked = with_background(lacking, mean_colours)
    for each in (perception, asked):
        np.testing.assert_allclose(each.statistics, first_run.statistics, atol=1e-6)
        np.testing.assert_array_equal(each.pictures, first_run.pictures)
    assert len(first_run.pictures) == 256
