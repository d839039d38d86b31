import json
import os
import re
import subprocess
import sys
import tomllib

import pytest
import typer

from benchmarks import app as bench
from benchmarks.harness.bench_plan import UNATTENDED, BenchResult
from benchmarks.harness.fingerprint import Fingerprint
from tests.helpers.checkout import ROOT
from vizbot.commands import bench as commands_bench
from vizbot.core.errors import ConfigError


@pytest.fixture
def plans(monkeypatch):
    """Boards that were asked for; nothing is run."""
    asked = []

    def outcome(plan):
        asked.append(plan)
        return BenchResult("objectnav", [{"row": "default"}], {"episodes": 0}, "| a table |")

    for module, name in (
        (bench.single_goal, "run_single_goal"),
        (bench.multi_goal, "run_multi_goal"),
        (bench.absent, "run_absent"),
    ):
        monkeypatch.setattr(module, name, outcome)
    monkeypatch.setattr(bench, "search_page", lambda folder, page: "a page")
    monkeypatch.setattr(bench, "write_whole", lambda page, content: None)
    made_at(monkeypatch, "c0ffee")
    return asked


def made_at(monkeypatch, commit):
    made = Fingerprint("embedded", "homes", "episodes", "oracles", commit, "2 cores")
    monkeypatch.setattr(Fingerprint, "taken", staticmethod(lambda clip: made))


def test_json_is_one_object_with_name_rows_and_summary(vizbot, plans):
    code, out, err = vizbot("objectnav", "--json", "--out", "there")
    assert code == 0
    assert json.loads(out) == {
        "name": "objectnav", "rows": [{"row": "default"}], "summary": {"episodes": 0}
    }  # fmt: skip
    assert "there.md" in err
    assert str(plans[0].folder) == "there"


def test_people_get_the_tables_and_only_the_whole_board_writes_the_page(vizbot, plans):
    code, out, err = vizbot("objectnav", "--seeds", "1000,1003", "--rows", "default,true pose")
    assert code == 0
    assert out == "| a table |\n"
    assert err == ""
    assert plans[0].homes == (1000, 1003)
    assert plans[0].rows == ("default", "true pose")
    assert vizbot("objectnav", "--quick")[2] == ""
    assert str(plans[1].folder) == "runs/bench/quick_share"
    assert plans[1].quick and not plans[1].full


def test_published_rows_are_made_again_where_they_lie_and_so_is_their_page(vizbot, plans):
    rows = "docs/results/rows/search"
    code, _, err = vizbot("objectnav", "--out", rows)
    assert code == 0 and err == "written: docs/results/search.md\n"
    assert str(plans[0].folder) == rows


@pytest.mark.parametrize(
    ("arguments", "rows"),
    [
        (["multi", "--quick", "--rows", "over 3 m"], ("over 3 m",)),
        (["absent", "--rows", "offset,by searching"], ("offset", "by searching")),
        (["objectnav", "--quick", "--method", "paper"], ("paper",)),
        (["objectnav", "--quick", "--method=belief"], ("default",)),
        (["objectnav", "--quick", "--encoder-scale=clip"], ("scaled",)),
        (["objectnav", "--quick", "--encoder-scale=offset"], ("offset",)),
    ],
)
def test_rows_can_be_chosen_and_a_method_and_another_encoder_have_rows_of_their_own(
    vizbot, plans, arguments, rows
):
    assert vizbot(*arguments)[0] == 0
    assert plans[0].rows == rows
    assert plans[0].config == UNATTENDED


def test_sources_that_are_not_committed_are_told_in_one_line(vizbot, plans, monkeypatch):
    made_at(monkeypatch, "c0ffee+")
    code, out, err = vizbot("objectnav", "--quick")
    assert (code, out) == (0, "| a table |\n")
    assert len(err.splitlines()) == 1
    assert "c0ffee+" in err


def test_tables_are_printed_even_if_the_page_cannot_be_written(vizbot, plans, monkeypatch):
    def broken(folder, page):
        raise ConfigError(f"cannot write {page}")

    monkeypatch.setattr(bench, "search_page", broken)
    code, out, err = vizbot("objectnav")
    assert (code, out) == (1, "| a table |\n")
    assert "cannot write runs/bench/board.md" in err


