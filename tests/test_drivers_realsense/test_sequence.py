"""Sequences in the layout of the TUM RGB-D benchmark."""

import json
import re
from codecs import BOM_UTF8

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.tum_sequence import RecordedSequence, parse_intrinsics
from tests.helpers.checkout import OFFICE_WALK
from vizbot.core.errors import ConfigError
from vizbot.core.types import Intrinsics

CAMERA = {
    "width": 40,
    "height": 30,
    "fx": 35.0,
    "fy": 36.0,
    "cx": 19.5,
    "cy": 14.5,
    "depth_scale": 5000,
    "timestamps": "any other key",
}


def colour(index):
    image = np.full((30, 40, 3), 10 * index, np.uint8)
    image[:10, :10] = 255, 0, 0
    return image


def raw_depth(index):
    image = np.full((30, 40), 5000 + 500 * index, np.uint16)
    image[0, 0] = 0
    return image


def write_images(folder, stamps):
    for kind in ("rgb", "depth"):
        (folder / kind).mkdir(parents=True)
    for index, stamp in enumerate(stamps):
        cv2.imwrite(str(folder / f"rgb/{stamp}.png"), colour(index)[..., ::-1])
        cv2.imwrite(str(folder / f"depth/{stamp}.png"), raw_depth(index))


@pytest.fixture
def folder(tmp_path):
    folder = tmp_path / "office"
    stamps = ("1.0", "1.5", "2.0")
    write_images(folder, stamps)
    rows = [f"{stamp} rgb/{stamp}.png {stamp} depth/{stamp}.png\n" for stamp in stamps]
    (folder / "associations.txt").write_text("# colour, depth\n\n" + "".join(rows))
    (folder / "camera.json").write_text(json.dumps(CAMERA))
    return folder


def stamps_of(folder):
    with RecordedSequence(folder) as camera:
        stamps = []
        while (frame := camera.read()) is not None:
            stamps.append(frame.stamp)
    return stamps


def refusal(folder, *arguments):
    with pytest.raises(ConfigError) as error:
        camera = RecordedSequence(folder, *arguments)
        while camera.read() is not None:
            pass
    assert "\n" not in str(error.value)
    return str(error.value)


def test_frames_come_in_order_and_then_none(folder):
    with RecordedSequence(folder) as camera:
        assert len(camera) == 3
        for index, stamp in enumerate((1.0, 1.5, 2.0)):
            frame = camera.read()
            assert frame.stamp == stamp
            np.testing.assert_array_equal(frame.rgb, colour(index))
            assert frame.depth.dtype == np.float32
            np.testing.assert_allclose(frame.depth, raw_depth(index) / 5000.0, rtol=1e-6)
            assert len(frame.imu.gyro) == 0
        assert camera.read() is None
        assert camera.read() is None


def test_the_calibration_comes_from_camera_json(folder):
    with RecordedSequence(folder) as camera:
        assert camera.intrinsics == Intrinsics(40, 30, 35.0, 36.0, 19.5, 14.5)
        assert camera.read().intrinsics == camera.intrinsics


@pytest.mark.parametrize("with_file", [True, False])
def test_a_given_calibration_goes_before_camera_json_and_needs_none(folder, with_file):
    if not with_file:
        (folder / "camera.json").unlink()
    with RecordedSequence(folder, *parse_intrinsics("30,31,19,14,1000")) as camera:
        assert camera.intrinsics == Intrinsics(40, 30, 30.0, 31.0, 19.0, 14.0)
        assert camera.read().depth[5, 5] == pytest.approx(5.0)


def test_without_a_calibration_both_remedies_are_named(folder):
    (folder / "camera.json").unlink()
    message = refusal(folder)
    assert "camera.json" in message
    assert "--intrinsics" in message


@pytest.mark.parametrize(
    "text",
    ["{", "[]", json.dumps(CAMERA | {"fx": 0}), json.dumps(CAMERA | {"depth_scale": "big"}),
     json.dumps(CAMERA | {"cx": float("nan")}), json.dumps({"width": 40}), "\xff"],
)  # fmt: skip
def test_a_camera_json_that_is_wrong_is_named(folder, text):
    (folder / "camera.json").write_bytes(text.encode("latin-1"))
    assert "camera.json" in refusal(folder)


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("fx", 1e7, "fx"),
        ("fx", 1e308, "fx"),
        ("fy", 1e-300, "fy"),
        ("cx", 1e30, "cx"),
        ("cy", -1e30, "cy"),
        ("depth_scale", 1e-300, "depth_scale"),
        ("depth_scale", 1e300, "depth_scale"),
        ("width", 10**400, "width"),
        ("no_depth", 65536, "no_depth: .* not '65536'"),
        ("no_depth", 0.5, "no_depth: .* not '0.5'"),
        ("distortion", [0.2, 0.0, 0.0, 0.0, float("nan")], "distortion.4"),
        ("distortion", [9.0, 0, 0, 0, 0], r"\[9.0, .* shifts a pixel by 8\d.* at most"),
        ("distortion", [1e308, -1e308, 1e308, 0, 1e308], "shifts a pixel by (nan|inf)"),
    ],
)
def test_a_calibration_that_no_camera_has_is_refused_with_its_value(folder, key, value, said):
    (folder / "camera.json").write_text(json.dumps(CAMERA | {key: value}))
    message = refusal(folder)
    assert re.search(said, message) and "--intrinsics" in message
    assert len(message) < 600


