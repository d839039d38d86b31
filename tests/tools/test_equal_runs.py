import json

import pytest
import typer

from tests.tools import equal_runs
from tests.tools.equal_runs import Call, Sources, differences, digest_of, main, without_times

DRIVEN = Call("driven", ("dry-run", "sofa", "--out", "driven"))
COMMANDS = "stamp,linear,angular,by\n0.300,0.000,0.000,robot\n0.585,0.200,0.000,robot\n"
ANSWER = {"success": True, "wall_seconds": 3.0, "run": "a", "goals": [{"outcome": "arrived"}]}


def written(folder, commands=COMMANDS, trajectory="0.3 0 0 0 0 0 0 1\n", answer=ANSWER):
    """What is compared of a drive that has written these."""
    (folder / "driven").mkdir(parents=True)
    (folder / "driven" / "commands.csv").write_text(commands)
    (folder / "driven" / "trajectory.tum").write_text(trajectory)
    return digest_of(DRIVEN, folder, 0, json.dumps(answer))


def test_the_same_drive_in_another_folder_at_another_time_is_equal(tmp_path):
    before = written(tmp_path / "before")
    after = written(tmp_path / "after", answer=ANSWER | {"wall_seconds": 4.0, "run": "b"})
    assert differences(before, after) == []
    assert {"trajectory.tum", "commands.csv", "answer", "exit code"} == before.keys()


@pytest.mark.parametrize(
    ("name", "changed"),
    [
        ("commands.csv", {"commands": COMMANDS.replace("0.200", "0.201")}),
        ("trajectory.tum", {"trajectory": "0.3 0 0 0 0 0 0 -1\n"}),
        ("answer", {"answer": ANSWER | {"goals": [{"outcome": "gave up"}]}}),
    ],
)
def test_one_changed_command_pose_or_answer_differs(tmp_path, name, changed):
    lines = differences(written(tmp_path / "before"), written(tmp_path / "after", **changed))
    assert len(lines) == 1 and lines[0].startswith(f"{name}: ")


def test_a_file_that_is_not_written_any_more_differs(tmp_path):
    before = written(tmp_path / "before")
    after = {key: value for key, value in before.items() if key != "commands.csv"}
    assert len(differences(before, after)) == 1


def test_only_times_and_folders_are_left_out_of_what_is_printed():
    times = {"wall_seconds": 2.0, "tick_ms": 3.0, "ms_p95": 4.0, "reflex_ms_max": 5.0}
    rows = [{"seconds": 3.0, "created": "now", "key": "a", "path": 1.0} | times]
    assert without_times({"rows": rows}) == {"rows": [{"seconds": 3.0, "path": 1.0}]}


@pytest.mark.parametrize(("command", "code"), [(COMMANDS, 0), (COMMANDS + "1,0,0,robot\n", 1)])
def test_it_ends_with_1_where_one_command_differs(tmp_path, monkeypatch, capsys, command, code):
    monkeypatch.setattr(equal_runs, "CHAINS", ((DRIVEN,),))
    monkeypatch.setattr(equal_runs, "git", lambda *arguments: arguments[-1].split("^")[0])

    def results(sources, calls):
        assert calls == (DRIVEN,)
        commands = command if sources.commit == "HEAD" else COMMANDS
        return {"driven": written(tmp_path / sources.commit, commands)}

    monkeypatch.setattr(Sources, "results", results)
    with pytest.raises(typer.Exit) as ended:
        main("abc", out=tmp_path / "kept")
    assert ended.value.exit_code == code
    assert ("commands.csv" in capsys.readouterr().out) == bool(code)
