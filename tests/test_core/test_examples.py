"""The programs in `examples` run as their first lines say."""

import re
import runpy
import subprocess
import sys
from dataclasses import replace

import pytest

from mapping.clip.scores import NO_PICTURES
from mapping.map_bundle import save, with_background
from tests.helpers.bundles import bundle_of
from tests.helpers.checkout import ROOT
from vizbot.config import Config
from vizbot.objectnav.tasks import goal_of
from vizbot.operator.session.place_answers import find_places
from vizbot.rig import open_encoder

pytestmark = pytest.mark.slow

EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
ROOM = """
<mujoco>
  <worldbody>
    <geom type="plane" size="0 0 1"/>
    <geom type="box" size="0.1 3 1.2" pos="3 0 1.2" rgba="0 1 0 1"/>
    <geom type="box" size="0.1 3 1.2" pos="-3 0 1.2" rgba="0 0 1 1"/>
    <site name="start" pos="-1 0 0"/>
    <body name="stool#1" pos="2 0 0.4"><geom type="box" size="0.2 0.2 0.4" rgba="1 1 0 1"/></body>
  </worldbody>
</mujoco>
"""


@pytest.fixture
def run(monkeypatch, capsys):
    """Runs an example with arguments; what it printed."""

    def run(name, *arguments):
        monkeypatch.setattr(sys, "argv", [name, *map(str, arguments)])
        runpy.run_path(str(ROOT / "examples" / name), run_name="__main__")
        return capsys.readouterr().out

    return run


@pytest.fixture
def room(tmp_path):
    path = tmp_path / "room.xml"
    path.write_text(ROOM)
    return path


def kept_map(folder, text):
    """A map that is saved in a folder, with a thing among white doors, and its encoder."""
    bundle, encoder = bundle_of(), open_encoder("embedded", "cpu")
    rows = encoder.embed_texts(["white door"]).repeat(len(bundle.elements.keyframes), axis=0)
    rows[:20] = encoder.embed_texts([text])
    elements = replace(bundle.elements, embeddings=rows)
    lacking = {"statistics": None, "pictures": NO_PICTURES}
    bundle = replace(bundle, elements=elements, model_id=encoder.model_id, **lacking)
    save(bundle, folder)
    return bundle, encoder


def test_a_saved_map_is_asked(run, tmp_path):
    bundle, encoder = kept_map(tmp_path / "map", "yellow chair")
    first, *said = run("ask_saved_map.py", tmp_path / "map", "yellow chair").splitlines()
    goal, config = goal_of(encoder, "yellow chair"), Config().objectnav
    answer = find_places(with_background(bundle, encoder), goal, config)
    assert first == "yellow chair"
    for line, place in zip(said, answer.places, strict=True):
        x, y, z = place.position
        assert line.split()[:3] == [f"{x:.2f}", f"{y:.2f}", f"{z:.2f}"]
        enough = "found" if place.score > config.answer_probability else "not likely enough"
        assert line.endswith(f"{place.score:.0%}   {enough}")


def test_a_client_of_other_people_turns_the_simulated_base(run):
    command = [sys.executable, "-m", "vizbot", "stub", "roomba"]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen(command, text=True, cwd=ROOT, **pipes) as stub:
        try:
            port = stub.stdout.readline().strip()
            said = run("drive_simulated_roomba.py", port, "--seconds", 0.5)
        finally:
            stub.terminate()
            stub.communicate(timeout=30)
    right, left = (int(counts) for counts in re.findall(r"wheel: +([+-]\d+) counts", said))
    assert right > 20
    assert left < -20


def test_an_observer_of_ones_own_sees_the_steps_and_the_end(run, room):
    said = run("observer.py", "yellow chair", "--world", room, "--steps", 3).splitlines()
    assert "standing still" in said[0]
    assert said[-1].startswith("yellow chair: gave_up")


def test_a_fault_of_ones_own_happens(run, room):
    said = run("fault.py", "yellow chair", "--world", room, "--after", 0, "--steps", 3)
    assert said.startswith("yellow chair: gave_up")


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.name)
def test_an_example_is_short_and_says_how_to_run_it(path):
    text = path.read_text()
    assert len(text.splitlines()) < 60
    calls = f"python examples/{path.name} ", f"--clip {path.stem}:"
    assert any(call in text.split('"""')[1] for call in calls)
