from math import pi

import cv2
import numpy as np
import pytest

from sim_stubs.homes.geometry.occupancy_slice import FreeSpace
from sim_stubs.homes.geometry.solids import triangles
from sim_stubs.world import mjcf
from sim_stubs.world.body import WorldConfig
from sim_stubs.world.mjcf import read_mjcf
from sim_stubs.world.world import World
from sim_stubs.world.world_file import read_world
from sim_stubs.world.world_name import open_world
from tests.helpers.failing import raising
from vizbot.core.errors import ConfigError

TETRAHEDRON = """
v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
vt 0 0
vt 1 0
vt 0 1
f 1/1 3/3 2/2
f 1/1 2/2 4/3
f 1/1 4/3 3/2
f 2/1 3/2 4/3
"""
WORLD = """
<mujoco>
  <asset>
    <texture name="tiles" type="2d" builtin="checker" rgb1="1 0 0" rgb2="0 0 1"
             width="64" height="64"/>
    <material name="tiled" texture="tiles" texrepeat="2 2" texuniform="true"/>
    <mesh name="tetrahedron" file="tetrahedron.obj"/>
  </asset>
  <worldbody>
    <geom type="plane" size="0 0 1" material="tiled"/>
    <geom type="box" size="0.1 3 1.2" pos="3 0 1.2" rgba="0 1 0 1"/>
    <geom type="box" size="9 9 9" group="3"/>
    <light pos="1 1 2.2" type="spot"/>
    <site name="start" pos="-1 -2 0" euler="0 0 90"/>
    <site name="room:living room" type="box" pos="1 0 1" size="2 3 1"/>
    <body name="stool#1" pos="1 2 0.4" euler="0 0 30">
      <geom type="cylinder" size="0.2 0.02" pos="0.5 0 0" rgba="1 1 0 1"/>
      <body name="legs" pos="0.5 0 -0.2">
        <geom type="capsule" size="0.02 0.18"/>
        <body name="cup#1" pos="0 0 0.23"><geom type="sphere" size="0.05"/></body>
      </body>
    </body>
    <body name="sculpture#a" pos="-2 2 0">
      <geom type="mesh" mesh="tetrahedron" material="tiled"/>
      <geom type="ellipsoid" size="0.1 0.2 0.3" pos="0 0 2"/>
    </body>
  </worldbody>
</mujoco>
"""


@pytest.fixture
def write(tmp_path):
    (tmp_path / "tetrahedron.obj").write_text(TETRAHEDRON)

    def written(text):
        path = tmp_path / "world.xml"
        path.write_text(text)
        return path

    return written


@pytest.fixture
def house(write):
    return read_mjcf(write(WORLD))


def test_a_body_with_a_label_and_a_number_is_an_instance_and_others_are_structure(house):
    instances = {instance.name: instance for instance in house.instances}
    assert set(instances) == {"stool#1", "cup#1", "sculpture#a"}
    assert instances["stool#1"].label == "stool"
    assert triangles(house.structure)[..., 2].max() == pytest.approx(2.4)


def test_an_instance_stands_where_its_geoms_are_with_the_heading_of_its_body(house):
    stool = next(instance for instance in house.instances if instance.name == "stool#1")
    assert stool.yaw == pytest.approx(pi / 6)
    assert (stool.x, stool.y) == pytest.approx((1 + 0.5 * np.cos(pi / 6), 2.25), abs=2e-3)
    assert stool.elevation == pytest.approx(0.0, abs=1e-3)
    assert stool.piece.size == pytest.approx([0.4, 0.4, 0.42], abs=5e-3)
    world = triangles(stool.parts())
    assert world[..., 2].max() == pytest.approx(0.42, abs=1e-3)


def test_a_mesh_keeps_its_shape_texture_and_texture_coordinates(house):
    sculpture = next(i for i in house.instances if i.label == "sculpture")
    textured = [part for part in sculpture.parts() if part.texture is not None]
    assert len(textured) == 1
    corners = triangles(textured)
    assert corners.min(axis=(0, 1)) == pytest.approx([-2, 2, 0], abs=1e-5)
    assert corners.max(axis=(0, 1)) == pytest.approx([-1, 3, 1], abs=1e-5)
    assert np.ptp(textured[0].texcoords, axis=0) == pytest.approx([2, 2])
    assert (cv2.imread(str(textured[0].texture))[0, 0] == (0, 0, 255)).all()


