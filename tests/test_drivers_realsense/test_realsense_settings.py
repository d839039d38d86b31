"""Options, rates and filters of a RealSense, set through the real SDK on software devices."""

import numpy as np
import pytest
from pydantic import ValidationError

from drivers.realsense.config import (
    DepthFilterConfig,
    Preset,
    RealSenseConfig,
    SpatialFilterConfig,
    TemporalFilterConfig,
)
from drivers.realsense.discovery import nearest_rate
from drivers.realsense.playback import RealSenseRecording
from drivers.realsense.sdk import rs
from sim_stubs.realsense.software_device import SoftwareD435i
from tests.helpers.d435i_frames import SERIAL, START, colour, depth_mm, opened, stamp_of
from tests.helpers.failing import raising
from vizbot.config import Config, load_config, write_config
from vizbot.core.errors import DeviceError

WALL = np.full((480, 640), 2000, np.uint16)


def depth_seen(depths_mm, **filters):
    """Depth of the last of these images [m], filtered."""
    device = SoftwareD435i(serial=SERIAL)
    with opened(device, filters=DepthFilterConfig(**filters)) as (camera, _, _):
        for index, image in enumerate(depths_mm):
            device.push_frame(colour(index), image, stamp_of(index))
            frame = camera.read()
        assert (camera.filter_cost > 0.0) == bool(filters)
    return frame.depth


@pytest.mark.parametrize("preset", Preset)
def test_a_preset_is_set_by_its_name(preset):
    device = SoftwareD435i(serial=SERIAL, controls=True)
    with opened(device, preset=preset):
        wanted = getattr(rs.rs400_visual_preset, preset.name.lower())
        assert device.setting(rs.option.visual_preset) == int(wanted)


def test_exposure_is_automatic_up_to_its_limit():
    device = SoftwareD435i(serial=SERIAL, controls=True)
    with opened(device, exposure_limit=0.004):
        assert device.setting(rs.option.auto_exposure_limit) == pytest.approx(4000.0)
        assert device.setting(rs.option.auto_exposure_limit_toggle) == 1.0
        assert device.setting(rs.option.enable_auto_exposure) == 1.0
        assert device.setting(rs.option.auto_exposure_priority) == 0.0


def test_a_limit_that_is_longer_than_the_camera_can_expose_is_what_it_can():
    device = SoftwareD435i(serial=SERIAL, controls=True)
    with opened(device, exposure_limit=0.2):
        assert device.setting(rs.option.auto_exposure_limit) == 200_000.0


def test_without_a_limit_the_camera_exposes_as_it_likes():
    device = SoftwareD435i(serial=SERIAL, controls=True)
    with opened(device, exposure_limit=0.004):  # a camera keeps what it was told
        pass
    with opened(device, exposure_limit=None):
        assert device.setting(rs.option.auto_exposure_limit_toggle) == 0.0
        assert device.setting(rs.option.enable_auto_exposure) == 1.0
        assert device.setting(rs.option.auto_exposure_priority) == 1.0


@pytest.mark.parametrize("emitter", [True, False])
def test_the_projector_is_switched_and_its_power_left_alone(emitter):
    device = SoftwareD435i(serial=SERIAL, controls=True)
    with opened(device, emitter=emitter):
        assert device.setting(rs.option.emitter_enabled) == float(emitter)
        assert device.setting(rs.option.laser_power) == 150.0


def test_images_and_imu_share_the_hosts_clock_whatever_another_program_left():
    device, shared = SoftwareD435i(serial=SERIAL, controls=True), rs.option.global_time_enabled
    with opened(device) as (_, _, context):
        sensors = list(context.query_devices()[0].query_sensors())
        for sensor in sensors:
            sensor.set_option(shared, 0.0)
    with opened(device):
        assert [sensor.get_option(shared) for sensor in sensors] == [1.0, 1.0, 1.0]


def test_a_camera_without_these_options_opens_all_the_same(caplog):
    device = SoftwareD435i(serial=SERIAL)
    with opened(device) as (camera, _, _):
        device.push_frame(colour(0), depth_mm(0), START)
        assert camera.read() is not None
    assert caplog.messages == []


