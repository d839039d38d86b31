import io
import json
import sys
from functools import cache, partial
from types import SimpleNamespace

import numpy as np
import pytest
import typer

from tests.helpers.served import served
from tests.helpers.spoken import (
    BUILDING,
    FINAL,
    SpokenSample,
    missions,
    record,
    ruled,
    speak,
    speaking,
    utterances,
)
from tests.tools.hearing import HELD_OUT, heard, stop_samples, understood
from vizbot.commands import voice
from vizbot.commands.dispatch import CommandSender
from vizbot.core.errors import ConfigError, DeviceError, DeviceTimeoutError
from vizbot.operator.language.command import GoTo, Stop
from vizbot.operator.session.vocabulary import HOUSEHOLD
from vizbot.operator.voice.endpointing import Listener
from vizbot.operator.voice.intent import Hypothesis, choose_utterance
from vizbot.operator.voice.microphone import Microphone
from vizbot.operator.voice.recogniser import Recogniser
from vizbot.operator.voice.sound import read_sound
from vizbot.operator.voice.sound_decoder import RATE


@pytest.fixture(scope="module")
def recogniser(whisper):
    return Recogniser(HOUSEHOLD, whisper)


@pytest.fixture
def run(command_line):
    return partial(command_line, "voice")


@pytest.mark.slow
@speaking
def test_a_spoken_command_is_printed_as_json(run, whisper, tmp_path):
    said = SpokenSample("go to the kitchen, then the sofa", "en-us", 150, None)
    code, out, err = run("--wav", record(said, tmp_path), "--speech", whisper, "--json")
    assert code == 0, err
    command = {"name": "go to", "goals": ["kitchen", "sofa"], "after": None}
    assert json.loads(out)["command"] == command
    assert "No robot runs on this machine" in err


@pytest.mark.slow
@speaking
def test_the_robot_of_this_machine_obeys(run, session, whisper, tmp_path, monkeypatch):
    with served(session) as server:
        monkeypatch.setattr(voice, "HERE", server.url)
        wav = record(SpokenSample("stop", "en-us", 150, None), tmp_path)
        code, out, err = run("--wav", wav, "--speech", whisper)
    assert (code, err) == (0, "")
    assert session.stopped.is_set() and "stopped" in out


@pytest.fixture(scope="module")
def rate(recogniser, tmp_path_factory):
    """How often what was meant was understood without a question; None: no noise."""
    folder = tmp_path_factory.mktemp("speech")
    kinds = {
        "commands": utterances(HELD_OUT),
        "stop": stop_samples(),
        "building": [*ruled(*BUILDING), *missions(*BUILDING)],
        "final": [*ruled(*FINAL), *missions(*FINAL)],
    }

    @cache
    def rate_of(kind, decibels):
        return understood(heard(recogniser, kinds[kind], decibels, folder)).value

    return rate_of


@speaking
@pytest.mark.long
def test_stop_is_always_understood_where_it_is_quiet(rate):
    assert rate("stop", None) == 1.0


@speaking
@pytest.mark.long
@pytest.mark.parametrize(("decibels", "least"), [(20, 0.9), (10, 0.8)])
def test_stop_is_understood_in_noise(rate, decibels, least):
    assert rate("stop", decibels) >= least


@speaking
@pytest.mark.long
@pytest.mark.parametrize("kind", ["commands", "building", "final"])
@pytest.mark.parametrize(("decibels", "least"), [(None, 0.95), (10, 0.85)])
def test_intent_and_goals_are_understood(rate, kind, decibels, least):
    assert rate(kind, decibels) >= least


@pytest.mark.slow
@speaking
def test_what_the_map_does_not_find_may_still_be_asked_for(recogniser, tmp_path):
    speech = speak(SpokenSample("find the lamp", "en-us", 150, None), tmp_path)
    recogniser.learn(["sofa", "no phrase of its vocabulary"])
    heard = recogniser.hear(speech)
    recogniser.learn([])
    assert heard.command == GoTo(("lamp",))


