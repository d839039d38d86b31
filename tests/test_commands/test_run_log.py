"""The log file of a run, and what is shown of log and progress on standard error."""

import logging
import logging.config
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.helpers.served import step
from vizbot.cli.logs import show_events, show_warnings
from vizbot.commands.progress import Progress
from vizbot.commands.run_log import FILE_NAME, PACKAGES, GoalLog, RunLog
from vizbot.core.clock import WallClock
from vizbot.core.errors import DeviceError
from vizbot.core.observer import Effort, GoalReport, Outcome
from vizbot.core.simulated_clock import SimulatedClock

OURS, OTHERS = logging.getLogger("mapping.slam"), logging.getLogger("elsewhere")


def lines(folder):
    return (folder / FILE_NAME).read_text().splitlines()


def test_a_line_has_date_time_level_and_module_and_waits_for_the_folder(tmp_path):
    with RunLog() as log:
        OURS.info("first")
        log.open(tmp_path, WallClock())
        OURS.warning("second %d", 2)
    OURS.warning("when it is over")
    assert [line.split(maxsplit=2)[2] for line in lines(tmp_path)] == [
        "INFO mapping.slam: first",
        "WARNING mapping.slam: second 2",
    ]
    date, time, _ = lines(tmp_path)[0].split(maxsplit=2)
    assert np.datetime64(f"{date}T{time}") <= np.datetime64("now") + np.timedelta64(1, "D")


def test_simulated_time_is_beside_that_of_the_wall(tmp_path):
    clock = SimulatedClock()
    with RunLog() as log:
        log.open(tmp_path, clock)
        clock.sleep(12.0)
        OURS.info("later")
    assert "[   12.000 s] INFO mapping.slam: later" in lines(tmp_path)[0]


def test_of_other_packages_it_has_warnings_alone_and_the_levels_are_as_before(tmp_path):
    before = logging.getLogger("mapping").level
    with RunLog() as log:
        log.open(tmp_path, WallClock())
        OTHERS.info("chatter")
        OTHERS.warning("trouble")
    assert [line.split(": ")[-1] for line in lines(tmp_path)] == ["trouble"]
    assert logging.getLogger("mapping").level == before
    assert not any(isinstance(each, RunLog) for each in logging.getLogger().handlers)


@pytest.mark.parametrize("broken", ["full", "missing"])
def test_a_full_disk_costs_the_log_and_not_the_run(tmp_path, caplog, capsys, broken):
    if broken == "full":
        (tmp_path / FILE_NAME).symlink_to("/dev/full")
    with RunLog() as log:
        log.open(tmp_path if broken == "full" else tmp_path / "nowhere", WallClock())
        for number in range(3):
            OURS.info("line %d", number)
    warned = [each.getMessage() for each in caplog.records if each.levelname == "WARNING"]
    assert len(warned) == 1 and warned[0].startswith("vizbot.log lacks lines: No s")
    assert "Traceback" not in capsys.readouterr().err


def test_a_bug_is_logged_with_its_traceback_and_a_device_that_is_gone_in_one_line(tmp_path):
    for name, error in (("bug", ZeroDivisionError("oops")), ("gone", DeviceError("no camera"))):
        (tmp_path / name).mkdir()
        with pytest.raises(type(error)), RunLog() as log:
            log.open(tmp_path / name, WallClock())
            raise error
    assert "ended by ZeroDivisionError: oops" in lines(tmp_path / "bug")[0]
    assert lines(tmp_path / "bug")[1].startswith("Traceback")
    [line] = lines(tmp_path / "gone")
    assert line.endswith("ended by DeviceError: no camera")


def test_goals_are_logged_when_they_begin_and_end(caplog):
    caplog.set_level(logging.INFO)
    observer = GoalLog()
    for number in range(2):
        observer.on_step(step(number))
    observer.on_goal(GoalReport("sofa", Outcome.ARRIVED, "in sight", (), effort=Effort(50.0, 12.3)))
    observer.on_step(step(2))
    assert [each.getMessage() for each in caplog.records] == [
        "goal begun in step 0: sofa",
        "goal ended: Found the sofa after 50 s, 12 m: in sight",
        "goal begun in step 2: sofa",
    ]


@pytest.fixture
def levels():
    """Put the levels of our packages back."""
    before = {name: logging.getLogger(name).level for name in ("", *PACKAGES)}
    yield
    for name, level in before.items():
        logging.getLogger(name).setLevel(level)


def test_standard_error_shows_warnings_and_on_demand_key_events(
    levels, tmp_path, monkeypatch, capsys
):
    monkeypatch.setattr(logging.getLogger(), "handlers", [])  # as a program finds it
    show_warnings()
    with RunLog() as log:
        log.open(tmp_path, WallClock())
        OURS.info("for the file")
        OURS.warning("for all")
        assert capsys.readouterr().err == "WARNING: for all\n"
        show_events()
        OURS.info("for who asked")
        OTHERS.info("for nobody")
    assert capsys.readouterr().err == "INFO: for who asked\n"
    assert len(lines(tmp_path)) == 3


def test_a_library_that_configures_logging_does_not_end_it(tmp_path):
    with RunLog() as log:
        log.open(tmp_path, WallClock())
        logging.config.dictConfig({"version": 1, "disable_existing_loggers": False})
        OURS.info("still here")
    assert lines(tmp_path)[0].endswith("still here")


def test_paths_of_any_bytes_can_be_logged(tmp_path):
    with RunLog() as log:
        log.open(tmp_path, WallClock())
        record = logging.LogRecord("vizbot", logging.INFO, "", 0, "%s", (Path("caf\udce9"),), None)
        log.emit(record)  # past pytest's own log, which cannot be sent between its processes
    assert lines(tmp_path)[0].endswith("caf\\udce9")


def test_steps_of_a_goal_are_counted_up_to_the_most_and_the_share_seen_is_told(capsys):
    with Progress(1000) as progress:
        for index in range(26):
            progress.on_step(replace(step(index), seen_share=0.25 if index else None))
        progress.on_goal(GoalReport("sofa", Outcome.GAVE_UP, "so it is", ()))
        progress.on_step(replace(step(50), seen_share=0.5))
        progress.on_step(replace(step(75), goal="", seen_share=0.5))
    first, later, _, again, mapping = capsys.readouterr().err.splitlines()
    assert first.startswith("step    1 of 1000  sofa: exploring") and "seen" not in first
    assert later.startswith("step   26 of 1000") and later.endswith("seen 25%")
    assert again.startswith("step    1 of 1000") and again.endswith("seen 50%")
    assert mapping == "frame   75  keyframe 0  exploring  seen 50%"


def test_what_a_step_does_is_told_with_why_in_one_clause(capsys):
    why = "little else is left to see; no place seen so far is worth a closer look"
    with Progress(1000) as progress:
        progress.on_step(replace(step(0), why=why))
    line = capsys.readouterr().err
    assert "sofa: exploring, since little else is left to see  probability 20%" in line
    assert "(enough: 30%)" in line and "worth" not in line
