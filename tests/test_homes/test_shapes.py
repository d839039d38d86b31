import cv2
import numpy as np
import pytest

from sim_stubs.homes.furniture.paint import painted_plain
from sim_stubs.homes.furniture.procedural import SHAPES, piece
from sim_stubs.homes.furniture.shapes.curved_solids import ellipse, prism, rod, turned
from sim_stubs.homes.geometry.solids import (
    box,
    by_material,
    cushion,
    cylinder,
    flat_panel,
    joined,
    moved_part,
    triangles,
)
from vizbot.core.errors import ConfigError
from vizbot.core.geometry import planar

GREY = (0.5, 0.5, 0.5)


def facing_and_middles(part):
    corners = triangles([part])
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    solid = np.linalg.norm(normals, axis=1) > 1e-9
    return normals[solid], corners[solid].mean(axis=1)


@pytest.mark.parametrize(
    "solid",
    [
        box((0, 0, 0), (0.4, 0.6, 0.8), GREY),
        cylinder((0, 0, 0), 0.3, 0.8, GREY, 0.2),
        cushion((0, 0, 0), (0.4, 0.6, 0.8), GREY),
    ],
    ids=["box", "cylinder", "cushion"],
)
def test_solids_stand_on_their_centre_and_face_outwards(solid):
    assert solid.vertices[:, 2].min() == pytest.approx(0.0, abs=1e-6)
    assert solid.vertices[:, 2].max() == pytest.approx(0.8, abs=1e-6)
    normals, middles = facing_and_middles(solid)
    assert ((normals * (middles - (0, 0, 0.4))).sum(axis=1) > 0).all()
    shading = solid.normals[solid.faces].mean(axis=1)
    corners = triangles([solid])
    faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert ((faces * shading).sum(axis=1) >= -1e-9).all()


def test_a_box_has_the_area_of_its_size():
    normals, _ = facing_and_middles(box((1, 2, 3), (0.4, 0.6, 0.8), GREY))
    area = np.linalg.norm(normals, axis=1).sum() / 2
    assert area == pytest.approx(2 * (0.4 * 0.6 + 0.4 * 0.8 + 0.6 * 0.8), rel=1e-5)


def test_a_panel_is_seen_from_where_along_times_up_points():
    part = flat_panel((0, 0, 0), (2, 0, 0), (0, 0, 1), GREY)
    assert part.normals == pytest.approx(np.tile([0, -1, 0], (len(part.normals), 1)))


def test_joining_keeps_every_triangle_and_materials_stay_apart():
    red, blue = box((0, 0, 0), (1, 1, 1), (1, 0, 0)), box((2, 0, 0), (1, 1, 1), (0, 0, 1))
    turned = moved_part(red, planar(0, 5, 1.0))
    parts = by_material([red, blue, turned])
    assert len(parts) == 2
    assert triangles([parts[0]]) == pytest.approx(triangles([red, turned]))
    assert triangles([joined([red, turned])]) == pytest.approx(triangles([red, turned]))


@pytest.mark.parametrize("label", sorted(SHAPES))
def test_every_piece_is_centred_on_the_floor_and_as_large_as_it_says(label):
    model = piece(label, np.random.default_rng(3))
    corners = triangles(model.parts).reshape(-1, 3)
    low, high = corners.min(axis=0), corners.max(axis=0)
    assert high - low == pytest.approx(model.size, abs=1e-5)
    assert (low + high)[:2] == pytest.approx([0, 0], abs=1e-5)
    assert low[2] == pytest.approx(0, abs=2e-3)
    assert 0.15 < model.size.max() < 4.2
    for part in model.parts:
        assert np.linalg.norm(part.normals, axis=1) == pytest.approx(1.0, abs=1e-3)
        assert part.faces.max() < len(part.vertices)
        assert part.texture is None or cv2.imread(str(part.texture)) is not None


def test_the_same_seed_draws_the_same_piece():
    first, second = (piece("plant", np.random.default_rng(8)) for _ in range(2))
    assert np.array_equal(triangles(first.parts), triangles(second.parts))


def test_a_recoloured_piece_has_one_plain_colour_and_its_shape():
    chair = piece("chair", np.random.default_rng(0))
    yellow = painted_plain(chair, "yellow chair", (0.9, 0.8, 0.0))
    assert yellow.label == "yellow chair"
    (part,) = yellow.parts
    assert part.texture is None
    assert part.rgba == pytest.approx([0.9, 0.8, 0.0, 1.0])
    assert len(part.faces) == sum(len(p.faces) for p in chair.parts)


def test_an_unknown_shape_names_the_known_ones():
    with pytest.raises(ConfigError, match=r"no shape for 'unicorn'.*chair"):
        piece("unicorn", np.random.default_rng(0))


@pytest.mark.parametrize("label", sorted(SHAPES))
def test_shapes_are_light_and_of_many_looks(label):
    pieces = [piece(label, np.random.default_rng(seed)) for seed in range(2)]
    assert len({triangles(it.parts).tobytes() for it in pieces}) == 2
    assert all(sum(len(part.faces) for part in it.parts) <= 3000 for it in pieces)


def test_the_name_of_a_shape_tells_its_material():
    names = {piece("sofa", np.random.default_rng(seed)).name for seed in range(20)}
    assert names == {"leather sofa", "fabric sofa"}


@pytest.mark.parametrize(
    "solid",
    [
        turned([(0, 0), (0.3, 0.1), (0.2, 0.5), (0, 0.5)], GREY),
        prism(ellipse(1.0, 0.5), 0.0, 0.3, GREY),
        rod((0, 0, 1), (0, 0, 0), 0.1, GREY),
        rod((0, 0, 0), (1, 1, 1), 0.1, GREY),
    ],
    ids=["turned", "prism", "falling rod", "slanting rod"],
)
def test_round_solids_face_outwards(solid):
    normals, middles = facing_and_middles(solid)
    assert ((normals * (middles - middles.mean(axis=0))).sum(axis=1) > 0).all()


def test_a_rod_goes_from_point_to_point():
    corners = triangles([rod((0, 0, 0), (0, 2, 0), 0.1, GREY)]).reshape(-1, 3)
    assert corners.min(axis=0) == pytest.approx([-0.1, 0, -0.1], abs=1e-5)
    assert corners.max(axis=0) == pytest.approx([0.1, 2, 0.1], abs=1e-5)