@pytest.mark.slow
@speaking
def test_stop_is_heard_in_the_middle_of_speech(recogniser, tmp_path):
    said = SpokenSample("go to the kitchen, no, stop, stop", "en-us", 150, None)
    listener = Listener(recogniser, "hey robot")
    speech = speak(said, tmp_path)[: -RATE // 2]
    heard = [listener.take(block) for block in np.array_split(speech, len(speech) // 1600)]
    assert Stop() in [each.command for each in heard if each is not None]


@speaking
def test_what_whisper_repeats_faster_than_anybody_speaks_is_not_believed_but_a_stop_is(
    recogniser, tmp_path, monkeypatch
):
    speech = speak(SpokenSample("back", "en-us", 150, None), tmp_path)
    for text, command in (("Come back. " * 8, None), ("Stop. " * 12, Stop())):
        repeated = [Hypothesis(text.strip(), -0.1)]
        monkeypatch.setattr(recogniser, "_generated", lambda *_, repeated=repeated: repeated)
        assert recogniser.hear(speech).command == command


def test_silence_and_noise_are_no_command(recogniser):
    noise = np.random.default_rng(0).normal(scale=0.01, size=3 * RATE).astype(np.float32)
    for sound in (np.zeros(RATE, np.float32), noise, np.zeros(0, np.float32)):
        assert recogniser.hear(sound).command is None


def test_what_cannot_be_read_is_refused(tmp_path):
    torn = tmp_path / "torn.wav"
    torn.write_bytes(b"RIFF....WAVEfmt nothing of the kind")
    for path in (torn, tmp_path, tmp_path / "none.wav"):
        with pytest.raises(ConfigError, match=path.name):
            read_sound(path)


def test_a_missing_model_is_one_line(tmp_path):
    for name in ("no-such-size", str(tmp_path)):
        with pytest.raises(ConfigError, match=name) as error:
            Recogniser(HOUSEHOLD, name)
        assert "\n" not in str(error.value)


def test_missing_packages_are_named_with_the_remedy(monkeypatch, whisper):
    monkeypatch.setitem(sys.modules, "faster_whisper", None)
    monkeypatch.setitem(sys.modules, "sounddevice", None)
    with pytest.raises(ConfigError, match=r"faster-whisper.*pip install"):
        Recogniser(HOUSEHOLD, whisper)
    with pytest.raises(ConfigError, match=r"sounddevice.*pip install"):
        Microphone()


def port_audio(blocks):
    """As much of `sounddevice` as a microphone needs; `blocks` are recorded when it starts."""

    def stream(*, callback, **_):
        def start():
            if blocks is None:
                raise OSError("Error querying device -1")
            for block in blocks:
                callback(block, len(block), None, None)

        return SimpleNamespace(start=start, close=lambda: None)

    return SimpleNamespace(PortAudioError=OSError, InputStream=stream)


def test_a_missing_microphone_is_one_line(monkeypatch):
    monkeypatch.setitem(sys.modules, "sounddevice", port_audio(None))
    with pytest.raises(DeviceError, match=r"device -1.*plug one in"):
        Microphone()


def test_the_microphone_gives_what_was_recorded_in_order(monkeypatch):
    blocks = [np.full((1600, 1), value, np.float32) for value in (0.1, 0.2, 0.3)]
    monkeypatch.setitem(sys.modules, "sounddevice", port_audio(blocks))
    with Microphone() as microphone:
        assert microphone.read()[0] == np.float32(0.1)
        assert len(microphone.drain()) == 3200
        assert len(microphone.drain()) == 0
        with pytest.raises(DeviceTimeoutError, match="microphone"):
            microphone.read(timeout=0.0)


def test_a_microphone_that_nobody_reads_keeps_the_last_minute(monkeypatch):
    blocks = [np.full((1600, 1), place, np.float32) for place in range(700)]
    monkeypatch.setitem(sys.modules, "sounddevice", port_audio(blocks))
    sound = Microphone().drain()
    assert len(sound) == 60 * RATE
    assert sound[-1] == 699


def test_a_doubt_is_asked_and_a_yes_settles_it(monkeypatch, capsys):
    microphone = SimpleNamespace(drain=lambda: np.zeros(RATE, np.float32))
    said = iter([Hypothesis("Go to the nighting table.", -0.1), Hypothesis("Yes.", -0.1)])
    ear = SimpleNamespace(hear=lambda sound: choose_utterance([next(said)], [], HOUSEHOLD))
    monkeypatch.setattr(voice, "_enter", lambda: None)
    with pytest.raises(StopIteration), CommandSender(None) as sender:
        voice._converse(microphone, ear, None, sender)
    asked, told = capsys.readouterr().out.splitlines()
    assert asked == 'did you mean "dining table"?'
    assert told == "command: go to dining table"


class Talk:
    """Of people near a robot that is doubtful; ends with `StopIteration`.

    Each is what is said and how long after what was said before [s].
    """

    def __init__(self, *said):
        self.said, self.time, self.told = iter(said), 0.0, []

    def take(self, sound):
        text, later = next(self.said)
        self.time += later
        return choose_utterance([Hypothesis(text, -0.1)], [], HOUSEHOLD, "hey robot")

    def say(self, text, who, *, at_once):
        self.told.append(text)
        return {"said": [f"asked for: {text}"], "numbers": [1]}

    def doubt(self, question):
        pass


DOUBTFUL = "Hey robot, go to the nighting table.", 0.0


@pytest.mark.parametrize(
    ("said", "told"),
    [([DOUBTFUL, ("Yes, that one.", 14.0)], ["go to dining table"]),
     ([DOUBTFUL, ("Yes.", 16.0)], []),
     ([DOUBTFUL, ("No.", 1.0), ("Yes.", 1.0)], []),
     ([DOUBTFUL, ("Hey robot, no.", 1.0), ("Hey robot, no.", 1.0)], ["no"]),
     ([DOUBTFUL, ("Nice weather today.", 1.0), ("Yes.", 1.0)], []),
     ([DOUBTFUL, ("Right, let us have dinner.", 1.0), ("Yes.", 1.0)], []),
     ([DOUBTFUL, DOUBTFUL, ("Yes.", 1.0), ("Yes.", 1.0)], ["go to dining table"])],
)  # fmt: skip
def test_a_doubt_ends_with_what_is_said_next_and_after_a_while(monkeypatch, said, told):
    talk = Talk(*said)
    quiet = SimpleNamespace(read=lambda: np.zeros(1), drain=lambda: np.zeros(1))
    monkeypatch.setattr(voice, "Listener", lambda *_: talk)
    with pytest.raises(StopIteration), CommandSender(talk) as sender:
        voice._converse(quiet, None, "hey robot", sender, lambda: talk.time)
    assert talk.told == told


def test_a_byte_that_is_no_text_does_not_end_the_listening(monkeypatch):
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(b"\xff\n"), "utf-8"))
    voice._enter()
    with pytest.raises(typer.Exit):
        voice._enter()
