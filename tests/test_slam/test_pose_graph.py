import numpy as np
import pytest

from mapping.keyframes.config import PoseGraphConfig
from mapping.keyframes.pose_graph import PoseGraph, pose_noise
from vizbot.core.geometry import camera_mount, invert, planar, rotation_angle, transform, yaw_of
from vizbot.core.types import SE3

T_BASE_CAM = camera_mount(height=0.8, forward=0.1, tilt=0.2)
EXACT = np.diag([1e-6] * 6)


def square(steps: int = 10) -> list[SE3]:
    """T_map_base along a square of 2 m, `steps` keyframes a side, back at the start."""
    poses = [np.eye(4)]
    for _ in range(4):
        for _ in range(steps):
            poses.append(poses[-1] @ planar(2.0 / steps, 0, 0))
        poses[-1] = poses[-1] @ planar(0, 0, np.pi / 2)
    return poses


def begun() -> PoseGraph:
    """A graph of the first keyframe."""
    graph = PoseGraph(T_BASE_CAM, PoseGraphConfig())
    graph.add_keyframe(0, T_BASE_CAM, fixed=True)
    return graph


def by_wheels(truth: list[SE3], turn: float) -> PoseGraph:
    """Keyframes chained by wheels that turn `turn` [rad] too far at each step."""
    T_map_base, graph = np.eye(4), begun()
    for i in range(1, len(truth)):
        step = invert(truth[i - 1]) @ truth[i] @ planar(0, 0, turn)
        T_map_base = T_map_base @ step
        graph.add_keyframe(i, T_map_base @ T_BASE_CAM)
        graph.add_wheel_motion(i - 1, i, step)
    return graph


def test_noise_is_rotation_first_then_translation() -> None:
    assert np.allclose(pose_noise(0.1, (1, 2, 3)).sigmas(), [0.1, 0.1, 0.1, 1, 2, 3])


def test_a_closed_loop_takes_out_the_drift_of_wheels() -> None:
    truth = square()
    graph = by_wheels(truth, turn=0.01)
    last = len(truth) - 1
    drifted = graph.update()[last]
    T_first_last = invert(truth[0] @ T_BASE_CAM) @ truth[last] @ T_BASE_CAM
    graph.add_image_motion(0, last, T_first_last, EXACT)
    closed = graph.update()
    true = [T_map_base @ T_BASE_CAM for T_map_base in truth]
    assert np.linalg.norm((drifted - true[last])[:3, 3]) > 0.3
    assert max(np.linalg.norm((closed[i] - true[i])[:3, 3]) for i in closed) < 0.15
    assert np.linalg.norm((closed[last] - true[last])[:3, 3]) < 0.02


def test_the_gyroscope_takes_out_the_turns_of_wheels_that_slip() -> None:
    truth = square()
    T_first_last = invert(truth[0] @ T_BASE_CAM) @ truth[-1] @ T_BASE_CAM
    errors = []
    for gyro in (False, True):
        graph = by_wheels(truth, turn=0.01)
        for i in range(1, len(truth)):
            if gyro:
                # It knows the turn alone; what else it is told counts for nothing.
                T_before_now = invert(truth[i - 1]) @ truth[i]
                graph.add_gyro_turn(i - 1, i, planar(0.5, -0.3, yaw_of(T_before_now)), 0.001)
        last = graph.update()[len(truth) - 1]
        errors.append(np.linalg.norm((last - truth[0] @ T_BASE_CAM @ T_first_last)[:3, 3]))
    assert errors[0] > 0.3 and errors[1] < 0.05


def by_images(truth: list[SE3], graph: PoseGraph, i: int) -> None:
    """What images show of the way to keyframe `i`, from each of the three before it."""
    for j in range(max(0, i - 3), i):
        T_j_i = invert(truth[j] @ T_BASE_CAM) @ truth[i] @ T_BASE_CAM
        graph.add_image_motion(j, i, T_j_i, EXACT)


def test_images_outvote_a_gyroscope_that_is_wrong_once() -> None:
    truth = [planar(0.2 * i, 0.0, 0.0) for i in range(12)]
    graph = by_wheels(truth, turn=0.0)
    for i in range(1, len(truth)):
        T_before_now = invert(truth[i - 1]) @ truth[i]
        T_by_gyro = T_before_now @ planar(0, 0, 0.09 if i == 6 else 0.0)
        graph.add_gyro_turn(i - 1, i, T_by_gyro, 0.001)
        by_images(truth, graph, i)
    last = graph.update()[len(truth) - 1]
    assert rotation_angle(invert(truth[-1] @ T_BASE_CAM) @ last) < 0.01


FINE, MISSING, LIES = "fine", "missing", "lies"


