import numpy as np
import pytest

from sim_stubs.realsense.config import ColourNoiseConfig, DepthNoiseConfig
from sim_stubs.realsense.depth_noise import (
    AutoExposure,
    motion_blurred,
    noisy_colour,
    noisy_depth,
    occluded,
    random_bytes,
)
from vizbot.core.geometry import planar
from vizbot.core.types import Intrinsics

CAMERA = Intrinsics(640, 480, 617.0, 617.0, 319.5, 239.5)
SHAPE = (480, 640)
TEXTURED = np.random.default_rng(1).integers(60, 200, (*SHAPE, 3), np.uint8)
PLAIN = np.full((*SHAPE, 3), 128, np.uint8)


def only(**parts):
    return DepthNoiseConfig.none().model_copy(update=parts)


def measured(depth, config, rgb=TEXTURED, seed=0, T_world_cam=None):
    T = np.eye(4) if T_world_cam is None else T_world_cam
    return noisy_depth(depth, rgb, CAMERA, T, config, np.random.default_rng(seed))


def flat(metres):
    return np.full(SHAPE, metres, np.float32)


def test_switched_off_the_truth_is_measured():
    depth = np.random.default_rng(0).uniform(0.1, 9, SHAPE).astype(np.float32)
    depth[:50] = 0
    assert np.array_equal(measured(depth, DepthNoiseConfig.none(), PLAIN), depth)


@pytest.mark.parametrize("metres", [1.0, 2.0, 4.0])
def test_depth_noise_grows_with_the_square_of_distance(metres):
    depth = measured(flat(metres), only(disparity_noise=0.08))
    assert depth.std() == pytest.approx(metres**2 * 0.08 / (617 * 0.05), rel=0.05)
    assert depth.mean() == pytest.approx(metres, rel=0.005)


def test_quantised_disparity_leaves_few_depths_far_away():
    true = np.linspace(4, 5, 480 * 640, dtype=np.float32).reshape(SHAPE)
    steps = np.unique(np.round(617 * 0.05 / measured(true, only(disparity_step=1 / 32)), 5))
    assert np.diff(steps) == pytest.approx(1 / 32, abs=1e-3)
    assert len(steps) < 60


def test_the_far_side_of_an_edge_is_lost_or_bled_over():
    true = flat(2.0)
    true[:, 320:] = 1.0
    depth = measured(true, only(edge_width=5))
    beyond = depth[:, 318:320]
    assert set(np.unique(beyond)) == {0.0, 1.0}
    assert (beyond == 1.0).mean() == pytest.approx(0.5, abs=0.1)
    assert (depth[:, :318] == 2.0).all()
    assert (depth[:, 320:] == 1.0).all()
    assert not measured(true, only(edge_width=5, bleeding=0.0))[:, 318:320].any()


def test_what_the_right_imager_does_not_see_is_lost_to_the_left_of_near_things():
    true = flat(2.0)
    true[:, 300:400] = 1.0
    shadow = round(617 * 0.05 * (1 / 1.0 - 1 / 2.0))
    depth = measured(true, only(occlusion=1.0))
    assert not depth[:, 301 - shadow : 300].any()
    assert (depth[:, : 299 - shadow] == 2.0).all()
    assert (depth[:, 300:] > 0).all()


def test_bytes_are_drawn_as_numpy_draws_them():
    rng, other = np.random.default_rng(3), np.random.default_rng(3)
    for shape in ((480, 640), (3, 4), (240, 320), (5, 5), (30, 40)):
        drawn = random_bytes(shape, rng)
        assert drawn.tobytes() == other.bytes(shape[0] * shape[1]) and drawn.flags.writeable
    assert rng.random() == other.random()


def test_what_lies_behind_something_nearer_to_the_right_is_hidden():
    disparity = np.random.default_rng(2).uniform(3, 60, (4, 640)).astype(np.float32)
    seen = np.arange(640, dtype=np.float32) - disparity
    nearest = np.minimum.accumulate(seen[:, ::-1], axis=1)[:, ::-1]
    assert np.array_equal(occluded(disparity)[:, :-1], seen[:, :-1] > nearest[:, 1:])
    assert not occluded(disparity)[:, -1].any()


def test_a_slanted_wall_does_not_hide_itself():
    u = np.arange(640, dtype=np.float32)
    assert not occluded(np.tile(0.2 * u, (4, 1))).any()
    assert not occluded(np.tile(0.2 * u[::-1], (4, 1))).any()