def test_geoms_that_are_there_to_collide_are_left_out(house):
    assert triangles(house.parts())[..., 2].max() < 3.0


def test_sites_say_where_the_robot_and_the_rooms_are(house):
    assert house.start == pytest.approx((-1, -2, pi / 2))
    (room,) = house.rooms
    assert room.name == "living room"
    assert room.contains(2.9, 2.9) and not room.contains(3.1, 0)
    assert house.lights == pytest.approx(np.array([[1, 1, 2.2]]))


def test_the_robot_sees_and_drives_in_it(house):
    space = FreeSpace.from_house(house)
    assert space.reached(*house.start[:2]).sum() * space.grid.resolution**2 > 10
    with World(house, WorldConfig()) as world:
        world.place(-2, 0.8, pi / 2)
        rgb, depth = world.render()
        assert depth[300, 320] > 0.3
        names = {world.instances[i].name for i in np.unique(world.segment()) if i >= 0}
    assert "sculpture#a" in names
    assert rgb.std() > 10


@pytest.mark.slow
def test_the_robot_starts_at_its_site_whatever_it_is_asked_for(write):
    with open_world(str(write(WORLD)), WorldConfig(), text="stool") as world:
        assert world.T_world_base[:2, 3] == pytest.approx([-1, -2])
        assert world.notice == ""


def test_a_world_without_rooms_is_seen_from_above_as_far_as_it_reaches(write):
    room = '<site name="room:living room" type="box" pos="1 0 1" size="2 3 1"/>'
    with World(read_mjcf(write(WORLD.replace(room, ""))), WorldConfig()) as world:
        assert world.house.rooms == ()
        assert world.top_view().std() > 10


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (WORLD.replace("</mujoco>", ""), "cannot be loaded"),
        (WORLD.replace("tetrahedron.obj", "elsewhere.obj"), "elsewhere.obj"),
        (WORLD.replace('name="start"', 'name="begin"'), "a site named start"),
        ('<mujoco><worldbody><site name="start"/></worldbody></mujoco>', "shows nothing"),
    ],
)
def test_a_file_that_is_no_world_is_told_in_one_line(write, text, message):
    with pytest.raises(ConfigError, match=message) as refusal:
        read_mjcf(write(text))
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    "more",
    [
        '<geom type="box" size="1e30 1 1"/>',
        '<geom type="box" size="1 1 1e30"/>',
        '<geom type="sphere" size="1e200"/>',
        '<geom type="plane" size="1000 1000 1"/>',
        '<geom type="capsule" size="0.1 1000" euler="0 90 0"/>',
        '<geom type="mesh" mesh="tetrahedron" pos="1e308 0 0"/>',
        '<body name="sofa#1" pos="-2000 0 0"><geom type="box" size="1 1 1"/></body>',
        '<site name="room:hall" type="box" size="1e30 1 1"/>',
    ],
)
def test_a_world_larger_than_any_home_is_refused_before_it_is_made(write, monkeypatch, more):
    monkeypatch.setattr(mjcf, "_parts", raising(AssertionError("shapes were made")))
    with pytest.raises(ConfigError, match=r"world .*world\.xml: it is .* m wide, of 100 m at most"):
        read_mjcf(write(WORLD.replace("</worldbody>", more + "</worldbody>")))


def test_what_is_not_shown_may_be_as_large_as_it_likes(write):
    more = (
        '<geom type="box" size="1e30 1 1" group="4"/>'
        '<geom type="box" size="1e30 1 1" rgba="1 1 1 0"/>'
    )
    house = read_mjcf(write(WORLD.replace("</worldbody>", more + "</worldbody>")))
    assert np.ptp(triangles(house.parts()), axis=(0, 1)).max() < 20.0