def end_errors(images: str, wheels: str, gyro: str) -> tuple[float, float]:
    """Error [m] and [rad] at the end of a lap in whose second quarter sensors fail.

    Wheels that lie count a fifth too much, a gyroscope that lies turns by 0.1 rad too much from
    keyframe to keyframe.
    """
    rng = np.random.default_rng(4)
    truth, graph = square(), begun()
    T_guess = np.eye(4)
    for i in range(1, len(truth)):
        failing = len(truth) // 4 < i < len(truth) // 2
        step = invert(truth[i - 1]) @ truth[i] @ planar(*rng.normal(0.0, 0.005, 3))
        if failing and wheels == LIES:
            step = planar(*(1.2 * step[:2, 3]), 1.2 * yaw_of(step))
        T_guess = T_guess @ step
        graph.add_keyframe(i, T_guess @ T_BASE_CAM)
        graph.add_floor(i, T_guess @ T_BASE_CAM)
        if not (failing and images == MISSING):
            by_images(truth, graph, i)
        if not (failing and wheels == MISSING):
            graph.add_wheel_motion(i - 1, i, step)
        if not (failing and gyro == MISSING):
            error = 0.1 if failing and gyro == LIES else rng.normal(0.0, 0.001)
            turn = yaw_of(invert(truth[i - 1]) @ truth[i]) + error
            graph.add_gyro_turn(i - 1, i, planar(0.0, 0.0, turn), 0.002)
        last = graph.update()[i]
    off = invert(truth[-1] @ T_BASE_CAM) @ last
    return float(np.linalg.norm(off[:3, 3])), rotation_angle(off)


@pytest.mark.parametrize("wheels", [FINE, MISSING, LIES])
@pytest.mark.parametrize("gyro", [FINE, MISSING, LIES])
def test_images_hold_the_pose_whatever_wheels_and_gyroscope_say(wheels: str, gyro: str) -> None:
    distance, angle = end_errors(FINE, wheels, gyro)
    assert distance < 0.01 and angle < 0.003


@pytest.mark.parametrize(
    ("wheels", "gyro", "furthest", "most"),
    [(FINE, FINE, 0.05, 0.01), (FINE, MISSING, 0.1, 0.04), (LIES, FINE, 0.5, 0.01)],
)
def test_where_images_show_nothing_wheels_tell_the_way_and_the_gyroscope_the_turn(
    wheels: str, gyro: str, furthest: float, most: float
) -> None:
    distance, angle = end_errors(MISSING, wheels, gyro)
    assert distance < furthest and angle < most


def around_the_square() -> tuple[PoseGraph, list[SE3]]:
    """Linked from keyframe to keyframe, with the true T_map_cam."""
    truth = square()
    graph = by_wheels(truth, turn=0.0)
    true = [T_map_base @ T_BASE_CAM for T_map_base in truth]
    for i in range(1, len(truth)):
        graph.add_image_motion(i - 1, i, invert(true[i - 1]) @ true[i], EXACT)
    return graph, true


def test_one_wrong_closure_among_good_links_hardly_moves_the_graph() -> None:
    graph, true = around_the_square()
    graph.update()
    graph.add_image_motion(0, 20, np.eye(4), EXACT)
    poses = graph.update()
    assert max(np.linalg.norm((poses[i] - true[i])[:3, 3]) for i in poses) < 0.3


@pytest.mark.parametrize("aside", [0.2, 0.5, 2.0])
def test_a_closure_that_the_graph_contradicts_is_opened_again(aside: float) -> None:
    graph, true = around_the_square()
    graph.add_image_motion(0, 10, invert(true[0]) @ true[10], EXACT, closes=True)
    before = graph.update()
    wrong = invert(true[2]) @ planar(aside, 0.0, 0.0) @ true[12]
    graph.add_image_motion(2, 12, wrong, EXACT, closes=True)
    poses = graph.update()
    assert graph.closures == [(0, 10)]
    assert all(np.allclose(poses[i], before[i], atol=1e-3) for i in poses)


def spun_and_gone_on(spun: float, behind: int) -> PoseGraph:
    """Wheels that tell of a way on which the robot stood, and keyframes that images link to it."""
    graph = begun()
    for i in range(1, behind + 2):
        T_map_cam = planar(spun + 0.25 * (i - 1), 0, 0) @ T_BASE_CAM
        graph.add_keyframe(i, T_map_cam)
        graph.add_floor(i, T_map_cam)
        if i == 1:
            graph.add_wheel_motion(0, 1, planar(spun, 0, 0), np.array([spun, 0.0]))
        else:
            step = planar(0.25, 0, 0)
            graph.add_wheel_motion(i - 1, i, step)
            T_step = invert(T_BASE_CAM) @ step @ T_BASE_CAM
            graph.add_image_motion(i - 1, i, T_step, EXACT)
        graph.update()
    return graph


