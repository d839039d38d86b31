import shutil
from dataclasses import replace

import pytest

from vizbot.bench import fingerprint
from vizbot.bench.episodes import Variant
from vizbot.bench.fingerprint import Fingerprint
from vizbot.bench.objectnav import with_scales
from vizbot.config import Config


@pytest.fixture
def checkout(tmp_path, monkeypatch):
    """A copy of the sources that can be changed."""
    for folder in ("drivers", "mapping", "nav", "sim_stubs", "vizbot", "tests"):
        shutil.copytree(fingerprint.ROOT / folder, tmp_path / folder)
    monkeypatch.setattr(fingerprint, "ROOT", tmp_path)
    return tmp_path


DEFAULT = Variant("default", Config())


def key_of(variant):
    return Fingerprint.taken(variant.config.clip).key_of(variant)


@pytest.mark.parametrize(
    "path", ["nav/astar.py", "sim_stubs/world.py", "vizbot/core/types.py", "vizbot/pipeline.py",
             "vizbot/bench/runs.py", "mapping/new.py", "sim_stubs/weights.safetensors"],
)  # fmt: skip
def test_what_can_change_an_episode_changes_the_key(checkout, path):
    before = key_of(DEFAULT)
    with (checkout / path).open("a") as file:
        file.write("# more\n")
    assert key_of(DEFAULT) != before


@pytest.mark.parametrize(
    "path", ["vizbot/operator/report.py", "vizbot/bench/tables.py", "tests/test_world.py",
             "sim_stubs/clip_training.py"],
)  # fmt: skip
def test_what_cannot_leaves_it(checkout, path):
    before = key_of(DEFAULT)
    with (checkout / path).open("a") as file:
        file.write("# more\n")
    assert key_of(DEFAULT) == before


def test_counterparts_change_only_the_rows_that_use_them(checkout):
    true_pose = Variant("true pose", Config(), "pose")
    before = key_of(DEFAULT), key_of(true_pose)
    with (checkout / "vizbot/bench/counterparts.py").open("a") as file:
        file.write("# more\n")
    assert key_of(DEFAULT) == before[0] != before[1]
    assert key_of(true_pose) != before[1]


def test_a_counterpart_is_known_to_be_of_its_robot():
    robot, true = key_of(DEFAULT), key_of(Variant("true pose", Config(), "pose"))
    assert fingerprint.is_counterpart_of(true, robot)
    another = key_of(Variant("default", with_scales(Config(), (0,))))
    assert not fingerprint.is_counterpart_of(true, another)
    assert not fingerprint.is_counterpart_of(robot, robot)


def test_a_fingerprint_holds_until_a_source_changes(checkout):
    taken = Fingerprint.taken("embedded")
    assert taken.still_holds()
    assert taken.commit == "unknown" and not taken.clean
    assert replace(taken, commit="c0ffee").clean and not replace(taken, commit="c0ffee+").clean
    (checkout / "docs.md").write_text("more")
    assert replace(taken, commit="c0ffee").still_holds()
    with (checkout / "nav/astar.py").open("a") as file:
        file.write("# more\n")
    assert not taken.still_holds()


def test_settings_change_the_key_and_the_name_of_a_row_does_not():
    key = key_of(DEFAULT)
    assert key_of(Variant("another", Config())) == key
    assert key_of(Variant("default", with_scales(Config(), (0,)))) != key


def test_a_folder_with_weights_counts_with_what_is_in_it(tmp_path):
    variant = Variant("default", Config(clip=str(tmp_path)))
    (tmp_path / "model.safetensors").write_bytes(b"1")
    before = key_of(variant)
    (tmp_path / "model.safetensors").write_bytes(b"2")
    assert key_of(variant) != before
