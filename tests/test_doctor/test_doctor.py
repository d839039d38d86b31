"""What the doctor finds on a machine, with devices or without; how it reports it, and how fast."""

import json
import math
import re
import subprocess
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from transformers import CLIPVisionModel
from typer.testing import CliRunner

from mapping.clip.encoder import untrained_images
from tests.helpers.failing import raising
from vizbot import doctor
from vizbot.cli import app as cli
from vizbot.commands.doctor import require_well
from vizbot.config import Config
from vizbot.core.clock import WallClock
from vizbot.core.errors import DeviceError
from vizbot.core.simulated_clock import SimulatedClock
from vizbot.doctor import Finding, Grade, examine


def test_a_machine_without_devices_gets_one_remedy_each(tmp_path):
    config = Config(serial_port="/dev/ttyNONE", clip="ViT-B/32")
    findings = {each.subject: each for each in examine(config, WallClock(), tmp_path / "runs")}
    for subject, remedy in (("serial port", "cable"), ("camera", "USB 3"), ("CLIP", "hf download")):
        assert findings[subject].verdict is Grade.BAD
        assert remedy in findings[subject].remedy
    assert findings["disk"].verdict is not Grade.BAD


@pytest.fixture
def silent_clock(monkeypatch):
    """A clock by which no check answers."""
    clock = SimulatedClock()
    start = clock.start
    monkeypatch.setattr(clock, "start", lambda _check, _latency: start(list, math.inf))
    return clock


def test_it_is_done_within_20_s_when_nothing_answers(silent_clock, tmp_path):
    findings = examine(Config(), silent_clock, tmp_path)
    assert silent_clock.now() < 20.0
    subjects = ["base", "camera", "CLIP", "clock", "disk", "microphone"]
    assert [each.subject for each in findings] == subjects
    assert all(each.verdict is Grade.BAD and each.remedy for each in findings)


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
    assert hung.verdict is Grade.BAD and "no answer" in hung.found


def test_what_raises_does_not_either(tmp_path, monkeypatch):
    broken = raising(RuntimeError("xioctl failed,\n errno=5"))
    monkeypatch.setattr("vizbot.doctor._time", broken)
    findings = examine(Config(serial_port="/dev/ttyNONE"), WallClock(), tmp_path)
    [clock] = [each for each in findings if each.subject == "clock"]
    assert clock.verdict is Grade.BAD and clock.found == "xioctl failed, errno=5"
    assert {"disk", "serial port"} <= {each.subject for each in findings}


@pytest.mark.parametrize(
    ("synchronised", "verdict", "remedy"),
    [("yes\n", Grade.GOOD, ""), ("no\n", Grade.POOR, "set-ntp true"), ("", Grade.GOOD, ""),
     (None, Grade.GOOD, "")],
)  # fmt: skip
def test_a_clock_that_is_known_not_to_be_synchronised_is_poor(
    monkeypatch, synchronised, verdict, remedy
):
    def ask(command, timeout, **_settings):
        if synchronised is None:
            raise subprocess.TimeoutExpired(command, timeout)
        return subprocess.CompletedProcess(command, 0, stdout=synchronised)

    monkeypatch.setattr("shutil.which", lambda name: name)
    monkeypatch.setattr("subprocess.run", ask)
    [finding] = doctor._time()
    assert finding.verdict is verdict and remedy in finding.remedy
    assert ("not synchronised" in finding.found) == (verdict is Grade.POOR)


@pytest.mark.parametrize(
    ("free", "verdict"), [(0.9, Grade.BAD), (4.9, Grade.POOR), (5.1, Grade.GOOD)]
)
def test_a_disk_is_judged_by_its_space_where_runs_will_be_kept(
    tmp_path, monkeypatch, free, verdict
):
    usage = {tmp_path: SimpleNamespace(free=free * 1e9)}
    monkeypatch.setattr("shutil.disk_usage", usage.__getitem__)
    [finding] = doctor._disk(tmp_path / "robot" / "runs")
    assert finding.verdict is verdict and f"{free} GB free" in finding.found
    assert finding.remedy == ("" if verdict is Grade.GOOD else "delete old runs")


@pytest.mark.parametrize(
    ("sound", "verdict", "found"),
    [
        ("00-03: HDMI 0 : HDMI 0 : playback 1\n", Grade.POOR, "none"),
        ("00-03: HDMI 0 : HDMI 0 : playback 1\n01-00: USB Audio : USB Audio : capture 1\n",
         Grade.GOOD, "USB Audio"),
        (None, Grade.POOR, "none"),
    ],
)  # fmt: skip
def test_a_microphone_is_what_captures(monkeypatch, sound, verdict, found):
    def read(path, **_settings):
        if sound is None:
            raise FileNotFoundError(path)
        return sound

    monkeypatch.setattr(Path, "read_text", read)
    [finding] = doctor._microphone()
    assert finding.verdict is verdict and finding.found == found
    assert ("plug one in" in finding.remedy) == (verdict is Grade.POOR)


@pytest.fixture
def timed(monkeypatch, mean_colours):
    """Has an encoder timed with some settings.

    `took` is the time that a number of patches takes after batches of some sizes. Returns what is
    found, by which names the encoder was opened, and the sizes of all batches.
    """

    def timed(took=lambda count, before: 0.0, **settings):
        clock, asked, sizes = SimulatedClock(period=0.001), [], []

        def embed_images(images):
            clock.sleep(took(len(images), sizes))
            sizes.append(len(images))
            return mean_colours.embed_images(images)

        encoder = SimpleNamespace(model_id="slow", notice=None, embed_images=embed_images)
        monkeypatch.setattr("vizbot.doctor.require_encoder", lambda *_: None)
        monkeypatch.setattr(
            "vizbot.doctor.open_encoder", lambda *name: asked.append(name) or encoder
        )
        clip, _ = doctor._encoder(Config.model_validate(settings), clock, doctor._Trial(), False)
        return clip, asked, sizes

    return timed


