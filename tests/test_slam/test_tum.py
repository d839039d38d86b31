from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mapping.tum import read_trajectory, write_trajectory
from vizbot.core.errors import ConfigError


@given(seed=st.integers(0, 10_000), count=st.integers(0, 5))
def test_a_trajectory_survives_the_round_trip(
    tmp_path_factory: pytest.TempPathFactory, seed: int, count: int
) -> None:
    rng = np.random.default_rng(seed)
    Ts_map_cam = np.tile(np.eye(4), (count, 1, 1))
    for T in Ts_map_cam:
        T[:3, :3] = Rotation.random(random_state=rng).as_matrix()
        T[:3, 3] = rng.normal(0, 10, 3)
    stamps = np.sort(rng.uniform(0, 1e9, count))
    path = tmp_path_factory.mktemp("tum") / "trajectory.tum"
    write_trajectory(path, stamps, Ts_map_cam)
    stamps_read, Ts_map_cam_read = read_trajectory(path)
    assert Ts_map_cam_read.shape == (count, 4, 4)
    assert np.allclose(stamps_read, stamps, rtol=0, atol=1e-6)
    assert np.allclose(Ts_map_cam_read, Ts_map_cam, atol=1e-5)


@pytest.mark.parametrize(
    ("position", "line"),
    [
        ((1, 2, 3), "0.500000 1.000000 2.000000 3.000000 0.000000 0.000000 0.000000 1.000000"),
        ((-1e-9,) * 3, "0.500000 0.000000 0.000000 0.000000 0.000000 0.000000 0.000000 1.000000"),
    ],
    ids=["w last", "noughts without a sign"],
)
def test_a_line_is_stamp_position_and_quaternion(tmp_path: Path, position, line) -> None:
    T = np.eye(4)
    T[:3, 3] = position
    path = tmp_path / "trajectory.tum"
    write_trajectory(path, np.array([0.5]), T[None])
    assert path.read_text().splitlines()[-1] == line


@pytest.mark.parametrize(
    "line",
    ["1 2 3", "1 2 3 4 5 6 7 x", "1 0 0 0 0 0 0 0", "1 nan 0 0 0 0 0 1", "1 0 0 0 0 0 0 1 9",
     "1e308 0 0 0 0 0 0 1", "1 1e308 0 0 0 0 0 1", "1 0 -1e9 0 0 0 0 1", "1 0 0 0 0 0 1e308 1e308",
     "1 0 0 0 0 0 inf 1"],
)  # fmt: skip
def test_a_malformed_line_is_named_with_its_file(tmp_path: Path, line: str) -> None:
    path = tmp_path / "broken.tum"
    path.write_text(f"# comment\n\n0 0 0 0 0 0 0 1\n{line}\n")
    with pytest.raises(ConfigError, match=r"broken\.tum, line 4"):
        read_trajectory(path)


def test_a_missing_trajectory_is_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"nowhere\.tum"):
        read_trajectory(tmp_path / "nowhere.tum")


def test_poses_are_read_in_the_order_of_their_stamps(tmp_path: Path) -> None:
    path = tmp_path / "halves.tum"
    path.write_text("".join(f"{t} {t} 0 0 0 0 0 1\n" for t in (3, 4, 1, 2)))
    stamps, Ts_map_cam = read_trajectory(path)
    assert stamps.tolist() == [1, 2, 3, 4]
    assert Ts_map_cam[:, 0, 3].tolist() == [1, 2, 3, 4]


WHOLE = "# timestamp tx ty tz qx qy qz qw\n1.0 1 2 3 0 0 0 1\n"


@pytest.mark.parametrize("torn", ["2", "2.0 1 2 3 0 0", "2.0 1 2 3 0 0 0.6 0.", "2.0 1 2 3 0 0 -"])
def test_a_last_line_that_a_killed_run_has_torn_is_left_out(tmp_path, torn):
    path = tmp_path / "trajectory.tum"
    path.write_text(WHOLE + torn)
    assert read_trajectory(path)[0].tolist() == [1.0]
    for wrong in (WHOLE + torn + "\n", torn):  # not torn, or all that there is
        path.write_text(wrong)
        if len(torn.split()) != 8:
            with pytest.raises(ConfigError, match="is not a pose"):
                read_trajectory(path)


def test_a_last_line_without_an_end_that_is_whole_counts(tmp_path):
    path = tmp_path / "trajectory.tum"
    path.write_text(WHOLE + "2.0 1 2 3 0 0 0.6 0.8")
    assert read_trajectory(path)[0].tolist() == [1.0, 2.0]
