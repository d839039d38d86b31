import os
import zipfile
from math import pi
from pathlib import Path

import cv2
import numpy as np
import pytest

from sim_stubs.homes.geometry.occupancy_slice import FreeSpace, grid_around, occupied
from sim_stubs.homes.geometry.solids import triangles
from sim_stubs.homes.sweet_home.home import read_home
from sim_stubs.homes.sweet_home.walls import Hole, Wall, WallFinish, build_walls, rounded
from sim_stubs.world.world_file import read_world
from vizbot.core.errors import ConfigError

PROGRAM = Path(os.environ.get("SWEET_HOME_JAR", "/usr/share/sweethome3d/sweethome3d.jar"))
EXAMPLES = "com/eteks/sweethome3d/io/resources/examples/"
BLOCK = """
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 0 0 1
v 1 0 1
v 1 1 1
v 0 1 1
{group}
usemtl white
f 1 4 3 2
f 1 2 6 5
f 4 8 7 3
f 1 5 8 4
f 2 3 7 6
usemtl amber
f 5 6 7 8
"""
"""A cube with an amber front."""
ARCH = """
g frame
v -1 0 0
v -1 2 0
v 1 2 0
v 1 0 0
v 0.9 0 0
v 0.9 1.9 0
v -0.9 1.9 0
v -0.9 0 0
f 1 2 3 4 5 6 7 8
f 8 7 6 5 4 3 2 1
g sweethome3d_opening_on_hinge_1
f 8 7 6 5
f 5 6 7 8
"""
"""A door of cardboard: a frame, concave, and a leaf."""
HOME = """<?xml version='1.0'?>
<home version='5500' wallHeight='250.0'>
  <property name='License' value='CC-BY'/>
  <level id='up' elevation='262.0' height='250.0' name='up'/>
  <level id='down' elevation='0.0' height='250.0' name='down'/>
  <furnitureGroup name='Set' x='0' y='0' level='down'>
    <pieceOfFurniture name='Sofa' model='3/cube.obj' x='100.0' y='200.0' angle='1.5707964'
        width='180.0' depth='80.0' height='70.0'/>
  </furnitureGroup>
  <pieceOfFurniture catalogId='eTeks#bed140x190' name='Lit' model='3/cube.obj' x='500.0' y='60.0'
      width='140.0' depth='100.0' height='50.0' color='FF0000FF' level='down'/>
  <pieceOfFurniture name='Chair' model='3/cube.obj' x='300.0' y='100.0' elevation='40.0'
      width='40.0' depth='40.0' height='90.0' modelMirrored='true' level='down'>
    <material name='amber' color='FF00FF00'/>
  </pieceOfFurniture>
  <pieceOfFurniture name='Box' model='3/cube.obj' x='340.0' y='340.0'
      width='20.0' depth='20.0' height='20.0' level='down'/>
  <pieceOfFurniture name='Vase' model='nowhere.obj' x='350.0' y='50.0'
      width='20.0' depth='20.0' height='30.0' level='down'/>
  <pieceOfFurniture name='Lamp' model='3/cube.obj' x='100' y='100' width='20' depth='20'
      height='20' level='up'/>
  <doorOrWindow catalogId='eTeks#door' name='Door' model='4/door.obj' x='400.0' y='250.0'
      angle='1.5707964' width='90.0' depth='10.0' height='205.0' level='down'/>
  <doorOrWindow catalogId='eTeks#door' name='Door' model='4/door.obj' x='0.0' y='300.0'
      angle='1.5707964' width='90.0' depth='10.0' height='205.0' level='down'/>
  <doorOrWindow catalogId='eTeks#window' name='Window' model='3/cube.obj' x='200.0' y='0.0'
      width='100.0' depth='10.0' height='120.0' elevation='90.0' level='down'/>
  <room name='Living room #1' floorColor='FFFF0000' level='down'>
    <texture attribute='floorTexture' name='tiles' image='7' width='50.0' height='50.0'/>
    <point x='5' y='5'/><point x='395' y='5'/><point x='395' y='395'/><point x='5' y='395'/>
  </room>
  <room level='down'>
    <point x='405' y='5'/><point x='405' y='395'/><point x='695' y='395'/><point x='695' y='5'/>
  </room>
  <wall id='n' wallAtStart='w' wallAtEnd='e' xStart='0' yStart='0' xEnd='700' yEnd='0'
      height='250' thickness='10' level='down'>
    <baseboard attribute='rightSideBaseboard' thickness='1.0' height='7.0' color='FF00FF00'/>
  </wall>
  <wall id='e' wallAtStart='n' wallAtEnd='s' xStart='700' yStart='0' xEnd='700' yEnd='400'
      height='250' thickness='10' level='down'/>
  <wall id='s' wallAtStart='e' wallAtEnd='w' xStart='700' yStart='400' xEnd='0' yEnd='400'
      height='250' thickness='10' level='down'/>
  <wall id='w' wallAtStart='s' wallAtEnd='n' xStart='0' yStart='400' xEnd='0' yEnd='0'
      height='250' thickness='10' level='down'/>
  <wall id='m' xStart='400' yStart='0' xEnd='400' yEnd='400' height='250' thickness='10'
      level='down' leftSideColor='FF0000FF' rightSideColor='FFFF0000'/>
</home>
"""
PICTURE = cv2.imencode(".png", np.full((8, 8, 3), 200, np.uint8))[1].tobytes()
GREY = WallFinish((0.5, 0.5, 0.5))