def test_a_given_calibration_that_no_camera_has_is_refused_with_its_value(folder):
    given = parse_intrinsics("1e7,36,19.5,14.5,5000")
    assert "fx [px] is 1e+07, a camera's is 2 to 2000" in refusal(folder, *given)


@pytest.mark.parametrize("stamp", ["1e308", "-1e308", "1e21", "inf", "nan"])
def test_a_stamp_that_no_clock_shows_is_refused(folder, stamp):
    (folder / "associations.txt").write_text(f"{stamp} rgb/1.0.png 1 depth/1.0.png\n")
    assert "at most 1e+20 s" in refusal(folder)
    write_lists(folder, "1.0 rgb/1.0.png\n", f"1.0 depth/1.0.png\n{stamp} depth/1.0.png\n")
    assert "depth.txt: line 2" in refusal(folder)


def write_lists(folder, colour, depth):
    (folder / "associations.txt").unlink(missing_ok=True)
    (folder / "rgb.txt").write_text(colour)
    (folder / "depth.txt").write_text(depth)


def test_lists_are_associated_by_the_nearest_stamp(folder):
    write_lists(
        folder,
        "# stamp file\n1.000 rgb/1.0.png\n1.500 rgb/1.5.png\n1.51 rgb/1.5.png\n2.000 rgb/2.0.png\n",
        "2.021 depth/2.0.png\n1.509 depth/1.5.png\n0.981 depth/1.0.png\n",
    )
    # 2.000 is 21 ms away from its nearest; 1.500 would be near enough but 1.51 is nearer.
    assert stamps_of(folder) == [1.0, 1.51]


def test_lists_without_a_pair_are_refused(folder):
    (folder / "associations.txt").unlink()
    (folder / "rgb.txt").write_text("1.0 rgb/1.0.png\n")
    (folder / "depth.txt").write_text("1.1 depth/1.0.png\n")
    assert "no pair" in refusal(folder)
    (folder / "depth.txt").write_text("# nothing\n")
    assert "no pair" in refusal(folder)


def test_frames_are_sorted_and_no_stamp_comes_twice(folder):
    rows = (folder / "associations.txt").read_text().splitlines()[2:]
    (folder / "associations.txt").write_text("\n".join([rows[2], rows[0], rows[1], rows[0]]))
    assert stamps_of(folder) == [1.0, 1.5, 2.0]


def test_a_folder_that_is_missing_or_of_something_else_is_named(folder, tmp_path):
    assert "nowhere: no such folder" in refusal(tmp_path / "nowhere")
    (folder / "associations.txt").unlink()
    (folder / "rgb.txt").write_text("1.0 rgb/1.0.png\n")
    assert "neither associations.txt nor rgb.txt and depth.txt" in refusal(folder)


def test_images_that_are_missing_or_of_another_size_are_refused_at_once(folder):
    (folder / "camera.json").write_text(json.dumps(CAMERA | {"width": 64}))
    with pytest.raises(ConfigError, match=r"rgb/1\.0\.png: 40x30 pixels.*64x30"):
        RecordedSequence(folder)
    (folder / "depth" / "2.0.png").unlink()
    with pytest.raises(ConfigError, match=r"depth/2\.0\.png: listed but missing"):
        RecordedSequence(folder)


@pytest.mark.parametrize(
    "row", ["1.0 rgb/1.0.png", "one rgb/1.0.png 1.0 depth/1.0.png", "nan a 1 b"]
)
def test_a_line_that_is_no_association_is_named(folder, row):
    (folder / "associations.txt").write_text(f"# first\n{row}\n")
    assert "associations.txt: line 2 is" in refusal(folder)


@pytest.mark.parametrize("content", [b"", b"not an image", None])
def test_an_image_that_does_not_decode_is_named_when_read(folder, content):
    path = folder / "rgb" / "1.5.png"
    path.write_bytes(path.read_bytes()[:60] if content is None else content)
    with RecordedSequence(folder) as camera:
        assert camera.read().stamp == 1.0
        with pytest.raises(ConfigError, match=r"rgb/1\.5\.png: does not decode"):
            camera.read()


