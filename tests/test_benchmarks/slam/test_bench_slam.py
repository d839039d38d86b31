"""Pose estimators side by side, on a camera that moves along a painted wall."""

import json
import os
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from benchmarks.slam import frame_to_frame, sequence_scores
from benchmarks.slam import peers as slam_peers
from benchmarks.slam import recordings as slam
from benchmarks.slam.drawing import Path2D, draw_paths
from benchmarks.slam.frame_to_frame import FrameToFrame, feature_odometry
from benchmarks.slam.recordings import SlamBench, run_slam, track_sequence
from mapping.slam.config import SlamConfig
from mapping.tum import read_trajectory, write_trajectory
from vizbot.core.errors import ConfigError
from vizbot.core.geometry import planar
from vizbot.core.types import ImuSamples, Intrinsics, RGBDFrame

CAMERA = Intrinsics(160, 120, 150.0, 150.0, 79.5, 59.5)
WALL_DISTANCE, STEP, FRAMES = 1.5, 0.04, 12
PIXELS = CAMERA.fx / WALL_DISTANCE


def wall():
    rng = np.random.default_rng(4)
    painted = np.full((200, 400, 3), 140, np.uint8)
    for _ in range(400):
        (u, v), (w, h) = rng.integers(0, (390, 190)), rng.integers(4, 18, 2)
        painted[v : v + h, u : u + w] = rng.uniform(30, 230, 3)
    return cv2.GaussianBlur(painted, (0, 0), 0.8)


@pytest.fixture
def sequence(tmp_path):
    """A camera that goes sideways along a wall, looking at it."""
    folder = tmp_path / "wall"
    (folder / "rgb").mkdir(parents=True)
    painted, rows, poses = wall(), [], []
    for i in range(FRAMES):
        shift = np.float32([[1, 0, -20 - i * STEP * PIXELS], [0, 1, -20]])
        image = cv2.warpAffine(painted, shift, (CAMERA.width, CAMERA.height))
        depth = np.full((CAMERA.height, CAMERA.width), round(1000 * WALL_DISTANCE), np.uint16)
        for name, pixels in ((f"rgb/{i}.png", image), (f"rgb/{i}d.png", depth)):
            cv2.imwrite(str(folder / name), pixels)
        rows.append(f"{i / 5} rgb/{i}.png {i / 5} rgb/{i}d.png\n")
        poses.append(planar(i * STEP, 0.0, 0.0))
    (folder / "associations.txt").write_text("".join(rows))
    calibration = {"width": 160, "height": 120, "fx": 150.0, "fy": 150.0, "cx": 79.5, "cy": 59.5}
    (folder / "camera.json").write_text(json.dumps(calibration | {"depth_scale": 1000}))
    write_trajectory(folder / "groundtruth.txt", np.arange(FRAMES) / 5, np.array(poses))
    return folder


def asked(sequence, **changes):
    known = {
        "recording": None, "stride": 1, "vocabulary": None, "config": SlamConfig(),
        "out": sequence.parent / "out", "runs": 2,
    }  # fmt: skip
    return SlamBench(sequence, **(known | changes))


def test_what_no_camera_delivers_is_said_of_the_sequence(sequence, caplog):
    said = json.loads((sequence / "camera.json").read_text())
    (sequence / "camera.json").write_text(json.dumps(said | {"cy": 40.0}))
    run_slam(asked(sequence, runs=1))
    assert any("the principal point 80, 40 is far" in each.getMessage() for each in caplog.records)