def packed(path, plan=HOME, name="Home.xml"):
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr(name, plan)
        archive.writestr("3/cube.obj", BLOCK.format(group="g cube"))
        archive.writestr("4/door.obj", ARCH)
        archive.writestr("7", PICTURE)
    return path


@pytest.fixture(scope="module")
def house(tmp_path_factory):
    return read_home(packed(tmp_path_factory.mktemp("home") / "my.sh3d"))


def named(house, label):
    return next(instance for instance in house.instances if instance.label == label)


def bounds(parts):
    corners = triangles(parts)
    return corners.min(axis=(0, 1)), corners.max(axis=(0, 1))


def test_furniture_stands_where_it_was_drawn_with_y_to_the_north(house):
    low, high = bounds(named(house, "sofa").parts())
    assert low == pytest.approx([0.6, -2.9, 0.0], abs=1e-4)
    assert high == pytest.approx([1.4, -1.1, 0.7], abs=1e-4)
    low, high = bounds(named(house, "chair").parts())
    assert low == pytest.approx([2.8, -1.2, 0.4], abs=1e-4)
    assert high == pytest.approx([3.2, -0.8, 1.3], abs=1e-4)


def test_a_piece_turns_clockwise_with_its_angle_from_a_front_to_the_south(house):
    sofa = named(house, "sofa")
    front = [part for part in sofa.parts() if part.rgba[0] < 0.9]
    low, high = bounds(front)  # drawn with its front to the west
    assert (low[0], high[0]) == pytest.approx((0.6, 0.6), abs=1e-4)
    assert sofa.yaw == pytest.approx(-pi / 2)


def test_colours_of_pieces_and_of_their_materials_can_be_changed(house):
    (whole,) = named(house, "bed").piece.parts
    assert whole.rgba == pytest.approx([0, 0, 1, 1])
    colours = {tuple(part.rgba) for part in named(house, "chair").piece.parts}
    assert colours == {(1, 1, 1, 1), (0, 1, 0, 1)}


def test_mirrored_models_still_face_outwards(house):
    for part in named(house, "chair").piece.parts:
        corners = part.vertices[part.faces]
        facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        assert (np.einsum("ij,ij->i", facing, part.normals[part.faces[:, 0]]) > 0).all()
    corners = triangles(named(house, "chair").piece.parts)
    assert np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) > 0


def test_labels_come_from_names_or_else_from_the_catalogue(house):
    labels = {instance.label for instance in house.instances}
    assert labels == {"sofa", "bed", "chair", "vase", "window", "door"}


