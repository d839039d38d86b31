"""Spoilt recordings of speech: sound or one line, in bounded time and memory."""

import random
import time
from collections import Counter

import numpy as np
import pytest

from tests.fuzz.sounds import RECORDED, recorded_by
from tests.helpers.memory import peak_kib
from vizbot.operator.voice.sound import SoundError, read_sound

pytestmark = pytest.mark.slow

SHORT, LONG, LONG_SEEDS = 24, 100, range(9)
"""Recordings that are tried, the latter with each of the seeds."""
_SECONDS, _MOST_KIB = 10.0, 200_000
"""Time for one, and growth of this process; what the decoder may keep is tested with it."""


def spoilt(whole, rng):
    """Bits, a piece, a length or a copy of some other place is wrong; the first bytes stay."""
    content, kind = bytearray(whole), rng.randrange(5)
    place = rng.randrange(12, len(content))
    if kind == 0:
        for _ in range(rng.randint(1, 20)):
            content[rng.randrange(12, len(content))] ^= 1 << rng.randrange(8)
    elif kind == 1:  # the head alone, where sizes, rates and codecs stand
        for _ in range(rng.randint(1, 10)):
            content[rng.randrange(12, 400)] = rng.randrange(256)
    elif kind == 2:
        return bytes(content[:place])
    elif kind == 3:
        content[place : place + 4] = rng.choice((bytes(4), b"\xff" * 4, b"\x7f\xff\xff\xff"))
    else:
        other = rng.randrange(len(content))
        content[place : place + 100] = content[other : other + 100]
    return bytes(content)


@pytest.mark.parametrize(
    ("count", "seed"),
    [(SHORT, 0), *(pytest.param(LONG, seed, marks=pytest.mark.long) for seed in LONG_SEEDS)],
)
def test_a_spoilt_recording_of_speech_gives_sound_or_one_line(count, seed):
    whole = {who: recorded_by(who, seconds=1.0) for who in RECORDED}
    became, before = Counter(), peak_kib()
    for number in range(count):
        rng = random.Random(f"{seed} {number}")
        who = list(whole)[number % len(whole)]
        began = time.monotonic()
        try:
            sound = read_sound(spoilt(whole[who], rng), 30.0)
            assert np.isfinite(sound).all() and np.abs(sound).max(initial=0.0) <= 1.0
            became["heard"] += 1
        except SoundError as error:
            assert "\n" not in str(error) and len(str(error)) < 200, (number, error)
            became["refused"] += 1
        assert time.monotonic() - began < _SECONDS, number
    assert became["heard"] and became["refused"]
    assert peak_kib() - before < _MOST_KIB