def test_other_settings_and_training_homes_are_kept_in_a_folder_of_their_own(
    vizbot, plans, tmp_path
):
    (tmp_path / "there.toml").write_text("[objectnav]\nmax_steps = 7\n")
    arguments = ("--config", str(tmp_path / "there.toml"), "--out", str(tmp_path / "there"))
    assert vizbot("objectnav", *arguments, "--seeds", "3")[0] == 0
    assert plans[0].config.objectnav.max_steps == 7
    assert plans[0].homes == (3,)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["nosuch"], "'nosuch'"),
        (["objectnav", "--seeds", "a,b"], "'a,b'"),
        (["objectnav", "--seeds", "1000,"], "'1000,'"),
        (["objectnav", "--seeds", "1000,3"], "home 3 "),
        (["objectnav", "--rows", "scale 7"], "'scale 7'"),
        (["objectnav", "--clip", "ViT-L/14"], "--out"),
        (["multi", "--rows", "scale 1"], "'scale 1'; use default, over 3 m, paper"),
        (["retrieval", "--rows", "default"], "--rows"),
        (["objectnav", "--method", "foo"], "'foo' is not one of 'belief', 'paper'"),
        (["objectnav", "--method", "paper", "--rows", "default"], "leave out --rows default"),
        (["slam", "--method", "paper"], "--method"),
        (["multi", "--encoder-scale", "clip"], "--encoder-scale"),
        (
            ["objectnav", "--encoder-scale", "clip", "--method", "paper", "--rows", "default"],
            "leave out --encoder-scale clip and --rows default",
        ),
        (["objectnav", "--config", "missing.toml", "--out", "x"], "missing.toml"),
        (["slam", "--stride", "2"], "--stride, --vocabulary and --intrinsics are for a recording"),
        (["slam", "--seeds", "0x7"], "--seeds '0x7' are no seeds"),
        (["slam", "--hours", "1", "--seeds", "1000,1001"], "one of --seeds 1000,1001"),
        (["multi", "--hours", "4"], "No such option: --hours. See: vizbot bench multi --help"),
        (["slam", "nowhere"], "sequence nowhere: no such folder"),
        (["slam", "nowhere", "--seeds", "3"], "--seeds and --hours are for simulated homes"),
        (["objectnav", "somewhere"], "(somewhere)"),
        (["retrieval", "--stride", "2"], "No such option: --stride"),
        (["faults", "--rows", "default"], "No such option: --rows"),
        (["faults", "--seeds", "1000,12"], "home 12 of --seeds is a training home"),
        (["faults", "--clip", "ViT-B/32"], "No such option: --clip"),
        (["multi", "--worlds", "a.sh3d"], "--worlds"),
        (["objectnav", "--worlds", "a", "--seeds", "1000"], "--worlds"),
        (["objectnav", "--worlds", "1140+bear"], "'+bear' changes no home"),
        (["objectnav", "--worlds", "1140+bare,1141"], "home 1141 of --worlds has a seed alone"),
        (["multi", "--goals", "3"], "No such option: --goals"),
        (["objectnav", "--goals", "3", "--fast"], "leave out --goals 3"),
        (["objectnav", "--goals", "3", "--quick"], "leave out --goals 3"),
        (["objectnav", "--fast", "--worlds", "a.xml"], "leave out --worlds a.xml"),
        (["objectnav", "--goals", "0"], "--goals 0: it must be at least 1"),
        (["multi", "--fast"], "No such option: --fast"),
        (["objectnav", "--fast", "--seeds", "1100,1030"], "home 1030 of --seeds is none of dev"),
        (["objectnav", "--fast", "--rows", "scale 1"], "unknown row 'scale 1'; use default,"),
    ],
)
def test_what_cannot_be_used_is_one_line_that_names_it(vizbot, plans, arguments, said):
    code, out, err = vizbot(*arguments)
    assert (code, out, plans) == (1, "", [])
    assert said in err
    assert len(err.splitlines()) == 1


def test_the_benchmark_of_faults_is_asked_for_its_homes(vizbot, monkeypatch):
    asked = []

    def outcome(bench):
        asked.append(bench)
        return BenchResult("faults", [], {"runs": 0}, "| a table |")

    monkeypatch.setattr(bench.faults, "run_faults", outcome)
    assert vizbot("faults", "--quick", "--out", "there")[:2] == (0, "| a table |\n")
    [plan] = asked
    assert (plan.homes, plan.quick, str(plan.folder)) == ((1000, 1001, 1002), True, "there")