def test_a_model_that_cannot_be_read_becomes_a_box_of_its_size(house):
    assert named(house, "vase").piece.size == pytest.approx([0.2, 0.2, 0.3])


def test_rooms_have_our_names_and_one_without_is_known_by_its_furniture(house):
    assert [room.name for room in house.rooms] == ["living room", "bedroom"]
    assert house.room_at(1.0, -1.0).name == "living room"
    assert house.room_at(6.0, -1.0).name == "bedroom"


def test_a_floor_shows_the_picture_it_was_given(house):
    floors = [part for part in house.structure if part.texture and np.ptp(part.vertices[:, 2]) == 0]
    assert any(np.ptp(part.texcoords[:, 0]) == pytest.approx(3.9 / 0.5) for part in floors)


def test_doors_inside_stand_open_and_those_that_lead_out_are_closed(house):
    doors = [instance for instance in house.instances if instance.label == "door"]
    assert [(door.x, door.y) for door in doors] == [(0.0, -3.0)]
    space = FreeSpace.from_house(house)
    reached = space.reached(1.5, -3.2)
    assert reached[space.grid.cell_of(6.0, -3.0)]
    assert not reached[space.grid.cell_of(-0.4, -3.0)]


def test_a_window_shows_outdoors_in_a_hole_of_the_wall(house):
    window = named(house, "window")
    assert any(part.texture is not None for part in window.piece.parts)
    grid = grid_around(triangles(house.structure))
    wall = occupied(triangles(house.structure), 1.0, 2.0, grid)

    def crossed(x):
        (row, column), (last, _) = grid.cell_of(x, -0.1), grid.cell_of(x, 0.1)
        return wall[row : last + 1, column].any()

    assert not crossed(2.0)
    assert crossed(1.2)


def test_the_robot_starts_on_free_floor_in_the_largest_part(house):
    space = FreeSpace.from_house(house)
    assert house.room_at(*house.start[:2]) is not None
    assert space.clearance(*house.start[:2]) > 0.5


@pytest.mark.slow
def test_an_example_in_the_program_is_named_like_a_file_in_a_folder(tmp_path):
    jar = packed(tmp_path / "sweethome3d.jar", name=f"{EXAMPLES}Studio.xml")
    assert len(read_world(jar / "Studio").rooms) == 2
    with pytest.raises(ConfigError, match=r"take one of .*sweethome3d.jar/Studio"):
        read_world(jar / "Castle")


@pytest.mark.long
@pytest.mark.skipif(not PROGRAM.is_file(), reason=f"no {PROGRAM}: SWEET_HOME_JAR names another")
def test_the_nine_examples_of_the_program_are_homes():
    inside = zipfile.Path(PROGRAM, EXAMPLES).iterdir()
    names = sorted(path.stem for path in inside if path.suffix == ".xml")
    assert len(names) == 9
    for name in names:
        home = read_world(PROGRAM / name)
        assert home.rooms and len(home.instances) > 5, name
        assert len({it.name for it in home.instances}) == len(home.instances), name
        assert home.room_at(*home.start[:2]) is not None, name


@pytest.mark.slow
def test_what_is_no_home_is_told_in_one_line(tmp_path):
    torn = tmp_path / "torn.sh3d"
    torn.write_bytes(b"PK\x03\x04 and no more")
    with pytest.raises(ConfigError, match=r"no \.sh3d file"):
        read_world(torn)
    with pytest.raises(ConfigError, match="is not there"):
        read_world(tmp_path / "nowhere.sh3d")
    with pytest.raises(ConfigError, match=r"holds no Home\.xml"):
        read_world(packed(tmp_path / "old.sh3d", name="Home"))
    with pytest.raises(ConfigError, match="is torn"):
        read_world(packed(tmp_path / "half.sh3d", HOME[:2000]))
    with pytest.raises(ConfigError, match="cannot be read"):
        read_world(packed(tmp_path / "odd.sh3d", HOME.replace("xStart='700'", "xStart='far'")))
    with pytest.raises(ConfigError, match="no room with free floor"):
        read_world(packed(tmp_path / "empty.sh3d", "<home/>"))
    with pytest.raises(ConfigError, match="give a seed"):
        read_world(tmp_path / "home.docx")