def test_a_file_that_is_missing_is_told_in_one_line(tmp_path):
    with pytest.raises(ConfigError, match="is not there"):
        read_world(tmp_path / "nowhere.xml")


@pytest.mark.parametrize("light", ["", '<light type="directional"/>'])
def test_a_world_without_lamps_gets_one_every_4_m(write, light):
    house = read_mjcf(write(WORLD.replace('<light pos="1 1 2.2" type="spot"/>', light)))
    low, high = (f(triangles(house.parts()), axis=(0, 1))[:2] for f in (np.min, np.max))
    assert (house.lights[:, 2] == 2.3).all()
    places = np.random.default_rng(0).uniform(low, high, (100, 2))
    to_lamps = np.abs(places[:, None] - house.lights[:, :2]).max(axis=2).min(axis=1)
    assert 1.0 < to_lamps.max() < 3.0
    assert len(house.lights) < 10


def test_beside_a_sun_a_lamp_of_the_file_is_one_of_many(write):
    both = '<light pos="1 1 2.2" type="spot"/><light type="directional"/>'
    house = read_mjcf(write(WORLD.replace('<light pos="1 1 2.2" type="spot"/>', both)))
    assert house.lights[0] == pytest.approx([1, 1, 2.2])
    assert len(house.lights) > 2


OTHERS = """
<mujoco>
  <asset>
    <texture name="wood" type="cube" builtin="flat" rgb1="0.6 0.4 0.2" rgb2="0.6 0.4 0.2"
             width="8" height="48"/>
    <material name="wooden" texture="wood"/>
  </asset>
  <worldbody>
    <geom name="floor" type="plane" size="3 3 1" pos="0 0 -0.9" rgba="0.8 0.8 0.8 1"/>
    <geom name="ghost" type="box" size="1 1 1" pos="0 -2 0" rgba="1 0 0 0"/>
    <geom name="wall" type="box" size="0.1 3 1" pos="-3 0 0" rgba="0 1 0 1"/>
    <body name="bench top" pos="1 0 -0.5" euler="0 0 90">
      <geom name="board" type="box" size="0.6 0.3 0.4" material="wooden"/>
      <body name="pot" pos="0 0 0.5"><geom type="box" size="0.1 0.1 0.1" rgba="1 1 0 1"/></body>
    </body>
    <body name="hidden"><geom type="sphere" size="0.1" group="3"/></body>
    <site name="mark" pos="0 0 0"/>
  </worldbody>
</mujoco>
"""
LABELS = """
"bench top" = "Work  Bench"
pot = "yellow flower pot"
wall = "green wall"
"""
START = (-1.0, 1.0, 0.5)


@pytest.fixture
def labelled(write, tmp_path):
    """Reads a scene with the labels in a text."""

    def read(labels=LABELS, scene=OTHERS, start=START):
        path = tmp_path / "labels.toml"
        path.write_text(labels)
        return open_world(str(write(scene)), WorldConfig(), labels=path, start=start)

    return read


@pytest.mark.slow
def test_bodies_and_geoms_of_a_scene_by_others_are_what_the_labels_say(labelled):
    with labelled() as world:
        things = {it.name: it for it in world.instances}
        assert {name: it.label for name, it in things.items()} == {
            "bench top": "work bench",
            "pot": "yellow flower pot",
            "wall": "green wall",
        }
        assert things["bench top"].yaw == pytest.approx(pi / 2)
        assert things["bench top"].piece.size == pytest.approx([1.2, 0.6, 0.8])
        assert things["pot"].piece.size == pytest.approx([0.2, 0.2, 0.2])
        assert things["wall"].yaw == 0.0


@pytest.mark.slow
def test_the_floor_of_a_scene_by_others_is_at_zero_wherever_it_was(labelled):
    with labelled() as world:
        assert {it.name: it.elevation for it in world.instances} == pytest.approx(
            {"bench top": 0.0, "pot": 0.8, "wall": -0.1}, abs=1e-6
        )
        assert world.contacts.cliffs == (False,) * 4
        assert world.T_world_base[:2, 3] == pytest.approx(START[:2])


