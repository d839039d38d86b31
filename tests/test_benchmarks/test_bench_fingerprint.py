import json
import shutil
import subprocess
from dataclasses import replace

import pytest

from benchmarks.episodes.episode import Variant
from benchmarks.harness import fingerprint
from benchmarks.harness.fingerprint import Fingerprint
from benchmarks.objectnav.single_goal import with_scales
from tests.helpers.checkout import ROOT
from vizbot.config import Config


@pytest.fixture(scope="module")
def copied(tmp_path_factory):
    """A copy of the sources."""
    copy = tmp_path_factory.mktemp("checkout")
    for folder in (*fingerprint._COMMITTED, "tests"):
        shutil.copytree(ROOT / folder, copy / folder, ignore=shutil.ignore_patterns("*.pyc"))
    return copy


@pytest.fixture
def checkout(copied, monkeypatch):
    """A copy of the sources that a test may lengthen and add to."""
    monkeypatch.setattr(fingerprint, "ROOT", copied)
    sizes = sizes_in(copied)
    yield copied
    for path, _ in sizes_in(copied).items() - sizes.items():
        path.unlink()
    for path in sizes.keys() - sizes_in(copied).keys():
        shutil.copy(ROOT / path.relative_to(copied), path)


def sizes_in(folder):
    return {path: path.stat().st_size for path in folder.rglob("*") if path.is_file()}


DEFAULT = Variant("default", Config())


def key_of(variant):
    return Fingerprint.taken(variant.config.clip).key_of(variant)


ROOMS = sorted(
    f"{path.relative_to(ROOT)}"
    for package in fingerprint._COMMITTED
    for path in [ROOT / package, *(ROOT / package).rglob("*")]
    if (path / "__init__.py").is_file()
)
"""Every folder of sources."""
ASIDE = (
    "training",
    "vizbot/calibration",
    "vizbot/cli",
    "vizbot/commands",
    "vizbot/operator",
)


def is_aside(room):
    """Whether no episode enters a room; those of `benchmarks/episodes` run in it."""
    return room != "benchmarks/episodes" and room.startswith((*ASIDE, "benchmarks"))