@pytest.mark.parametrize(
    ("seconds", "verdict", "shown"),
    [
        (0.9, Grade.GOOD, ", 900 ms"),
        (1.0, Grade.POOR, ", 1.0 s"),
        (4.9, Grade.POOR, ", 4.9 s"),
        (53.0, Grade.POOR, ", about 53.0 s"),
    ],
)
def test_an_encoder_that_takes_a_second_or_more_for_a_frame_is_poor(timed, seconds, verdict, shown):
    settings = {"clip": "ViT-L/14", "device": "auto", "half": True}
    clip, asked, sizes = timed(lambda count, _: seconds * count / 25, **settings)
    assert asked == [("ViT-L/14", "auto", True)]
    assert clip.verdict is verdict and f"{shown} a frame (25 patches)" in clip.found
    assert sum(sizes) == (2 if seconds > 5 else 26 if verdict is Grade.POOR else 51)
    for remedy in ("smaller encoder", 'device = "cuda"', "scales"):
        assert (remedy in clip.remedy) == (verdict is Grade.POOR)


def test_a_gpu_that_prepares_itself_for_the_first_batch_of_a_size_is_timed_by_the_second(timed):
    def took(count, before):
        return 0.017 if count in before else 0.14

    clip, _, sizes = timed(took, clip="ViT-L/14")
    assert "17 ms a frame (25 patches)" in clip.found
    assert sizes == [1, 25, 25]


def test_fewer_scales_are_fewer_patches(timed):
    clip, *_ = timed(clip="ViT-B/32", perception={"clip_mapper": {"scales": [0]}})
    assert "a frame (4 patches)" in clip.found


@pytest.mark.parametrize(
    ("embeds_after", "found", "remedy"),
    [(None, "not loaded after 100 s", ""), (20.0, "over 1000 s a frame", "smaller encoder")],
)
def test_an_encoder_that_does_not_end_is_poor_by_what_it_took_so_far(
    silent_clock, tmp_path, monkeypatch, embeds_after, found, remedy
):
    trial = doctor._Trial(silent_clock.now())
    if embeds_after is not None:
        trial.first_patch = trial.began + embeds_after
    monkeypatch.setattr(doctor, "_Trial", lambda: trial)
    findings = examine(Config(clip="ViT-L/14"), silent_clock, tmp_path)
    [clip] = [each for each in findings if each.subject == "CLIP"]
    assert clip.verdict is Grade.POOR
    assert clip.found == f"ViT-L/14: {found}" and remedy in clip.remedy


@pytest.mark.slow
@pytest.mark.parametrize(("asked", "verdict"), [(False, Grade.BAD), (True, Grade.POOR)])
def test_the_rehearsal_encoder_is_bad_before_a_real_camera_unless_it_is_asked_for(asked, verdict):
    config = Config.model_validate({"perception": {"clip_mapper": {"scales": [1]}}})
    clip, _ = doctor._encoder(config, WallClock(), doctor._Trial(), asked)
    assert clip.verdict is verdict
    assert "is the rehearsal encoder, which knows simulated homes alone" in clip.found
    assert "hf download openai/clip-vit-base-patch32" in clip.remedy
    assert re.search(r"\d (ms|s) a frame \(1 patches\) on cpu here", clip.remedy)
    assert ("--clip embedded" in clip.remedy) == (not asked)


def test_the_published_tower_is_timed_without_weights_and_as_large_as_it_is(monkeypatch):
    sizes = []
    call = CLIPVisionModel.forward

    def count(tower, *rest, **named):
        sizes.append(
            (sum(each.numel() for each in tower.parameters()), named["pixel_values"].shape)
        )
        return call(tower, *rest, **named)

    monkeypatch.setattr(CLIPVisionModel, "forward", count)
    untrained_images("cpu", False)([np.zeros((40, 60, 3), np.uint8)])
    assert sizes == [(87_456_000, (1, 3, 224, 224))]


def test_launch_refuses_what_is_bad_in_one_line():
    poor = Finding("microphone", Grade.POOR, "none", "plug one in")
    require_well([poor])
    with pytest.raises(DeviceError, match=r"^camera: none found; plug it in; launch .* --force$"):
        require_well([poor, Finding("camera", Grade.BAD, "none found", "plug it in")])


@pytest.mark.parametrize("verdict", Grade)
def test_the_command_prints_a_table_or_json_and_exits_by_what_is_bad(monkeypatch, verdict):
    finding = Finding("disk", verdict, "3 GB free", "delete old runs")
    monkeypatch.setattr("vizbot.commands.doctor.examine", lambda *_: [finding])
    table = CliRunner().invoke(cli.app, ["doctor"])
    assert verdict.value in table.output and "delete old runs" in table.output
    as_json = CliRunner().invoke(cli.app, ["doctor", "--json"])
    well = verdict is not Grade.BAD
    assert json.loads(as_json.output)["well"] == well
    assert json.loads(as_json.output)["findings"][0]["found"] == "3 GB free"
    assert (table.exit_code == 0) == (as_json.exit_code == 0) == well
