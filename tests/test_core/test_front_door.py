"""What `from vizbot import ...` gives, and when it loads what it needs."""

import subprocess
import sys
from importlib import import_module

import pytest

import vizbot
from tests.helpers.checkout import ROOT
from tests.helpers.served import served
from tests.test_core.test_examples import kept_map
from vizbot.operator.api.auth import store_token
from vizbot.operator.session.session import OperatorSession

OURS = ("drivers", "mapping", "nav", "sim_stubs", "vizbot")


@pytest.fixture
def own_settings(tmp_path, monkeypatch):
    """No settings and no token of other tests."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))


def loaded_by(program):
    """The modules that a fresh interpreter loads for a program, but for Python's own."""
    shown = "print(*(m for m in sys.modules if m.split('.')[0] not in plain))"
    lines = f"import sys; plain = sys.stdlib_module_names; {program}; {shown}"
    done = subprocess.run([sys.executable, "-c", lines], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return {name for name in done.stdout.split() if name.split(".")[0] != "__main__"}


def test_to_import_it_loads_nothing_else():
    loaded = loaded_by("import vizbot; vizbot.__version__; dir(vizbot)")
    assert {name for name in loaded if name.startswith((*OURS, "numpy", "pydantic"))} == {"vizbot"}


@pytest.mark.slow
def test_a_client_needs_neither_simulator_nor_encoders():
    loaded = loaded_by("from vizbot import RobotClient")
    assert not {"torch", "mujoco", "cv2", "sim_stubs"} & loaded


@pytest.mark.parametrize("name", vizbot._MODULES)
def test_each_name_is_that_of_its_module(name):
    assert getattr(vizbot, name) is getattr(import_module(vizbot._MODULES[name]), name)
    assert name in dir(vizbot)


def test_what_it_does_not_export_is_refused_by_name():
    with pytest.raises(ImportError, match="cannot import name 'Rig'"):
        from vizbot import Rig  # noqa: F401
    with pytest.raises(AttributeError, match=r"vizbot exports .*SavedMap.*, and no Rig"):
        _ = vizbot.Rig


@pytest.mark.slow
def test_a_saved_map_is_asked_in_three_lines(tmp_path):
    kept_map(tmp_path / "home", "sofa")
    saved = vizbot.SavedMap(tmp_path / "home")
    answer = saved.find("sofa")
    found = [place for place in answer.places if place.score > answer.threshold]
    assert answer.threshold == vizbot.Config().objectnav.answer_probability
    assert saved.count("sofa") >= bool(found)
    assert saved.belief("sofa").probabilities.max() >= answer.places[0].score - 1e-3


def test_a_running_robot_is_asked_in_two_lines_with_the_token_of_this_machine(own_settings):
    with served(OperatorSession(), host="0.0.0.0") as server:
        robot = vizbot.RobotClient(server.url)
        assert robot.ask(["sofa"]) == [1]
        robot.close()


def test_a_client_that_is_to_send_no_token_does_not_read_the_kept_one(own_settings):
    store_token("short")
    with pytest.raises(vizbot.VizbotError, match="too short"):
        vizbot.RobotClient()
    vizbot.RobotClient(token="").close()
