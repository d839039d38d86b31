"""Gazebo's worlds: what they show, what it is called, and what cannot be read."""

import struct
from math import pi

import cv2
import numpy as np
import pytest

from sim_stubs.homes.geometry.solids import triangles
from sim_stubs.world.sdf import label_of, read_sdf
from sim_stubs.world.world_file import read_world
from vizbot.core.errors import ConfigError

SQUARE = """<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="centimeter" meter="0.01"/><up_axis>Y_UP</up_axis></asset>
<library_images><image id="picture"><init_from>/home/author/red.png</init_from></image>
</library_images>
<library_effects><effect id="look"><profile_COMMON>
<newparam sid="surface"><surface type="2D"><init_from>picture</init_from></surface></newparam>
<newparam sid="sampler"><sampler2D><source>surface</source></sampler2D></newparam>
<technique sid="common"><lambert><diffuse><texture texture="sampler" texcoord="uv"/></diffuse>
</lambert></technique></profile_COMMON></effect></library_effects>
<library_materials><material id="red"><instance_effect url="#look"/></material></library_materials>
<library_geometries><geometry id="square"><mesh>
<source id="points"><float_array id="p" count="12">0 0 0 100 0 0 100 0 50 0 0 50</float_array>
<technique_common><accessor source="#p" count="4" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<source id="coordinates"><float_array id="c" count="8">0 0 1 0 1 1 0 1</float_array>
<technique_common><accessor source="#c" count="4" stride="2"><param name="S" type="float"/>
<param name="T" type="float"/></accessor></technique_common></source>
<vertices id="corners"><input semantic="POSITION" source="#points"/></vertices>
<polylist material="symbol" count="1"><input semantic="VERTEX" source="#corners" offset="0"/>
<input semantic="TEXCOORD" source="#coordinates" offset="1"/><vcount>4</vcount>
<p>0 0 1 1 2 2 3 3</p></polylist></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="scene"><node id="node"><translate>0 10 0</translate>
<instance_geometry url="#square"><bind_material><technique_common>
<instance_material symbol="symbol" target="#red"/></technique_common></bind_material>
</instance_geometry></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#scene"/></scene></COLLADA>"""
BOX = "<visual name='v'>{more}<geometry><box><size>{size}</size></box></geometry></visual>"
SEAT = BOX.format(more="<pose>0 0 0.4 0 0 0</pose>", size="0.4 0.4 0.8")
LEAF = BOX.format(more="<pose>0.5 0 1 0 0 0</pose>", size="1 0.05 2")
FLOOR = BOX.format(more="<pose>0 0 -0.05 0 0 0</pose>", size="{} 4 0.1")
MESH = "<link name='body'><visual name='v'><geometry><mesh><uri>{}</uri>{}</mesh></geometry>{}"
MESH += "</visual></link>"
WORLD = f"""<sdf version="1.6"><world name="home">
<light type="point" name="lamp"><pose>1 1 2.5 0 0 0</pose></light>
<model name="floor_Living_room"><link name="l">{FLOOR.format(6)}</link></model>
<model name="floor_Kitchen"><pose>5 0 0 0 0 0</pose><link name="l">{FLOOR.format(4)}</link></model>
<model name="wall_1"><link name="l"><pose>-3 0 1 0 0 0</pose>
{BOX.format(more="", size="0.1 4 2")}<collision name="c"><geometry><box><size>9 9 9</size></box>
</geometry></collision></link></model>
<include><uri>model://tv</uri><name>TV_01_002</name><pose>1 0 1 0 0 1.5707963</pose></include>
<model name="door_a"><include><uri>model://leaf</uri></include></model>
<model name="ChairA_01_001"><pose>2 1 0 0 0 0</pose><link name="l">{SEAT}</link></model>
<model name="fin"><pose>-2 -1 0 0 0 0</pose>{MESH.format("fin.stl", "<scale>1 1 2</scale>", "")}
</model>
<state><model name="door_a"><link name="leaf::hinge"><pose>0 1 0 0 0 1.5707963</pose></link></model>
</state></world></sdf>"""


