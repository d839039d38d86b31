"""The truth about each part, in a room where it is known."""

from dataclasses import dataclass
from math import sqrt
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.episodes.oracles import (
    ORACLES,
    PerfectStop,
    TrueEncoder,
    TrueMap,
    TruePose,
    oracle_parts,
)
from mapping.keyframes.config import KeyframeConfig
from mapping.occupancy.config import DepthMapperConfig
from sim_stubs.world.body import WorldConfig
from sim_stubs.world.world import World
from tests.test_benchmarks.episodes.one_room import kitchen_with_sofa
from vizbot.config import Config
from vizbot.core.errors import ConfigError
from vizbot.core.geometry import invert, planar
from vizbot.core.observer import Outcome
from vizbot.core.types import STOP, ImuSamples, RGBDFrame
from vizbot.objectnav.tasks import Goal
from vizbot.perception.interfaces import PerceptionParts
from vizbot.rehearsal.config import RehearsalConfig

GOALS = ("sofa", "kitchen", "bed")


@pytest.fixture(scope="module")
def world():
    """A kitchen with a sofa, 1.5 m ahead of the robot and looking at it."""
    with World(kitchen_with_sofa(5, 4, 3.2, (1.2, 2.0, 0.3)), WorldConfig()) as world:
        yield world


@pytest.fixture(autouse=True)
def at_start(world):
    world.place(*world.house.start)


@dataclass(frozen=True)
class Ticked:
    """What a pipeline that moves the robot by itself does in a step."""

    ended: tuple[Outcome, str] | None = None


@pytest.mark.parametrize(
    ("ways", "rolls_to", "ended"),
    [
        ((0.4, 1.2), 1.25, [None, Outcome.ARRIVED]),
        ((0.4, 0.5), 0.5, [None, None]),
        # It was within 2 m, but not any more where it has come to rest.
        ((1.2, 0.4), 0.4, [None, None]),
    ],
)
def test_a_perfect_stop_is_where_the_robot_rests_within_reach(world, ways, rolls_to, ended):
    def tick(task):
        world.place(next(xs), 2.0, 0.0)
        return Ticked()

    xs, driven = iter(ways), []
    pipeline = SimpleNamespace(tick=tick, goal=None, report=None, steps=2)
    devices = SimpleNamespace(
        base=SimpleNamespace(drive=driven.append),
        clock=SimpleNamespace(sleep=lambda seconds: world.place(rolls_to, 2.0, 0.0)),
    )
    stopping = PerfectStop(pipeline, devices, world)
    goal = Goal("sofa", np.zeros(2, np.float32), 0.5)
    found = [stopping.tick(goal).ended for _ in ways]
    assert [each and each[0] for each in found] == ended
    assert driven == [STOP] * (max(ways) > 1.0) and stopping.steps == 2


def test_a_perfect_stop_leaves_a_claim_of_the_search_as_it_is(world):
    claim = Ticked((Outcome.ARRIVED, "90% sure"))
    pipeline = SimpleNamespace(tick=lambda task: claim, goal=None, report=None, steps=1)
    stopping = PerfectStop(pipeline, SimpleNamespace(base="not driven"), world)
    assert stopping.tick(Goal("sofa", np.zeros(2, np.float32), 0.5)) is claim


def frame(world):
    rgb, depth = world.render()
    return RGBDFrame(0.0, rgb, depth, world.intrinsics, ImuSamples.none())


def test_the_true_pose_is_the_worlds_seen_from_the_start(world):
    slam = TruePose.in_world(world, KeyframeConfig())
    first = slam.track(frame(world), None)
    assert np.allclose(first.T_map_cam, world.T_base_cam)
    assert first.is_keyframe and first.keyframe == 0
    start = world.T_world_base
    world.place(1.4, 2.1, 0.2)
    second = slam.track(frame(world), None)
    expected = invert(start) @ planar(1.4, 2.1, 0.2) @ world.T_base_cam
    assert np.allclose(second.T_map_cam, expected)
    T_map_keyframe = slam.keyframe_poses()[second.keyframe]
    assert np.allclose(T_map_keyframe @ second.T_keyframe_cam, expected)