def test_a_sequence_is_tracked_and_its_error_told_beside_a_peer(sequence):
    outcome = run_slam(asked(sequence))
    ours, features, opencv = outcome.rows[:3]
    names = [row["row"] for row in (ours, features, opencv)]
    assert names == ["vizbot", "ORB features and PnP", "OpenCV RGB-D"]
    assert features["tracked"] == 1.0 and features["ate_rmse"] < 0.02
    assert opencv["tracked"] > 0.5
    assert ours["ate_rmse"] < 0.01
    assert ours["tracked"] == 1.0
    assert ours["ms_mean"] > 0
    assert outcome.summary["frames"] == FRAMES
    assert outcome.summary["ate_rmse"] == ours["ate_rmse"]
    assert outcome.summary["against_orbslam3"] is None
    assert outcome.summary["reference_kernel_ms"] > 0
    stamps, Ts_map_cam = read_trajectory(sequence.parent / "out" / "vizbot-online.tum")
    assert len(stamps) == len(Ts_map_cam) == FRAMES
    assert (sequence.parent / "out" / "trajectories.png").read_bytes()[1:4] == b"PNG"
    kept = json.loads((sequence.parent / "out" / "results.json").read_text())
    assert kept["rows"] == outcome.rows and kept["summary"] == outcome.summary
    assert kept["sequence"] == sequence.name and kept["commit"] and kept["hardware"]


def test_a_stride_leaves_frames_out_and_one_metre_is_not_reached(sequence):
    outcome = run_slam(asked(sequence, stride=3, runs=1))
    assert outcome.summary["frames"] == 4
    assert outcome.summary["rpe_m_per_m"] is None


def test_without_ground_truth_no_error_is_told(sequence):
    (sequence / "groundtruth.txt").unlink()
    outcome = run_slam(asked(sequence, runs=1))
    assert outcome.summary["ate_rmse"] is None
    assert outcome.summary["tracked"] == 1.0
    assert "no groundtruth.txt" in outcome.text


def test_ground_truth_of_another_clock_is_refused_with_both_times(sequence):
    stamps, Ts_world_cam = read_trajectory(sequence / "groundtruth.txt")
    write_trajectory(sequence / "groundtruth.txt", stamps + 1000.0, Ts_world_cam)
    with pytest.raises(ConfigError, match=r"1000\.000 to 1002\.200 s.* 0\.000 to 2\.200 s"):
        run_slam(asked(sequence, runs=1))
    write_trajectory(sequence / "groundtruth.txt", stamps[:0], Ts_world_cam[:0])
    with pytest.raises(ConfigError, match="0 of the 12 frames"):
        run_slam(asked(sequence, runs=1))


def test_how_many_frames_are_scored_is_told(sequence):
    stamps, Ts_world_cam = read_trajectory(sequence / "groundtruth.txt")
    write_trajectory(sequence / "groundtruth.txt", stamps[::-1][:4], Ts_world_cam[::-1][:4])
    outcome = run_slam(asked(sequence, runs=1))
    assert [row["scored"] for row in outcome.rows] == [4] * len(outcome.rows)
    assert outcome.summary["scored"] == 4
    assert outcome.summary["ate_rmse"] < 0.01
    assert "have depth" not in outcome.text


@pytest.mark.parametrize("depth", [0, 65535])
def test_that_a_recording_has_no_depth_is_told(sequence, depth):
    for path in (sequence / "rgb").glob("*d.png"):
        cv2.imwrite(str(path), np.full((CAMERA.height, CAMERA.width), depth, np.uint16))
    assert "Only 0.0% of the pixels have depth" in run_slam(asked(sequence, runs=1)).text


def frame(stamp):
    nothing = np.zeros((CAMERA.height, CAMERA.width), np.float32)
    return RGBDFrame(stamp, np.zeros((*nothing.shape, 3), np.uint8), nothing, CAMERA,
                     ImuSamples.none())  # fmt: skip


class Sleepy:
    """An estimator that loses every third frame."""

    def __init__(self):
        self.seen = 0

    def track(self, frame):
        self.seen += 1
        lost = self.seen % 3 == 0
        return (None, False) if lost else (planar(float(self.seen), 0.0, 0.0), True)

    def finish(self):
        return np.full((self.seen, 4, 4), np.nan)


