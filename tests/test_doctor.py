"""What the doctor finds, on simulated devices and on machines that lack them."""

import json

import pytest
from typer.testing import CliRunner

from vizbot import cli
from vizbot.commands.doctor import require_well
from vizbot.config import Config
from vizbot.core.clock import WallClock
from vizbot.core.errors import DeviceError
from vizbot.doctor import Finding, Verdict, examine


def test_a_machine_without_devices_gets_one_remedy_each(tmp_path):
    config = Config(serial_port="/dev/ttyNONE", clip="ViT-B/32")
    findings = {each.subject: each for each in examine(config, WallClock(), tmp_path / "runs")}
    for subject, remedy in (("serial port", "cable"), ("camera", "USB 3"), ("CLIP", "hf download")):
        assert findings[subject].verdict is Verdict.BAD
        assert remedy in findings[subject].remedy
    assert findings["disk"].verdict is not Verdict.BAD


def test_what_hangs_does_not_keep_the_rest_from_being_told(tmp_path, monkeypatch):
    clock = WallClock()

    def hang(config, clock):
        clock.sleep(30.0)
        yield

    monkeypatch.setattr("vizbot.doctor._camera", hang)
    monkeypatch.setattr("vizbot.doctor.TIMEOUT", 0.5)
    began = clock.now()
    findings = examine(Config(serial_port="/dev/ttyNONE"), clock, tmp_path)
    assert clock.now() - began < 15.0
    [hung] = [each for each in findings if each.subject == "camera"]
    assert hung.verdict is Verdict.BAD and "no answer" in hung.found


def test_what_raises_does_not_either(tmp_path, monkeypatch):
    def broken():
        raise RuntimeError("xioctl failed,\n errno=5")
        yield

    monkeypatch.setattr("vizbot.doctor._time", broken)
    findings = examine(Config(serial_port="/dev/ttyNONE"), WallClock(), tmp_path)
    [clock] = [each for each in findings if each.subject == "clock"]
    assert clock.verdict is Verdict.BAD and clock.found == "xioctl failed, errno=5"
    assert {"disk", "serial port"} <= {each.subject for each in findings}


def test_launch_refuses_what_is_bad_in_one_line():
    poor = Finding("microphone", Verdict.POOR, "none", "plug one in")
    require_well([poor])
    with pytest.raises(DeviceError, match=r"^camera: none found; plug it in; launch .* --force$"):
        require_well([poor, Finding("camera", Verdict.BAD, "none found", "plug it in")])


@pytest.mark.parametrize("verdict", Verdict)
def test_the_command_prints_a_table_or_json_and_exits_by_what_is_bad(monkeypatch, verdict):
    finding = Finding("disk", verdict, "3 GB free", "delete old runs")
    monkeypatch.setattr("vizbot.commands.doctor.examine", lambda *_: [finding])
    table = CliRunner().invoke(cli.app, ["doctor"])
    assert verdict.value in table.output and "delete old runs" in table.output
    told = CliRunner().invoke(cli.app, ["doctor", "--json"])
    well = verdict is not Verdict.BAD
    assert json.loads(told.output)["well"] == well
    assert json.loads(told.output)["findings"][0]["found"] == "3 GB free"
    assert (table.exit_code == 0) == (told.exit_code == 0) == well