def test_homes_drawn_by_others_are_kept_apart_and_drive_the_default_row_or_those_named(
    vizbot, plans, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    for name in ("a.jar", "b.sh3d"):
        (tmp_path / name).touch()
    code, _, err = vizbot("objectnav", "--worlds", "a.jar/Studio,b.sh3d")
    assert code == 0, err
    [plan] = plans
    assert plan.homes == ("a.jar/Studio", "b.sh3d") and plan.rows == ("default",)
    assert plan.folder == bench.OTHERS and not plan.full
    rows = "default, true encoder,perfect stop,paper"
    assert vizbot("objectnav", "--worlds", "b.sh3d", "--rows", rows)[0] == 0
    assert plans[1].rows == ("default", "true encoder", "perfect stop", "paper")
    code, _, err = vizbot("objectnav", "--worlds", "b.sh3d", "--rows", "without z-score")
    assert code == 1 and len(plans) == 2
    assert "unknown row 'without z-score'; use default, " in err
    assert "perfect stop\n" in err and "without likeness" not in err and err.count("\n") == 1


def test_bare_homes_are_kept_apart_and_drive_the_default_row_alone(
    vizbot, plans, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.xml").write_text("<mujoco/>")
    code, _, err = vizbot("objectnav", "--worlds", "1140+bare,a.xml")
    assert code == 1
    assert "kept apart; give a folder by --out" in err
    assert plans == []
    assert vizbot("objectnav", "--worlds", "1140+bare,1141+bare", "--goals", "3")[0] == 0
    [plan] = plans
    assert plan.homes == ("1140+bare", "1141+bare")
    assert (plan.goals, plan.rows, plan.folder) == (3, ("default",), bench.BARE)
    assert not plan.full


HELP = {
    "objectnav": ("--seeds --quick --rows --clip --use --config --out --json --worlds --goals"
                  " --fast --method --encoder-scale"),
    "multi": "--seeds --quick --rows --clip --use --config --out --json --method",
    "retrieval": "--seeds --quick --rows --clip --use --config --out --json --encoder-scale",
    "absent": "--seeds --quick --rows --clip --use --config --out --json --encoder-scale",
    "moved": "--seeds --quick --rows --clip --use --config --out --json",
    "slam": "--seeds --hours --stride --vocabulary --intrinsics --quick --config --out --json",
    "questions": "--questions --clip --use --config --out --json",
    "encoder": ("--clip --use --seeds --worlds --sequence --questions --families --quick --config"
                " --out --json"),
    "planner": "--quick --out --json",
    "loop": "--quick --against --json",
    "faults": "--seeds --quick --out --json",
}  # fmt: skip


def test_each_benchmark_has_its_own_options_and_no_others():
    commands = typer.main.get_command(bench.app).commands
    options = {
        name: " ".join(o for each in command.params for o in each.opts if o.startswith("--"))
        for name, command in commands.items()
    }
    assert options == HELP


@pytest.fixture
def foreign(tmp_path, monkeypatch):
    """A working folder with a package of the same name, which is first on the path, too."""
    package = tmp_path / "benchmarks"
    package.mkdir()
    (package / "__init__.py").write_text("raise AssertionError('foreign')\n")
    (package / "app.py").write_text("raise AssertionError('foreign')\n")
    return tmp_path


def test_benchmarks_of_the_working_folder_are_not_taken_for_those_of_the_checkout(foreign):
    command = "from vizbot.cli.process import run; run()"
    path = os.pathsep.join([str(foreign), str(ROOT)])
    ended = subprocess.run(
        [sys.executable, "-c", command, "bench", "speed"],
        cwd=foreign, env=os.environ | {"PYTHONPATH": path}, capture_output=True, text=True,
    )  # fmt: skip
    assert (ended.returncode, ended.stdout) == (1, "")
    assert ended.stderr.splitlines()[-1].startswith("vizbot: No such command 'speed'")
    assert "foreign" not in ended.stderr


@pytest.mark.parametrize("project", [None, "", '[project]\nname = "another"\n'])
def test_without_the_source_there_are_no_benchmarks(vizbot, foreign, monkeypatch, project):
    """An installed package may lie beside another one that has this name."""
    if project is not None:
        (foreign / "pyproject.toml").write_text(project)
    monkeypatch.setattr(commands_bench.vizbot, "__file__", str(foreign / "vizbot/__init__.py"))
    code, out, err = vizbot("objectnav", "--quick")
    assert (code, out) == (1, "")
    assert err == "vizbot: benchmarks come with the source; run them in a checkout of vizbot\n"


@pytest.mark.parametrize("name", ["benchmarks", "training"])
def test_what_is_for_people_who_work_on_vizbot_is_in_no_wheel_and_imported_by_no_part(name):
    build = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["hatch"]["build"]
    packages = build["targets"]["wheel"]["packages"]
    assert name not in packages
    imports = re.compile(rf"^\s*(from {name}[\w.]* import|import {name})\b", re.MULTILINE)
    for path in (path for package in packages for path in (ROOT / package).rglob("*.py")):
        assert not imports.search(path.read_text()), path