def test_frames_without_a_pose_are_neither_tracked_nor_scored():
    tracked = track_sequence((frame(float(i)) for i in range(9)), Sleepy())
    reference = np.arange(9.0), np.array([planar(i + 1.0, 0.0, 0.0) for i in range(9)])
    row = sequence_scores._row("sleepy", tracked, reference)
    assert row["tracked"] == pytest.approx(6 / 9)
    assert row["scored"] == 6
    assert row["ate_rmse"] == pytest.approx(0.0, abs=1e-9)
    assert row["ate_rmse_final"] is None


def test_a_motion_that_is_not_found_is_no_motion_and_not_tracked():
    answers = iter([planar(0.1, 0.0, 0.0), None, planar(0.2, 0.0, 0.0)])
    chain = FrameToFrame(lambda frame: frame, lambda before, now: next(answers))
    found = [chain.track(frame(float(i))) for i in range(4)]
    assert [matched for _, matched in found] == [True, True, False, True]
    assert [T[0, 3] for T, _ in found] == pytest.approx([0.0, 0.1, 0.1, 0.3])
    assert chain.finish()[-1, 0, 3] == pytest.approx(0.3)


def test_feature_odometry_finds_no_motion_without_depth_or_texture(sequence):
    textured = next(asked(sequence).frames())
    blank = np.zeros_like(textured.rgb)
    for rgb, depth in ((textured.rgb, 0 * textured.depth), (blank, textured.depth)):
        still = replace(textured, rgb=rgb, depth=depth)
        chain = feature_odometry(CAMERA)
        assert chain.track(still)[1] and not chain.track(still)[1]


@pytest.mark.parametrize(
    ("found", "ahead", "taken"), [(True, 0.1, True), (False, 0.1, False), (True, 2.0, False)]
)
def test_open3d_s_motion_is_taken_unless_it_is_wild(sequence, monkeypatch, found, ahead, taken):
    kinds = SimpleNamespace(
        OdometryOption=lambda **_: None,
        RGBDOdometryJacobianFromHybridTerm=lambda: None,
        compute_rgbd_odometry=lambda *_: (found, planar(ahead, 0.0, 0.0), None),
    )
    frames = SimpleNamespace(create_from_color_and_depth=lambda *_, **__: None)
    package = SimpleNamespace(
        camera=SimpleNamespace(PinholeCameraIntrinsic=lambda *_: None),
        pipelines=SimpleNamespace(odometry=kinds),
        geometry=SimpleNamespace(RGBDImage=frames, Image=lambda image: image),
    )
    monkeypatch.setattr(frame_to_frame.importlib.util, "find_spec", lambda name: name)
    monkeypatch.setitem(sys.modules, "open3d", package)
    chain = frame_to_frame.open3d_odometry(CAMERA)
    frame = next(asked(sequence).frames())
    assert chain.track(frame)[1] and chain.track(frame)[1] is taken
    assert chain.finish()[-1, 0, 3] == pytest.approx(ahead if taken else 0.0)


def test_orb_slam3_is_told_the_rate_of_the_frames(sequence, monkeypatch):
    rates = []

    def refused(intrinsics, rate, vocabulary):
        rates.append(rate)
        raise ConfigError("no ORB-SLAM3 here")

    monkeypatch.setattr(slam, "OrbSlam3", refused)
    with pytest.raises(ConfigError, match="no ORB-SLAM3"):
        run_slam(asked(sequence, vocabulary=sequence / "ORBvoc.txt"))
    assert rates == [pytest.approx(5.0)]