@pytest.mark.parametrize(
    ("image", "said"),
    [
        (np.zeros((15, 20), np.uint16), "20x15 pixels"),
        (np.zeros((30, 40), np.uint8), "not 16-bit depth"),
    ],
)
def test_depth_of_another_size_or_type_is_refused(folder, image, said):
    cv2.imwrite(str(folder / "depth/1.0.png"), image)
    assert f"depth/1.0.png: {said}" in refusal(folder)


def test_colour_and_depth_in_the_wrong_order_are_refused(folder):
    (folder / "associations.txt").write_text("1.0 depth/1.0.png 1.0 rgb/1.0.png\n")
    assert "depth/1.0.png: not 8-bit colour" in refusal(folder)


@given(
    st.tuples(*[st.floats(1e-3, 1e6)] * 5),
    st.sampled_from([",", ", ", " , "]),
)
def test_intrinsics_written_as_text_come_back(values, separator):
    intrinsics, scale = parse_intrinsics(separator.join(map(repr, values)))
    assert (intrinsics.fx, intrinsics.fy, intrinsics.cx, intrinsics.cy, scale) == values


@given(st.text(max_size=30))
def test_any_other_text_is_one_line(text):
    try:
        intrinsics, scale = parse_intrinsics(text)
    except ConfigError as error:
        assert "\n" not in str(error)
    else:
        assert min(intrinsics.fx, intrinsics.fy, scale) > 0


@pytest.mark.parametrize(
    "text", ["", "1,2,3,4", "1,2,3,4,5,6", "0,1,1,1,1", "1,1,1,1,-5", "1,1,nan,1,1"]
)
def test_intrinsics_that_are_none_show_an_example(text):
    with pytest.raises(ConfigError, match="expected fx,fy,cx,cy,scale as in"):
        parse_intrinsics(text)


@pytest.mark.skipif(not OFFICE_WALK.is_dir(), reason="hololens_office is not at ../shared/data")
def test_the_hololens_office_opens():
    with RecordedSequence(OFFICE_WALK) as camera:
        frame = camera.read()
        assert len(camera) == len((OFFICE_WALK / "associations.txt").read_text().splitlines())
    assert frame.rgb.shape == (360, 540, 3)
    assert 0.5 < np.median(frame.depth[frame.depth > 0]) < 10.0


@pytest.mark.parametrize(("value", "named"), [(65535, {}), (10000, {"no_depth": 10000})])
def test_the_largest_16_bit_depth_and_the_one_for_none_are_holes(folder, value, named):
    raw = raw_depth(0)
    raw[5:9, 5:9] = value
    (folder / "camera.json").write_text(json.dumps(CAMERA | named))
    cv2.imwrite(str(folder / "depth/1.0.png"), raw)
    with RecordedSequence(folder) as camera:
        depth = camera.read().depth
    assert (depth[5:9, 5:9] == 0).all()
    assert (depth[10:] == 1.0).all()


def test_the_distortion_of_the_lens_is_taken_out_of_both_images(folder):
    # A pixel at 35, 25 has r^2 = 0.281, so that k1 = 0.2 shows it at 35.9, 25.6.
    raw, rgb = np.full((30, 40), 5000, np.uint16), np.full((30, 40, 3), 90, np.uint8)
    raw[26, 36], rgb[26, 36] = 7500, 255
    cv2.imwrite(str(folder / "depth/1.0.png"), raw)
    cv2.imwrite(str(folder / "rgb/1.0.png"), rgb)
    (folder / "camera.json").write_text(json.dumps(CAMERA | {"distortion": [0.2, 0, 0, 0, 0]}))
    with RecordedSequence(folder) as camera:
        frame = camera.read()
        assert camera.undistorted(36, 26) == (35, 25) and camera.undistorted(20, 15) == (20, 15)
    assert np.argwhere(frame.depth == 1.5).tolist() == [[25, 35]]
    assert divmod(int(frame.rgb[..., 0].argmax()), 40) == (25, 35)
    assert frame.depth[29, 39] == 0 and not frame.rgb[29, 39].any()


def test_a_byte_order_mark_before_lists_and_calibration_is_no_part_of_them(folder):
    for name in ("associations.txt", "camera.json"):
        path = folder / name
        path.write_bytes(BOM_UTF8 + path.read_bytes().lstrip(b"# colour, depth\n"))
    assert stamps_of(folder) == [1.0, 1.5, 2.0]


def test_grey_images_count_as_colour(folder):
    cv2.imwrite(str(folder / "rgb/1.0.png"), np.full((30, 40), 90, np.uint8))
    with RecordedSequence(folder) as camera:
        assert (camera.read().rgb == 90).all()