def test_keyframes_of_the_true_pose_are_a_way_or_a_turn_apart(world):
    slam = TruePose.in_world(world, KeyframeConfig(distance=0.25, angle=0.25))
    poses = [(1.2, 2.0, 0.3), (1.3, 2.0, 0.3), (1.5, 2.0, 0.3), (1.5, 2.0, 0.6), (1.5, 2.0, 0.7)]
    new = []
    for pose in poses:
        world.place(*pose)
        new.append(slam.track(frame(world), None).is_keyframe)
    assert new == [True, False, True, True, False]


def look(world, mapper, T_map_cam):
    mapper.integrate(0, np.eye(4), T_map_cam, frame(world).depth, world.intrinsics)
    return mapper.grid()


def occupancy(grid, T_map_world, x, y):
    """Of the cell at x, y in the world."""
    p_map = T_map_world @ [x, y, 0.0, 1.0]
    row, col = grid.to_cells(p_map[:2])
    return grid.occupancy[row, col]


@pytest.mark.parametrize("T_true_believed", [np.eye(4), planar(0.3, -0.2, 0.1)])
def test_the_true_map_is_the_truth_where_the_robot_believes_to_have_looked_and_nothing_elsewhere(
    world, T_true_believed
):
    T_map_world = T_true_believed @ invert(world.T_world_base)
    grid = look(world, TrueMap(world, DepthMapperConfig()), T_true_believed @ world.T_base_cam)
    sofa = world.instances[0]
    front = sofa.x - sofa.piece.size[1] / 2
    assert occupancy(grid, T_map_world, front + 0.02, 2.1) == 1.0
    assert occupancy(grid, T_map_world, front - 0.25, 2.1) == 0.0
    assert occupancy(grid, T_map_world, 0.2, 2.0) == 0.5


def test_the_true_encoder_tells_the_share_of_a_patch(world):
    encoder = TrueEncoder(world, GOALS)
    rgb = frame(world).rgb
    patches = [rgb, rgb[0:224, 96:320], rgb[240:480, 300:500]]
    cosines = encoder.embed_images(patches) @ encoder.embed_texts(GOALS).T
    shown = world.segment() == 0
    shares = [shown.mean(), shown[0:224, 96:320].mean(), shown[240:480, 300:500].mean()]
    assert min(shares[0], shares[2]) > 0.1
    assert cosines[:, 0] == pytest.approx(np.sqrt(np.array(shares) / 2), abs=1e-5)
    assert cosines[:, 1] == pytest.approx(sqrt(0.5), abs=0.02)  # nothing but the kitchen
    assert (cosines[:, 2] == 0.0).all()


def test_the_true_encoder_knows_nothing_of_pictures_of_other_cameras(world):
    encoder = TrueEncoder(world, GOALS)
    rows = encoder.embed_images([np.full((96, 96, 3), 90, np.uint8)])
    assert (rows @ encoder.embed_texts(GOALS).T == 0.0).all()
    assert np.linalg.norm(rows, axis=1) == pytest.approx([1.0])


def test_embeddings_of_the_true_encoder_are_unit_and_other_words_are_like_nothing(world):
    encoder = TrueEncoder(world, GOALS)
    assert encoder.embed_images([]).shape == (0, 5)
    embeddings = encoder.embed_images([frame(world).rgb[:112, :112]])
    assert np.linalg.norm(embeddings, axis=1) == pytest.approx([1.0])
    others = encoder.embed_texts(["yellow chair", "an object", "a texture", "a lamp"])
    assert np.linalg.norm(others, axis=1) == pytest.approx(1.0)
    cosines = embeddings @ others.T
    assert np.abs(cosines).max() <= 0.1 and cosines.std() > 0.02


@pytest.mark.parametrize("part", ORACLES)
def test_each_oracle_switches_one_part(world, part):
    config = Config()
    true = oracle_parts(part, world, config)
    perception = true.perception or PerceptionParts()
    switched = {
        "pose": perception.slam is not None,
        "map": perception.depth_mapper is not None,
        "encoder": true.encoder is not None,
        "depth": true.config != config,
    }
    assert [name for name, on in switched.items() if on] == [part]


def test_true_depth_is_the_depth_alone():
    config = oracle_parts("depth", None, Config()).config
    camera = RehearsalConfig.read(config).sim_camera
    assert camera.colour_noise == RehearsalConfig().sim_camera.colour_noise
    assert camera.depth_noise.disparity_noise == 0.0
    assert config.perception == Config().perception


def test_an_unknown_oracle_is_an_error(world):
    with pytest.raises(ConfigError, match="'planner'"):
        oracle_parts("planner", world, Config())
