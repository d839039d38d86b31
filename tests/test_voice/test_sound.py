import io
import wave

import numpy as np
import pytest

from vizbot.core.errors import ConfigError
from vizbot.operator.voice.recogniser import RATE, read_sound


def recording(rate, samples):
    written = io.BytesIO()
    with wave.open(written, "wb") as file:
        file.setparams((1, 2, rate, 0, "NONE", ""))
        file.writeframes(np.zeros(samples, np.int16).tobytes())
    return io.BytesIO(written.getvalue())


def test_a_stereo_recording_of_another_rate_is_read(tmp_path):
    path = tmp_path / "stereo.wav"
    with wave.open(str(path), "wb") as file:
        file.setparams((2, 2, 44100, 0, "NONE", ""))
        file.writeframes(np.full((44100, 2), 8192, np.int16).tobytes())
    sound = read_sound(path)
    assert len(sound) == pytest.approx(RATE, abs=100)
    assert np.median(sound) == pytest.approx(0.25, abs=0.01)


@pytest.mark.parametrize("rate", [1, 8, 3999])
def test_a_rate_that_no_speech_has_is_refused(rate):
    with pytest.raises(ConfigError, match=f"{rate} samples a second.*record with 16000"):
        read_sound(recording(rate, 40_000))


def test_what_comes_too_late_is_not_read():
    sound = recording(8000, 600 * 8000)
    assert len(read_sound(sound, 1.0)) == RATE
    assert sound.tell() < 100_000


def test_a_recording_shorter_than_the_longest_is_read_whole():
    assert len(read_sound(recording(4000, 8000), 30.0)) == pytest.approx(2 * RATE, abs=100)


def test_what_holds_no_sound_is_refused_and_an_empty_recording_is_silence():
    with pytest.raises(ConfigError, match="what was sent holds no sound"):
        read_sound(io.BytesIO(b"noise"))
    assert len(read_sound(recording(RATE, 0))) == 0