@pytest.mark.parametrize(("level", "lost"), [(3, 1.0), (16, 0.5), (60, 0.0)])
def test_dark_surfaces_have_holes(level, lost):
    depth = measured(flat(1.5), only(dark=16.0), np.full((*SHAPE, 3), level, np.uint8))
    assert (depth == 0).mean() == pytest.approx(lost, abs=0.15)


def test_highlights_blind():
    rgb = TEXTURED.copy()
    rgb[100:200, 100:200] = 255
    depth = measured(flat(1.5), only(shiny=0.985), rgb)
    assert not depth[110:190, 110:190].any()
    assert (depth[250:] > 0).all()


@pytest.mark.parametrize(("metres", "plain", "textured"), [(2.0, 0.0, 0.0), (4.5, 1.0, 0.0)])
def test_plain_surfaces_are_lost_beyond_the_projector_s_range(metres, plain, textured):
    config = only(plain=0.6)
    assert (measured(flat(metres), config, PLAIN) == 0).mean() == pytest.approx(plain, abs=0.05)
    lost = (measured(flat(metres), config, TEXTURED) == 0).mean()
    assert lost == pytest.approx(textured, abs=0.05)


def test_nothing_near_is_measured_and_far_away_it_fades_out():
    config = DepthNoiseConfig()
    assert not measured(flat(0.27), config).any()
    share = [(measured(flat(z), config) > 0).mean() for z in (0.3, 4.5, 5.5, 7.0)]
    assert share == pytest.approx([1.0, 1.0, 0.5, 0.0], abs=0.1)
    assert 0.0 < (measured(flat(6.0), config) > 0).mean() < 0.1


def test_holes_stay_in_their_places_in_the_world():
    config = only(greatest_range=6.5, range_fade=0.6)
    first = measured(flat(6.5), config) == 0
    again = measured(flat(6.5), config, seed=1) == 0
    assert (first == again).mean() > 0.85
    beside = planar(0.0, 0.0, 0.0)
    beside[0, 3] = 5.0
    assert (first == (measured(flat(6.5), config, T_world_cam=beside) == 0)).mean() < 0.65


def test_nothing_stays_nothing():
    assert not measured(np.zeros(SHAPE, np.float32), DepthNoiseConfig()).any()


def test_colour_noise_has_its_size_grows_with_gain_and_has_no_colour():
    config = ColourNoiseConfig.none().model_copy(update={"noise": 3.0})
    for gain in (1.0, 1.5):
        noisy = noisy_colour(PLAIN, gain, 0.0, config, np.random.default_rng(0)).astype(float)
        assert noisy.std() == pytest.approx(3.0 * gain, rel=0.05)
        assert noisy.mean() == pytest.approx(128 * gain, abs=0.5)
        assert np.ptp(noisy, axis=2).max() == 0


def test_switched_off_the_picture_is_as_rendered():
    config = ColourNoiseConfig.none()
    gain = AutoExposure(config).gain(TEXTURED, 0.2)
    picture = noisy_colour(TEXTURED, gain, 0.0, config, np.random.default_rng(0))
    assert np.array_equal(picture, TEXTURED)


@pytest.mark.parametrize("shift", [0.5, 2.0, 5.0, -7.3])
def test_blur_smears_a_line_over_the_shift(shift):
    line = np.zeros((*SHAPE, 3), np.uint8)
    line[:, 320] = 240
    blurred = motion_blurred(line, shift)[240, :, 0].astype(float)
    columns = np.nonzero(blurred)[0]
    assert len(columns) <= abs(shift) + 2
    assert blurred.sum() == pytest.approx(240, abs=6)
    assert (blurred @ np.arange(640)) / blurred.sum() == pytest.approx(320, abs=0.1)
    assert blurred.max() == pytest.approx(240 / max(1.0, abs(shift)), abs=2)


def test_auto_exposure_follows_the_light_with_a_lag():
    dark, light = (np.full((*SHAPE, 3), level, np.uint8) for level in (40, 160))
    exposure = AutoExposure(ColourNoiseConfig(exposure_control=1.0, exposure_lag=0.4))
    assert 160 * exposure.gain(light, 0.2) == pytest.approx(110)
    gains = [exposure.gain(dark, 0.2) for _ in range(15)]
    assert gains[0] < 1.5
    assert np.all(np.diff(gains) > 0)
    assert 40 * gains[-1] == pytest.approx(110, rel=0.01)