def test_an_option_that_the_sdk_refuses_is_one_warning(caplog, monkeypatch):
    device = SoftwareD435i(serial=SERIAL, controls=True)
    monkeypatch.setattr(
        rs.sensor,
        "set_option",
        raising(RuntimeError("hwmon command 0x80 failed\n (Unknown error)")),
    )
    with opened(device) as (camera, _, _):
        device.push_frame(colour(0), depth_mm(0), START)
        assert camera.read() is not None
    told = [message for message in caplog.messages if "emitter_enabled" in message]
    assert len(told) == 1 and "hwmon command 0x80 failed (Unknown error)" in told[0]


@pytest.mark.parametrize("fps", [15, 6])
def test_on_usb_2_the_next_lower_rate_is_taken_and_the_remedy_logged(fps, caplog):
    device = SoftwareD435i(serial=SERIAL, usb="2.1", fps=fps)
    with opened(device) as (camera, _, _):
        for index in range(3):
            device.push_frame(colour(index), depth_mm(index), START + index / fps)
            assert camera.read().stamp == pytest.approx(START + index / fps, abs=1e-6)
    [told] = caplog.messages
    assert f"640x480 comes at {fps}/s, not 30/s, on USB 2.1; use a USB 3 port" in told


def test_a_camera_that_is_only_faster_than_asked_is_refused():
    with (
        pytest.raises(DeviceError, match="640x480 at 6/s"),
        opened(SoftwareD435i(serial=SERIAL), fps=6),
    ):
        pass


def test_the_nearest_lower_rate_is_the_highest_below():
    assert nearest_rate(30, {6, 15, 30, 60}) == 30
    assert nearest_rate(30, {60, 15, 6}) == 15
    assert nearest_rate(30, {60, 90}) == 30
    assert nearest_rate(30, ()) == 30


def test_without_filters_depth_is_as_it_came():
    np.testing.assert_allclose(depth_seen([depth_mm(0)]), depth_mm(0) / 1000.0, atol=1e-6)


def test_what_is_too_near_or_too_far_counts_as_not_measured():
    image = WALL.copy()
    image[:100], image[100:200], image[200:300] = 200, 900, 5000
    depth = depth_seen([image], nearest=0.5, farthest=4.0)
    assert not depth[:100].any() and not depth[200:300].any()
    np.testing.assert_allclose(depth[100:200], 0.9, atol=1e-6)
    assert depth_seen([image], nearest=0.5)[250, 0] == pytest.approx(5.0)


def test_the_spatial_filter_smooths_a_wall_and_keeps_its_edge():
    rng = np.random.default_rng(0)
    image = (WALL + rng.normal(0.0, 20.0, WALL.shape)).astype(np.uint16)
    image[:, 400:] -= 1000
    depth = depth_seen([image], spatial=SpatialFilterConfig(passes=5))
    assert depth[100:400, 100:300].std() < 0.6 * 0.020
    assert np.median(depth[:, 395]) == pytest.approx(2.0, abs=0.03)
    assert np.median(depth[:, 405]) == pytest.approx(1.0, abs=0.03)


def test_the_temporal_filter_smooths_over_time_and_fills_no_holes_from_the_past():
    rng = np.random.default_rng(0)
    images = [(WALL + rng.normal(0.0, 20.0, WALL.shape)).astype(np.uint16) for _ in range(8)]
    images[-1][200:240, 200:240] = 0
    depth = depth_seen(images, temporal=TemporalFilterConfig())
    assert depth[250:, :].std() < 0.7 * 0.020
    assert not depth[205:235, 205:235].any()


def test_a_recording_is_filtered_only_when_asked(tmp_path):
    path = tmp_path / "wall.db3"
    device = SoftwareD435i()
    with device.record(path):
        for index in range(3):
            device.push_frame(colour(index), depth_mm(index), stamp_of(index))
    near_only = RealSenseConfig(filters=DepthFilterConfig(farthest=1.5))
    for config, greatest in ((RealSenseConfig(), 2.0), (near_only, 1.0)):
        with RealSenseRecording(config, path) as player:
            assert player.read().depth.max() == np.float32(greatest)


def test_settings_survive_a_file(tmp_path):
    filters = DepthFilterConfig(farthest=4.0, spatial=SpatialFilterConfig())
    realsense = RealSenseConfig(preset=Preset.HIGH_ACCURACY, filters=filters)
    write_config(Config(realsense=realsense), tmp_path / "robot.toml")
    assert load_config(tmp_path / "robot.toml").realsense == realsense


def test_a_range_that_ends_before_it_begins_is_refused():
    with pytest.raises(ValidationError, match="nearest"):
        DepthFilterConfig(nearest=3.0, farthest=1.0)