@pytest.mark.slow
def test_what_is_transparent_is_left_out_and_a_cube_s_texture_gives_its_colour(labelled):
    with labelled() as world:
        x, y, z = triangles(world.house.structure).reshape(-1, 3).T
        assert not ((np.abs(x) < 1.1) & (np.abs(y + 2) < 0.9) & (z > 0.1)).any()  # of "ghost"
        bench = next(it for it in world.instances if it.name == "bench top")
        assert bench.piece.parts[0].rgba == pytest.approx([0.6, 0.4, 0.2, 1.0], abs=0.01)


@pytest.mark.slow
def test_a_scene_ends_at_a_wall(labelled):
    with labelled() as world:
        for yaw, distance in ((0.0, 4.0), (pi / 2, 2.0), (-pi / 2, 4.0)):
            world.place(-1.0, 1.0, yaw)
            depth = world.render()[1][:, 320]
            assert (depth > 0.0).all()
            assert depth[240] == pytest.approx(distance - 0.05, abs=0.1)
        world.place(2.8, 2.0, 0.0)
        for _ in range(200):
            world.set_wheel_speeds(0.2, 0.2)
            world.advance(0.015)
        assert world.contacts.bump_left and world.contacts.bump_right
        assert world.contacts.cliffs == (False,) * 4
        assert world.T_world_base[0, 3] == pytest.approx(3.0 - 0.175, abs=0.02)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("labels", "message"),
    [
        ('bench = "table"', "no body or geom 'bench'.*bench top"),
        ('hidden = "ball"', "'hidden'.*shows nothing"),
        ('pot = " "', "' ' of 'pot' is no text"),
        ("pot = 3", "3 of 'pot' is no text"),
        ("[pot]", "{} of 'pot' is no text"),
        ("pot", "cannot be read"),
        ("pot = " + 900 * "[" + 900 * "]", "cannot be read"),
        ("pot = 1" + 5000 * "0", "cannot be read"),
    ],
)
def test_labels_that_cannot_be_used_are_told_in_one_line(labelled, labels, message):
    with pytest.raises(ConfigError, match=message) as refusal:
        labelled(labels)
    assert "\n" not in str(refusal.value)


@pytest.mark.slow
def test_labels_are_for_files_that_have_none_and_must_be_there(write, tmp_path):
    with pytest.raises(ConfigError, match="an MJCF or SDF file, not for world '1100'"):
        open_world("1100", WorldConfig(), labels=tmp_path / "labels.toml")
    with pytest.raises(ConfigError, match=r"labels\.toml cannot be read"):
        open_world(str(write(OTHERS)), WorldConfig(), labels=tmp_path / "labels.toml", start=START)


@pytest.mark.slow
@pytest.mark.parametrize("place", [(1.0, 0.45), (1.0, 0.0), (7.0, 0.0), (2.95, 0.0)])
def test_a_start_beside_inside_or_beyond_everything_is_refused_with_a_place_nearby(labelled, place):
    with pytest.raises(ConfigError, match="the nearest free place is") as refusal:
        labelled(start=(*place, 0.0))
    x, y = map(float, str(refusal.value).rpartition(" is ")[2].split(","))
    with labelled(start=(x, y, 0.0)) as world:
        assert world.contacts.cliffs == (False,) * 4


@pytest.mark.slow
def test_a_scene_without_room_for_the_robot_is_told(labelled):
    with pytest.raises(ConfigError, match="the robot fits nowhere"):
        raised = OTHERS.replace('pos="1 0 -0.5"', 'pos="1 0 0.5"')
        labelled(scene=raised.replace('size="3 3 1"', 'size="0.1 0.1 1"'))


@pytest.mark.slow
def test_a_start_that_is_given_goes_before_the_site_and_the_goal(write):
    path = str(write(WORLD))
    for start in ((1.0, -1.0, 0.3), (-2.0, -1.0, 0.0)):
        with open_world(path, WorldConfig(), text="stool", start=start) as world:
            assert world.T_world_base[:2, 3] == pytest.approx(start[:2])