@pytest.fixture
def write(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    pictures = tmp_path / "models/tv/materials/textures"
    pictures.mkdir(parents=True)
    (tmp_path / "models/tv/meshes").mkdir()
    (tmp_path / "worlds").mkdir()
    (tmp_path / "models/leaf").mkdir()
    cv2.imwrite(str(pictures / "red.png"), np.full((4, 4, 3), (0, 0, 255), np.uint8))
    (tmp_path / "models/tv/meshes/square.dae").write_text(SQUARE)
    (tmp_path / "models/tv/tv.sdf").write_text(
        f"<sdf><model name='tv'>{MESH.format('model://tv/meshes/square.dae', '', '')}</model></sdf>"
    )
    (tmp_path / "models/tv/model.config").write_text("<model><sdf>tv.sdf</sdf></model>")
    (tmp_path / "models/leaf/model.sdf").write_text(
        f"<sdf><model name='leaf'><link name='hinge'>{LEAF}</link></model></sdf>"
    )
    corners = (0, 0, 0, 1, 0, 0, 0, 0, 1)
    facet = struct.pack("<12fH", 0, 0, 0, *corners, 0)
    (tmp_path / "worlds/fin.stl").write_bytes(bytes(80) + struct.pack("<I", 1) + facet)

    def written(text):
        path = tmp_path / "worlds/home.world"
        path.write_text(text)
        return path

    return written


def bounds(parts):
    corners = triangles(parts).reshape(-1, 3)
    return corners.min(axis=0), corners.max(axis=0)


def test_models_are_where_the_world_or_its_state_puts_them(write):
    house = read_sdf(write(WORLD))
    things = {thing.name: thing for thing in house.instances}
    assert set(things) == {"tv#1", "door#1", "chair#1"}
    low, high = bounds(things["chair#1"].parts())
    assert (*low, *high) == pytest.approx((1.8, 0.8, 0, 2.2, 1.2, 0.8), abs=1e-5)
    low, high = bounds(things["door#1"].parts())
    assert (*low, *high) == pytest.approx((-0.025, 1, 0, 0.025, 2, 2), abs=1e-5)
    low, high = bounds(house.structure)
    assert high[2] == pytest.approx(2.4)  # the plain wall around it: what collides is not shown
    assert house.lights == pytest.approx(np.array([[1, 1, 2.5]]))


def test_a_mesh_has_its_unit_its_picture_and_the_pose_of_its_model(write):
    (tv,) = (thing for thing in read_sdf(write(WORLD)).instances if thing.label == "tv")
    assert tv.yaw == pytest.approx(pi / 2, abs=1e-6)
    low, high = bounds(tv.parts())
    assert (*low, *high) == pytest.approx((0.9, 0, 1, 0.9, 1, 1.5), abs=1e-5)
    (part,) = tv.parts()
    assert (cv2.imread(str(part.texture)) == (0, 0, 255)).all()
    upper = part.vertices[:, 2] > 1.4
    assert part.texcoords[upper, 1] == pytest.approx(0.0)
    assert part.texcoords[~upper, 1] == pytest.approx(1.0)


def test_a_mesh_takes_the_scale_and_the_colour_of_the_world(write):
    coloured = "<material><diffuse>0 0 1 1</diffuse></material>"
    own = MESH.format("fin.stl", "<scale>1 1 2</scale>", "")
    given = MESH.format("fin.stl", "<scale>1 1 2</scale>", coloured)
    house = read_sdf(write(WORLD.replace(own, given)))
    (fin,) = (part for part in house.structure if tuple(part.rgba) == (0, 0, 1, 1))
    low, high = bounds([fin])
    assert (*low, *high) == pytest.approx((-2, -1, 0, -1, -1, 2), abs=1e-5)


def test_floors_are_rooms_and_the_robot_starts_where_they_are_widest(write):
    house = read_sdf(write(WORLD))
    assert [room.name for room in house.rooms] == ["living room", "kitchen"]
    assert house.rooms[1].polygon.min(axis=0) == pytest.approx((3, -2), abs=0.03)
    assert house.rooms[1].polygon.max(axis=0) == pytest.approx((7, 2), abs=0.03)
    assert house.room_at(*house.start[:2]) is not None
    assert read_sdf(write(WORLD), start=(1.0, -1.0, 0.5)).start == (1.0, -1.0, 0.5)


def test_a_ground_plane_is_a_floor_as_wide_as_what_stands_on_it(write):
    plane = "<visual name='v'><geometry><plane><normal>0 0 1</normal><size>1000 1000</size></plane>"
    plane = f"<model name='ground'><link name='l'>{plane}</geometry></visual></link></model>"
    bare = WORLD.replace("floor_", "ground_").replace(FLOOR.format(6), "")
    low, high = bounds(read_sdf(write(bare.replace("<state>", f"{plane}<state>"))).structure)
    assert (*low, *high) == pytest.approx((-3.15, -2.1, -0.1, 7.1, 2.1, 2.4), abs=1e-5)


@pytest.mark.parametrize(
    ("name", "label"),
    [
        ("Bed_01_001", "bed"),
        ("aws_robomaker_residential_KitchenTable_01", "dining table"),
        ("HomeOfficeDeskChairs_Oaed1cbd04270_lod0_4", "office chair"),
        ("DishWasher_f2d1aeaead9b_lod0", "dishwasher"),
        ("LivingRoomChairs_Obc13_lod0", "chair"),
        ("floor_lamp", "floor lamp"),
        ("tv", "tv"),
        ("VanityBenches", "bench"),
        ("door-Main_bedroom-Hallway", "door"),
        ("unit_box_0", None),
        ("floor_Living_room", None),
        ("doorway_wall_34", None),
        ("3bed4", None),
        ("", None),
    ],
)
def test_a_model_is_what_the_last_words_of_its_name_say(name, label):
    assert label_of(name) == label


def test_labels_call_models_otherwise(write, tmp_path):
    labels = tmp_path / "labels.toml"
    labels.write_text('fin = "yellow ladder"')
    house = read_sdf(write(WORLD), labels)
    assert "yellow ladder" in {thing.label for thing in house.instances}
    labels.write_text('fan = "ladder"')
    with pytest.raises(ConfigError, match=r"has no model 'fan'; take one that it has, as fin"):
        read_sdf(write(WORLD), labels)


BOMB = '<!DOCTYPE a [<!ENTITY a0 "lol">{}]>'.format(
    "".join(f'<!ENTITY a{i + 1} "{f"&a{i};" * 50}">' for i in range(8))
)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("</world>", "", "home.world cannot be read"),
        ("world", "land", "has no <world>"),
        ("model://tv", "model://tw", "'model://tw' of <include> is not found; add"),
        ("model://tv", "https://fuel.gazebosim.org/tv", "is not found"),
        ("fin.stl", "fin.fbx", "'fin.fbx' of <mesh> is not found"),
        ("fin.stl", "home.world", "home.world is no .dae, .stl or .obj; convert it"),
        ("fin.stl", "torn.stl", "torn.stl cannot be read"),
        ("fin.stl", "torn.dae", "torn.dae cannot be read"),
        ("fin.stl", "empty.dae", "empty.dae has no triangles"),
        ("2 1 0 0 0 0", "2 1 0 0 0", "pose of model 'ChairA_01_001' has 5 numbers, not 6"),
        ("2 1 0 0 0 0", "2 1 0 0 0 north", "'north'"),
        ("2 1 0 0 0 0", "2 1e9 0 0 0 0", "m wide, of 100 m at most"),
        ("0.4 0.4 0.8", "0.4 1e9 0.8", "m wide, of 100 m at most"),
        ("0.4 0.4 0.8", "0.4 nan 0.8", "nan m wide"),
        ("<pose>2 1", "<pose relative_to='wall_1'>2 1", "a frame of its own, 'wall_1'"),
        ("0 0 -0.05 0 0 0", "0 0 -1 0 0 0", "no free floor at z = 0"),
    ],
)
def test_a_world_that_cannot_be_used_is_one_line(write, tmp_path, old, new, words):
    (tmp_path / "worlds/torn.stl").write_bytes(b"solid")
    (tmp_path / "worlds/torn.dae").write_text(SQUARE[:900])
    (tmp_path / "worlds/empty.dae").write_text(SQUARE.replace("instance_geometry", "extra"))
    text = WORLD.replace(old, new)
    assert text != WORLD
    with pytest.raises(ConfigError) as refusal:
        read_sdf(write(text))
    assert "\n" not in str(refusal.value) and words in str(refusal.value)


def test_a_world_without_visuals_is_refused(write):
    with pytest.raises(ConfigError, match="shows nothing; give one with visuals"):
        read_sdf(write('<sdf><world name="empty"/></sdf>'))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('<sdf version="1.6">', f'{BOMB}<sdf version="&a8;">'),
        ("<include>", "<include><uri>model://loop</uri></include><include>"),
    ],
)
def test_a_bomb_or_a_model_that_includes_itself_is_one_line(write, tmp_path, old, new):
    loop = "<sdf><model name='m'><include><uri>model://loop</uri></include></model></sdf>"
    (tmp_path / "models/loop").mkdir()
    (tmp_path / "models/loop/model.sdf").write_text(loop)
    with pytest.raises(ConfigError, match=r"^world .*home\.world.* cannot be read .*$"):
        read_world(write(WORLD.replace(old, new)))