@pytest.mark.parametrize("behind", [0, 1, 3])
@pytest.mark.parametrize("spun", [0.5, 2.0, 5.0])
def test_wheels_that_are_doubted_give_way_to_a_closed_loop_however_far_they_spun(
    spun: float, behind: int
) -> None:
    graph = spun_and_gone_on(spun, behind)
    last = behind + 1
    T_back = invert(T_BASE_CAM) @ planar(0.25 * behind, 0, 0) @ T_BASE_CAM
    graph.add_image_motion(
        0, last, T_back, EXACT, closes=True, wheel_slack=(1, np.array([spun, 0.1]))
    )
    assert np.linalg.norm((graph.update()[1] - T_BASE_CAM)[:3, 3]) < 0.02
    assert graph.closures == [(0, last)]


def test_a_loop_that_proves_wrong_leaves_no_trace_though_wheels_gave_way_to_it() -> None:
    graph = spun_and_gone_on(3.0, 3)
    before = graph.update()
    for i in (0, 1):
        graph.add_image_motion(i, 4, invert(before[i]) @ before[4], EXACT, closes=True)
    graph.update()
    graph.add_image_motion(
        0, 3, np.eye(4), EXACT, closes=True, wheel_slack=(1, np.array([3.0, 0.1]))
    )
    after = graph.update()
    assert graph.closures == [(0, 4), (1, 4)]
    assert all(np.allclose(after[i], before[i], atol=0.02) for i in before)


def test_factors_count_once_however_often_the_graph_is_solved() -> None:
    graph = by_wheels([planar(0.1 * i, 0, 0) for i in range(5)], turn=0.02)
    first = graph.update()
    for _ in range(5):
        again = graph.update()
    assert all(np.allclose(first[i], again[i], atol=1e-6) for i in first)
    graph.add_image_motion(0, 4, invert(T_BASE_CAM) @ planar(0.4, 0, 0) @ T_BASE_CAM, EXACT)
    for _ in range(5):
        graph.update()
    assert rotation_angle(graph.update()[4] @ invert(T_BASE_CAM)) < 0.02


def test_wheels_that_spun_give_way_to_images() -> None:
    graph = begun()
    graph.add_keyframe(1, T_BASE_CAM)
    graph.add_wheel_motion(0, 1, planar(0.5, 0, 0))
    graph.add_image_motion(0, 1, np.eye(4), EXACT)
    assert np.linalg.norm((graph.update()[1] - T_BASE_CAM)[:3, 3]) < 0.02


@pytest.mark.parametrize("yaw", [0.0, 2.5, -3.1])
def test_the_floor_holds_height_and_tilt_and_leaves_place_and_heading(yaw: float) -> None:
    graph = begun()
    lifted = planar(1.0, 2.0, yaw) @ camera_mount(0.05, 0.0, 0.03) @ invert(camera_mount(0, 0, 0))
    graph.add_keyframe(1, lifted @ T_BASE_CAM)
    T_cam_cam = invert(T_BASE_CAM) @ lifted @ T_BASE_CAM
    graph.add_image_motion(0, 1, T_cam_cam, np.diag([0.1**2] * 3 + [0.2**2] * 3))
    graph.add_floor(1, lifted @ T_BASE_CAM)
    T_map_base = graph.update()[1] @ invert(T_BASE_CAM)
    up = transform(T_map_base, np.array([0.0, 0.0, 1.0])) - T_map_base[:3, 3]
    assert abs(T_map_base[2, 3]) < 0.01
    assert np.linalg.norm(up[:2]) < 0.005
    assert np.allclose(T_map_base[:2, 3], [1.0, 2.0], atol=0.05)
    assert np.arctan2(T_map_base[1, 0], T_map_base[0, 0]) == pytest.approx(yaw, abs=0.01)


def test_the_covariance_of_images_is_of_the_camera_not_of_the_base() -> None:
    """Of two measurements of one motion, the one that is sure of an axis wins there."""
    graph = begun()
    graph.add_keyframe(1, T_BASE_CAM)
    ahead, aside = np.eye(4), np.eye(4)
    ahead[2, 3], aside[0, 3] = 0.1, 0.1
    sure_of_z = np.diag([1e-6] * 3 + [0.5**2, 0.5**2, 1e-6])
    sure_of_x = np.diag([1e-6] * 3 + [1e-6, 0.5**2, 0.5**2])
    graph.add_image_motion(0, 1, ahead, sure_of_z)
    graph.add_image_motion(0, 1, aside, sure_of_x)
    T_0_1 = invert(T_BASE_CAM) @ graph.update()[1]
    assert np.allclose(T_0_1[[0, 2], 3], [0.1, 0.1], atol=0.01)
