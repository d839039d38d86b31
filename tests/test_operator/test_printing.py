"""Texts of others are printed so that they cannot steer the terminal."""

import json
import logging
import sys
from dataclasses import replace
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mapping.map_bundle import save
from tests.helpers.bundles import bundle_of
from vizbot.commands import doctor, remote
from vizbot.commands.map import describe
from vizbot.commands.progress import Progress
from vizbot.commands.run_log import RunLog
from vizbot.core.clock import WallClock
from vizbot.core.observer import GoalReport, Outcome
from vizbot.doctor import Finding, Grade
from vizbot.operator.client.robot_client import RobotClient
from vizbot.operator.printing import PrintableFormatter, echo, printable

STEERING = "\x1b]0;owned\x07\x1b[2J\x9b31m\r\u202e"
SHOWN = r"\u001b]0;owned\u0007\u001b[2J\u009b31m\u000d\u202e"

CONTROLS = set("\x1b\x07\x9b\r\u202e")


def require_shown(text):
    assert SHOWN in text.replace(r" \u202e", r"\u000d\u202e")  # a line's text has one line
    assert not set(text) & CONTROLS


@pytest.mark.slow
@given(st.text())
def test_what_is_printable_steers_nothing_and_says_the_same(text):
    shown = printable(text)
    shown.encode()
    assert not any((ord(c) < 32 and c not in "\t\n") or 127 <= ord(c) < 160 for c in shown)
    assert printable(shown) == shown
    assert json.loads(printable(json.dumps(text, ensure_ascii=False))) == json.loads(
        json.dumps(text)
    )


def test_words_of_any_language_and_tables_are_printed_as_they_are(capsys):
    echo("Küche\tキッチン\nمطبخ 🛋")
    assert capsys.readouterr().out == "Küche\tキッチン\nمطبخ 🛋\n"


def test_a_map_cannot_steer_the_terminal_by_its_notice_or_model(tmp_path, capsys):
    save(replace(bundle_of(), notice=STEERING, model_id=STEERING), tmp_path / "home")
    describe(tmp_path / "home", as_json=False)
    printed = capsys.readouterr()
    require_shown(printed.out)
    require_shown(printed.err)
    describe(tmp_path / "home", as_json=True)
    assert json.loads(capsys.readouterr().out)["notice"] == " ".join(STEERING.split())


def test_an_error_cannot_steer_the_terminal_by_the_name_of_a_map(tmp_path, command_line):
    _, _, said = command_line("map", "info", tmp_path / STEERING)
    assert SHOWN.partition(r"\u000d")[0] in said
    assert not set(said) & CONTROLS


@pytest.mark.slow
def test_a_goal_cannot_steer_the_terminal_of_who_asks_for_the_state(session, server, capsys):
    session.ask([STEERING])
    with RobotClient(server.url, None) as client:
        remote.status(client, as_json=False)
        state = client.state()
    printed = capsys.readouterr().out
    assert "owned" in printed and not set(printed) & CONTROLS
    # What answers may be another program, which lets everything through.
    goal = state["goals"][0] | {"text": STEERING, "outcome": "arrived", "reason": STEERING}
    remote.status(
        SimpleNamespace(state=lambda: state | {"goals": [goal], "activity": STEERING}),
        as_json=False,
    )
    printed = capsys.readouterr().out
    require_shown(printed)
    assert printed.count(SHOWN) == 3


def test_progress_and_doctor_cannot_steer_the_terminal(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    Progress().on_goal(GoalReport("chair", Outcome.GAVE_UP, STEERING, ()))
    require_shown(capsys.readouterr().err)
    finding = Finding("camera", Grade.GOOD, f"[bold]{STEERING}", "")
    doctor._print([finding])
    printed = capsys.readouterr().out
    require_shown(printed)
    assert "[bold]" in printed


def test_a_log_line_and_its_traceback_cannot_steer_the_terminal(tmp_path):
    try:
        raise ValueError(STEERING)
    except ValueError:
        caught = sys.exc_info()
    record = logging.LogRecord("vizbot", logging.WARNING, "", 1, "%s", (STEERING,), caught)
    line = PrintableFormatter("\x1b[K%(levelname)s: %(message)s").format(record)
    assert line.startswith("\x1b[KWARNING: ")
    require_shown(line.removeprefix("\x1b[K"))
    with RunLog() as log:
        log.open(tmp_path, WallClock())
        logging.getLogger("vizbot.commands").warning("goal: %s", STEERING)
    require_shown((tmp_path / "vizbot.log").read_text())