@pytest.mark.sampled("69500", "x is nan m", "arcExtent", "thickness is")
@pytest.mark.parametrize(
    ("drawn", "instead", "said"),
    [
        ("<point x='695' y='395'/>", "<point x='69500' y='395'/>", "m wide, of 100 m at most"),
        ("<point x='695' y='395'/>", "<point x='1e30' y='395'/>", "x is 1e+28 m"),
        ("<point x='695' y='395'/>", "<point x='nan' y='395'/>", "x is nan m"),
        ("xEnd='400' yEnd='400'", "xEnd='400' yEnd='90000'", "m wide, of 100 m at most"),
        ("xEnd='400' yEnd='400'", "xEnd='400' yEnd='400' arcExtent='6.28318'", "arcExtent is 6.28"),
        ("height='250' thickness='10'", "height='1e9' thickness='10'", "height is 1e+07 m"),
        ("height='250' thickness='10'", "height='250' thickness='1e300'", "thickness is 1e+298 m"),
        ("width='180.0'", "width='1e12'", "width is 1e+10 m"),
        ("x='100.0' y='200.0'", "x='100.0' y='-20000'", "m wide, of 100 m at most"),
        ("wallHeight='250.0'", "wallHeight='inf'", "wallHeight is inf m"),
    ],
)
def test_a_plan_larger_than_any_home_is_refused_with_its_value(tmp_path, drawn, instead, said):
    assert drawn in HOME
    with pytest.raises(ConfigError) as refusal:
        read_world(packed(tmp_path / "vast.sh3d", HOME.replace(drawn, instead, 1)))
    assert said in str(refusal.value) and "\n" not in str(refusal.value)


def test_walls_close_at_their_corners_whatever_the_angle():
    points = np.array([[0, 0], [4, 0], [3, 3], [0, 2]], np.float64)
    walls = [
        Wall(points[i], points[(i + 1) % 4], 0.2, 2.5, GREY, GREY,
             at_start=(i - 1) % 4, at_end=(i + 1) % 4)
        for i in range(4)
    ]  # fmt: skip
    corners = triangles(build_walls(walls, ()))
    upright = corners[np.ptp(corners[..., 2], axis=1) > 0.1]
    # Only the two sides of each wall and its hidden ends: nothing stands beyond the mitred corner.
    outer = upright[..., :2].reshape(-1, 2).min(axis=0)
    assert outer == pytest.approx([-0.1, -0.1], abs=1e-5)


def test_openings_are_cut_into_slanting_walls_above_each_other():
    wall = Wall(np.zeros(2), np.array([3.0, 3.0]), 0.2, 2.5, GREY, GREY)
    middle = np.array([1.5, 1.5])
    holes = [Hole(middle, pi / 4, 1.0, 0.2, 0.0, 1.0), Hole(middle, pi / 4, 1.0, 0.2, 1.5, 2.0)]
    corners = triangles(build_walls([wall], holes))
    grid = grid_around(corners, 0.02)

    def open_at(z):
        return not occupied(corners, z - 0.1, z + 0.1, grid)[grid.cell_of(1.43, 1.57)]

    assert [open_at(z) for z in (0.5, 1.25, 1.75, 2.25)] == [True, False, True, False]


@pytest.mark.parametrize("arc", [0.7, -2.5])
def test_a_round_wall_runs_from_its_start_to_its_end_on_a_circle(arc):
    points = np.array(rounded(np.zeros(2), np.array([2.0, 0.0]), arc))
    assert points[0] == pytest.approx([0, 0]) and points[-1] == pytest.approx([2, 0])
    steps = np.diff(points, axis=0)
    turns = np.diff(np.unwrap(np.arctan2(steps[:, 1], steps[:, 0])))
    assert turns == pytest.approx(np.full(len(turns), -arc / len(steps)), abs=1e-6)
