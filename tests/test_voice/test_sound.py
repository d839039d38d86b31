import io
import socket
import subprocess
import sys
import wave

import numpy as np
import pytest

from tests.fuzz.sounds import RECORDED, encoded, recorded_by
from tests.helpers.checkout import ROOT
from vizbot.core.program.interpreter import interpreter_command
from vizbot.operator.voice import sound
from vizbot.operator.voice.sound import SoundError, read_sound
from vizbot.operator.voice.sound_decoder import RATE


def recording(rate, samples):
    written = io.BytesIO()
    with wave.open(written, "wb") as file:
        file.setparams((1, 2, rate, 0, "NONE", ""))
        file.writeframes(np.zeros(samples, np.int16).tobytes())
    return written.getvalue()


def test_a_stereo_recording_of_another_rate_is_read(tmp_path):
    path = tmp_path / "stereo.wav"
    with wave.open(str(path), "wb") as file:
        file.setparams((2, 2, 44100, 0, "NONE", ""))
        file.writeframes(np.full((44100, 2), 8192, np.int16).tobytes())
    sound = read_sound(path)
    assert len(sound) == pytest.approx(RATE, abs=100)
    assert np.median(sound) == pytest.approx(0.25, abs=0.01)


@pytest.mark.parametrize("who", RECORDED)
def test_what_browsers_and_programs_record_is_read(who):
    sound = read_sound(recorded_by(who, seconds=2.0), 30.0)
    assert len(sound) == pytest.approx(2 * RATE, abs=0.05 * RATE)
    assert sound.std() == pytest.approx(10_000 / 32768 / np.sqrt(2), rel=0.05)
    spectrum = np.abs(np.fft.rfft(sound))
    assert np.argmax(spectrum) * RATE / len(sound) == pytest.approx(440, abs=2)


@pytest.mark.parametrize("rate", [1, 8, 3999, 192_001, 2**31 - 1])
def test_a_rate_that_no_speech_has_is_refused(rate):
    with pytest.raises(SoundError, match=f"{rate} samples a second.*record with 16000"):
        read_sound(recording(rate, 40_000))


def test_what_comes_too_late_is_not_read():
    assert len(read_sound(recording(8000, 600 * 8000), 1.0)) == RATE


def test_a_recording_shorter_than_the_longest_is_read_whole():
    assert len(read_sound(recording(4000, 8000), 30.0)) == pytest.approx(2 * RATE, abs=100)


def test_a_recorder_that_did_not_know_its_length_is_read_to_the_end():
    wav = bytearray(recording(RATE, RATE))
    for size in (0, 0x80000000, 0xFFFFFFFF):
        wav[40:44] = size.to_bytes(4, "little")
        assert len(read_sound(bytes(wav))) == RATE


def test_what_holds_no_sound_is_refused_and_an_empty_recording_is_silence():
    with pytest.raises(SoundError, match="what was sent holds no sound"):
        read_sound(b"noise")
    assert len(read_sound(recording(RATE, 0))) == 0


@pytest.mark.parametrize(
    ("container", "codec"),
    [("flac", "flac"), ("mp3", "libmp3lame"), ("wav", "adpcm_ima_wav"), ("matroska", "aac"),
     ("mp4", "libmp3lame")],
)  # fmt: skip
def test_no_other_container_and_no_other_codec_is_decoded(container, codec):
    with pytest.raises(SoundError, match="what was sent holds no sound"):
        read_sound(encoded(container, codec))


@pytest.mark.parametrize("who", RECORDED)
@pytest.mark.parametrize("share", [0.01, 0.3, 0.9, 0.999])
def test_a_recording_that_is_cut_short_is_refused(who, share):
    whole = recorded_by(who)
    with pytest.raises(SoundError, match="what was sent is cut short or empty; record it again"):
        read_sound(whole[: int(share * len(whole))])


def test_a_file_that_is_too_large_is_refused_before_it_is_read(tmp_path):
    path = tmp_path / "endless.wav"
    with path.open("wb") as file:
        file.truncate(40 * 10**9)
    with pytest.raises(SoundError, match=r"endless\.wav: 40000 MB are too many"):
        read_sound(path)
    with pytest.raises(SoundError, match=r"no such file"):
        read_sound(tmp_path / "none.wav")


def test_the_decoder_can_open_nothing_and_keep_little():
    program = """
import socket
from vizbot.operator.voice.sound_decoder import confine
confine()
for attempt in (socket.socket, lambda: open("/dev/null"), lambda: bytes(600_000_000)):
    try:
        attempt()
        print("done")
    except (OSError, MemoryError) as error:
        print(type(error).__name__)
"""
    run = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, cwd=ROOT, check=True
    )
    assert run.stdout.split() == ["OSError", "OSError", "MemoryError"]
    socket.socket().close()  # this process still can


def test_a_decoder_that_crashes_is_one_line(monkeypatch):
    command = [sys.executable, "-c", "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)"]
    monkeypatch.setattr(sound, "interpreter_command", lambda *_: command)
    with pytest.raises(SoundError, match="what was sent holds no sound that can be read"):
        read_sound(recording(RATE, RATE))


def test_a_program_of_ours_imports_nothing_from_the_working_directory(tmp_path):
    (tmp_path / "av.py").write_text("raise SystemExit(9)")
    command = interpreter_command("vizbot.operator.voice.sound_decoder", "wav", "1.0")
    wav = recording(RATE, 100)
    done = subprocess.run(command, input=wav, cwd=tmp_path, capture_output=True, check=True)
    assert len(done.stdout) == 200