@pytest.fixture(scope="module")
def before(copied):
    """The key of the copy as it is."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(fingerprint, "ROOT", copied)
        return key_of(DEFAULT)


def changed(checkout, path):
    """The key after one more line in a source, or a new one."""
    with (checkout / path).open("a") as file:
        file.write("# more\n")
    return key_of(DEFAULT)


@pytest.mark.parametrize("room", [room for room in ROOMS if not is_aside(room)])
def test_a_change_in_any_room_of_the_robot_changes_the_key(checkout, before, room):
    after = changed(checkout, f"{room}/__init__.py")
    assert after != before
    assert changed(checkout, f"{room}/added.py") != after


@pytest.mark.parametrize(
    "path", ["vizbot/pipeline.py", "benchmarks/episodes/run.py", "benchmarks/episodes/added.py",
             "mapping/clip/embedded/weights/model.safetensors", "vizbot/a_new_room.py"],
)  # fmt: skip
def test_what_can_change_an_episode_changes_the_key(checkout, before, path):
    assert changed(checkout, path) != before


NAMED_IN_RUNS = (*fingerprint._PACKAGES, *fingerprint._HOMES, fingerprint._EPISODES)
NAMED_ASIDE = (
    *fingerprint._NO_PART_OF_A_RUN,
    fingerprint._ABLATIONS,
    fingerprint._ORACLES,
    "training",
)


@pytest.mark.parametrize("named", [*NAMED_IN_RUNS, *NAMED_ASIDE])
def test_each_named_folder_is_there_and_counts_or_stays_aside_as_its_name_says(
    checkout, before, named
):
    """The last source of each, which is no `__init__.py`."""
    *_, last = fingerprint._sources(named)
    after = changed(checkout, last.relative_to(checkout))
    assert (after != before) == (named in NAMED_IN_RUNS)


def test_homes_have_a_key_of_their_own(checkout):
    homes = Fingerprint.taken("embedded").homes
    changed(checkout, "benchmarks/episodes/homes.py")
    assert Fingerprint.taken("embedded").homes == homes
    changed(checkout, "vizbot/core/home_vocabulary.py")
    assert Fingerprint.taken("embedded").homes != homes


@pytest.mark.parametrize("room", [room for room in ROOMS if is_aside(room)])
def test_a_room_that_no_episode_enters_leaves_the_key(checkout, before, room):
    assert changed(checkout, f"{room}/__init__.py") == before


def test_tests_leave_the_key(checkout, before):
    assert changed(checkout, "tests/test_simulation/test_world.py") == before


@pytest.mark.parametrize("name", ["nav", "benchmarks/slam", "benchmarks/slam/laps.py"])
def test_a_key_of_named_sources_changes_with_each_of_them(checkout, name):
    before = fingerprint.key_of_sources("drivers", name), fingerprint.key_of_robot(name)
    changed(checkout, name if name.endswith(".py") else f"{name}/__init__.py")
    assert fingerprint.key_of_sources("drivers", name) != before[0]
    assert fingerprint.key_of_robot(name) != before[1]


def test_a_key_of_sources_that_are_not_there_is_refused(checkout):
    with pytest.raises(FileNotFoundError, match=r"no sources at .*benchmarks/nothing"):
        fingerprint.key_of_sources("benchmarks/nothing")


KEPT = sorted(path for path in (ROOT / "docs").rglob("*.jsonl") if path.stem != "mutants")
"""All rows of benches; mutants are named by what they change, not by the key of their sources."""


@pytest.mark.parametrize("path", KEPT, ids=[path.stem for path in KEPT])
def test_no_kept_row_of_older_sources_is_taken_for_one_of_these(path):
    """Rows keep the key of the sources they were made with, and a bench reads those of its own."""
    rows = [json.loads(line) for line in path.read_text().splitlines()]
    assert rows
    of_faults, of_replays = (
        ("benchmarks/episodes", "benchmarks/faults"),
        ("mapping", "vizbot/core", "benchmarks/slam"),
    )
    commits = {
        key: {row["commit"] for row in rows if key in row["key"].split("-")}
        for key in (
            fingerprint.key_of_robot(*of_faults),
            fingerprint.key_of_sources(*of_replays),
            key_of(DEFAULT),
        )
    }
    faults, replays, episodes = commits.values()
    assert [each for commit in faults | episodes for each in changed_since(commit)] == []
    assert [each for commit in faults for each in changed_in(commit, *of_faults)] == []
    assert [each for commit in replays for each in changed_in(commit, *of_replays)] == []


def changed_in(commit, *sources):
    """Of these folders the sources that differ from those of a commit."""
    command = ["git", "diff", "--name-only", commit, "--", *sources]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    return [name for name in done.stdout.splitlines() if name.endswith(fingerprint._SUFFIXES)]


def changed_since(commit):
    """Sources of a run that differ from those of a commit."""
    others = [each for each in fingerprint._NO_PART_OF_A_RUN if each != "benchmarks"]
    return [
        name for name in changed_in(commit, *fingerprint._PACKAGES)
        if not any(name.startswith(f"{each}/") for each in others)
        and (not name.startswith("benchmarks/") or name.startswith(fingerprint._EPISODES))
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("row", "file"),
    [
        (Variant("true pose", Config(), "pose"), "episodes/oracles.py"),
        (Variant("fewer", Config(), ablated="z-score"), "ablations/ablation.py"),
    ],
)
def test_oracles_and_ablations_change_only_the_rows_that_use_them(checkout, row, file):
    before = key_of(DEFAULT), key_of(row)
    assert changed(checkout, f"benchmarks/{file}") == before[0] != before[1]
    assert key_of(row) != before[1]


def test_a_fingerprint_holds_until_a_source_changes(checkout):
    taken = Fingerprint.taken("embedded")
    assert taken.still_holds()
    assert taken.commit == "unknown" and not taken.clean
    assert replace(taken, commit="c0ffee").clean and not replace(taken, commit="c0ffee+").clean
    (checkout / "docs.md").write_text("more")
    assert replace(taken, commit="c0ffee").still_holds()
    changed(checkout, "nav/astar.py")
    assert not taken.still_holds()


def test_settings_change_the_key_and_the_name_of_a_row_does_not():
    key = key_of(DEFAULT)
    assert key_of(Variant("another", Config())) == key
    assert key_of(Variant("default", with_scales(Config(), (0,)))) != key


@pytest.mark.parametrize("file", ["model.safetensors", "pytorch_model.bin"])
def test_a_folder_with_weights_counts_with_what_is_in_it(tmp_path, file):
    variant = Variant("default", Config(clip=str(tmp_path)))
    (tmp_path / file).write_bytes(b"1")
    before = key_of(variant)
    (tmp_path / file).write_bytes(b"2")
    assert key_of(variant) != before