def test_orb_slam3_is_asked_for_by_a_vocabulary_and_must_be_installed(sequence, monkeypatch):
    monkeypatch.setattr(slam_peers.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(ConfigError, match="pip install pyorbslam3"):
        run_slam(asked(sequence, vocabulary=sequence / "ORBvoc.txt"))


@pytest.mark.parametrize("content", [b"", b"\x1f\x8b\x08\x00", b"# words\n", b"10 6 0\n1 2"])
def test_a_file_that_is_no_vocabulary_is_refused_before_orb_slam3_ends_the_program(
    tmp_path, monkeypatch, content
):
    monkeypatch.setattr(slam_peers.importlib.util, "find_spec", lambda name: object())
    path = tmp_path / "ORBvoc.txt"
    path.write_bytes(content)
    with pytest.raises(ConfigError, match=r"ORBvoc\.txt is none of ORB-SLAM3"):
        slam_peers.OrbSlam3(CAMERA, 30.0, path)


def test_every_path_is_drawn_in_its_own_colour_over_the_first():
    stamps = np.arange(20.0)
    square = np.array([planar(np.cos(a), np.sin(a), 0.0) for a in stamps / 3])
    larger = square.copy()
    larger[:, :2, 3] *= 1.1
    png = draw_paths([Path2D("truth", stamps, square), Path2D("other", stamps, larger)])
    picture = cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_COLOR)
    below_legend = picture[80:].reshape(-1, 3).tolist()
    assert below_legend.count([46, 40, 40]) > 500
    assert below_legend.count([35, 40, 215]) > 500


def test_a_camera_that_sees_no_floor_is_taken_to_be_held_at_a_metre_and_a_half():
    nothing = frame(0.0)
    T_map_cam, _ = slam_peers.VizbotEstimator(nothing, SlamConfig()).track(nothing)
    assert T_map_cam[2, 3] == pytest.approx(1.5)


def test_orb_slam3_gets_the_camera_and_says_where_it_has_a_pose(tmp_path, monkeypatch):
    asked = []

    class Slam:
        def __init__(self, vocabulary, settings, sensor):
            asked.append((vocabulary, settings.read_text(), sensor))

        def track_rgbd(self, rgb, depth, stamp):
            return SimpleNamespace(pose_wc=stamp * np.eye(4), pose_valid=stamp > 1.0)

        def shutdown(self):
            asked.append("shutdown")

        def save_trajectory_tum(self, path):
            write_trajectory(Path(path), np.array([2.0]), planar(3.0, 0.0, 0.0)[None])

    module = SimpleNamespace(Slam=Slam, Sensor=SimpleNamespace(RGBD="rgbd"))
    monkeypatch.setitem(sys.modules, "pyorbslam3", module)
    monkeypatch.setattr(slam_peers.importlib.util, "find_spec", lambda name: object())
    vocabulary = tmp_path / "ORBvoc.txt"
    vocabulary.write_text("10 6 0 0\n")
    camera = Intrinsics(160, 120, 150.0, 151.0, 79.5, 59.5)
    with slam_peers.OrbSlam3(camera, 4.6, vocabulary) as estimator:
        lost, found = (estimator.track(frame(stamp)) for stamp in (1.0, 2.0))
        final = estimator.finish()
    assert lost == (None, False)
    np.testing.assert_array_equal(found[0], 2.0 * np.eye(4))
    assert found[1]
    assert np.isnan(final[0]).all() and final[1, 0, 3] == pytest.approx(3.0)
    assert asked[0][0] == vocabulary and asked[0][2] == "rgbd" and asked[-1] == "shutdown"
    for line in ("Camera1.fx: 150.0", "Camera1.fy: 151.0", "Camera1.cx: 79.5", "Camera1.cy: 59.5",
                 "Camera.width: 160", "Camera.height: 120", "Camera.fps: 5"):  # fmt: skip
        assert line in asked[0][1].splitlines()


@pytest.mark.parametrize("kind", ["a pipe", "a device", "a large file"])
def test_a_trajectory_that_is_no_small_file_is_one_line(tmp_path, kind):
    path = tmp_path / "groundtruth.txt"
    if kind == "a pipe":
        os.mkfifo(path)
    elif kind == "a device":
        path.symlink_to("/dev/zero")
    else:
        with path.open("wb") as file:
            file.truncate(40 << 30)
    with pytest.raises(ConfigError, match="not readable as a TUM trajectory"):
        read_trajectory(path)
