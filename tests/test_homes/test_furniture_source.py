import re
import zipfile
from collections import Counter

import cv2
import numpy as np
import pytest

from sim_stubs.homes.furniture.appearance import appearance
from sim_stubs.homes.furniture.catalogue import CLASSES, instances, load_model, read_catalogue
from sim_stubs.homes.furniture.procedural import SHAPES
from sim_stubs.homes.furniture.source import (
    CEILING,
    HANGING,
    SHARED_PICTURES,
    furniture_source,
    split,
)
from sim_stubs.homes.geometry.solids import triangles
from vizbot.core.errors import ConfigError

MODEL = """\
id#{i}=Test#{id}
name#{i}={name}
category#{i}=Living room
model#{i}=/box/{material}.obj
width#{i}=40
depth#{i}=80
height#{i}=160
elevation#{i}={elevation}
creator#{i}=Nobody
"""
PAPER = cv2.imencode(".png", np.full((4, 4, 3), (51, 102, 204), np.uint8))[1].tobytes()


@pytest.fixture
def catalogue(tmp_path, monkeypatch):
    """Makes a library of models (id, name, colour, elevation [cm]) of boxes."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))

    def make(*models):
        with zipfile.ZipFile(tmp_path / "test.sh3f", "w") as archive:
            text = "id=Test\nlicense=CC0\n"
            for i, (id, name, colour, elevation) in enumerate(models, start=1):
                text += MODEL.format(i=i, id=id, name=name, material=colour, elevation=elevation)
            archive.writestr("PluginFurnitureCatalog.properties", text)
            archive.writestr("box/paper.png", PAPER)
            for colour, kd in (
                ("grey", "0.5 0.5 0.5"),
                ("yellow", "0.9 0.8 0.1"),
                ("papered", "1 1 1\nmap_Kd paper.png"),
            ):
                archive.writestr(f"box/{colour}.mtl", f"newmtl m\nKd {kd}\n")
                corners = "\n".join(
                    f"v {x} {y} {z}" for z in (0, 1) for y in (0, 1) for x in (0, 1)
                )
                faces = "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6"
                faces = re.sub(r"(\d)", r"\1/\1", faces)
                texcoords = "\n".join(f"vt {i % 2} {i // 2 % 2}" for i in range(8))
                archive.writestr(
                    f"box/{colour}.obj",
                    f"mtllib {colour}.mtl\n{corners}\n{texcoords}\nusemtl m\n{faces}\n",
                )
        return read_catalogue(tmp_path)

    return make


def textures(pieces):
    return {part.texture for piece in pieces for part in piece.parts} - {None}


def drawn(source, label, count=30, seed=0):
    rng = np.random.default_rng(seed)
    return [source(label, rng) for _ in range(count)]


def test_about_half_of_the_training_pieces_are_shapes_of_our_own(catalogue):
    entries = catalogue(*[(f"c{i}", "Chair", "grey", 0) for i in range(10)])
    pieces = drawn(furniture_source(entries, held_out=False), "chair", 60)
    assert 18 < sum(piece.attribution == "" for piece in pieces) < 42


def test_a_model_is_drawn_on_one_side_only(catalogue):
    entries = catalogue(*[(f"c{i}", "Chair", "grey", 0) for i in range(6)])
    for held_out, side in enumerate(split(entries)):
        pieces = drawn(furniture_source(entries, bool(held_out)), "chair", 40)
        models = {
            piece.attribution.split("#")[1].split(")")[0] for piece in pieces if piece.attribution
        }
        assert models == {entry.id.split("#")[1] for entry in side}
        assert not held_out or all(piece.attribution for piece in pieces)


def test_a_single_model_is_held_out_and_shapes_train(catalogue):
    entries = catalogue(("piano", "Upright piano", "grey", 0))
    assert drawn(furniture_source(entries, held_out=True), "piano", 1)[0].attribution
    assert not any(p.attribution for p in drawn(furniture_source(entries, False), "piano", 8))


@pytest.mark.slow
def test_no_chair_is_yellow(catalogue):
    models = [(f"c{i}", "Chair", "yellow" if i % 2 else "grey", 0) for i in range(20)]
    for held_out in (False, True):
        pieces = drawn(furniture_source(catalogue(*models), held_out), "chair", 40)
        assert "yellow" not in Counter(c for piece in pieces for c in appearance(piece).colours)


def test_when_all_chairs_are_yellow_that_is_said(catalogue):
    entries = catalogue(("c1", "Chair", "yellow", 0), ("c2", "Chair", "yellow", 0))
    with pytest.raises(ConfigError, match="yellow"):
        furniture_source(entries, held_out=True)("chair", np.random.default_rng(0))


def test_a_hung_washbasin_comes_with_the_gap_below_it_and_a_wall_cabinet_without(catalogue):
    entries = catalogue(("s", "Washbasin", "grey", 45), ("w", "Upper cabinet", "grey", 145))
    source = furniture_source(entries, held_out=True)
    for label, low in (("sink", 0.45), ("wall cabinet", 0.0)):
        piece = source(label, np.random.default_rng(0))
        heights = triangles(piece.parts)[..., 2]
        assert heights.min() == pytest.approx(low, abs=1e-5)
        assert heights.max() == pytest.approx(piece.size[2], abs=1e-5)


def test_without_a_catalogue_both_sides_draw_shapes_and_never_the_same_ones():
    sides = []
    for held_out in (False, True):
        pieces = drawn(furniture_source((), held_out), "vase", 12)
        sides.append({triangles(piece.parts).tobytes() for piece in pieces})
    assert not sides[0] & sides[1]


@pytest.mark.parametrize(
    "label", ["bed", "carpet", "kitchen cabinet", "laundry basket", "picture", "shelf", "tv"]
)
def test_shapes_of_the_two_sides_share_no_texture(label):
    sides = [textures(drawn(furniture_source((), held_out), label, 16)) for held_out in (0, 1)]
    assert sides[0] and sides[1]
    assert not sides[0] & sides[1]


def test_a_held_out_model_does_not_show_the_picture_of_a_training_one(catalogue, monkeypatch):
    entries = catalogue(("c1", "Chair", "papered", 0), ("c2", "Chair", "papered", 0))
    training, held_out = split(entries)
    assert textures(drawn(furniture_source(entries, True), "chair", 1))
    monkeypatch.setitem(SHARED_PICTURES, held_out[0].id, training[0].id)
    (piece,) = drawn(furniture_source(entries, True), "chair", 1)
    (part,) = piece.parts
    assert part.texture is None
    assert part.rgba == pytest.approx([0.8, 0.4, 0.2, 1.0], abs=0.01)


@pytest.mark.long
@pytest.mark.skipif(not read_catalogue(), reason="Debian's sweethome3d-furniture is not installed")
def test_no_picture_is_on_furniture_of_both_sides():
    training, held_out = split(read_catalogue())
    trained_on = textures(
        load_model(entry, label) for label in CLASSES for entry in instances(label, training)
    )
    source = furniture_source(read_catalogue(), held_out=True)
    judged_by = textures(
        piece
        for label in CLASSES
        if label != "high chair"  # its one held-out model is yellow, so that none is drawn
        for piece in drawn(source, label, 3 * len(instances(label, held_out)))
    )
    assert len(trained_on) > 50 and len(judged_by) > 30
    assert not trained_on & judged_by


def test_an_unknown_label_is_named():
    with pytest.raises(ConfigError, match="unicorn"):
        furniture_source((), held_out=False)("unicorn", np.random.default_rng(0))


def test_every_class_has_a_shape_and_what_hangs_is_a_class():
    assert {*CLASSES} <= {*SHAPES}
    assert {*HANGING, *CEILING} <= {*SHAPES}
