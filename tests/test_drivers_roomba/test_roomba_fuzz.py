"""Random and spoilt bytes: into the decoder of the stream, and into the simulated base."""

import random

import pytest

from drivers.roomba.packets import Packet
from drivers.roomba.state import STREAMED
from drivers.roomba.stream import StreamParser, encode_sensor_frame
from sim_stubs.roomba.base import SimulatedRoomba
from sim_stubs.world.body import FreeFloor
from vizbot.core.types import BaseMode

CHUNK = 1000
SIZES = [200_000, pytest.param(10_000_000, marks=pytest.mark.long)]


def frame(rng):
    values = dict.fromkeys(STREAMED, 0)
    values[Packet.LEFT_ENCODER] = rng.randrange(-32768, 32768)
    values[Packet.RIGHT_ENCODER] = rng.randrange(-32768, 32768)
    values[Packet.OI_MODE] = rng.randrange(4)
    return values


@pytest.mark.parametrize("size", SIZES)
def test_random_bytes_make_no_frame(size):
    # A frame has 28 bytes that are fixed: by chance it comes once in 256**28 places.
    rng, parser = random.Random(1), StreamParser(STREAMED)
    for _ in range(size // CHUNK):
        assert parser.feed(rng.randbytes(CHUNK)) == []


@pytest.mark.parametrize("size", SIZES)
def test_a_spoilt_frame_is_taken_for_sound_no_oftener_than_its_checksum_lets_it(size):
    # One that keeps its fixed bytes has a checksum that fits by chance once in 256 times; two
    # bytes that are spoilt must do that between them, one alone never does. Where bytes are lost or
    # come twice, most fixed ones are not where they belong. A sound frame is always made out.
    rng, parser = random.Random(2), StreamParser(STREAMED)
    wrong = spoilt = sound = fed = 0
    while fed < size:
        sent = frame(rng)
        encoded = bytearray(encode_sensor_frame(STREAMED, sent))
        places = rng.sample(range(len(encoded)), rng.choice((0, 1, 2, 5)))
        kinds = [rng.choice(("spoil", "lose", "repeat")) for _ in places]
        for place, kind in zip(sorted(places, reverse=True), kinds, strict=True):
            match kind:
                case "spoil":
                    encoded[place] ^= rng.randrange(1, 256)
                case "lose":
                    del encoded[place]
                case "repeat":
                    encoded.insert(place, encoded[place])
        fed += len(encoded)
        received = parser.feed(bytes(encoded))
        if not places:
            sound += 1
            assert received[-1:] == [sent]
        elif kinds == ["spoil"]:
            assert received == []
        spoilt += bool(places)
        wrong += sum(values != sent for values in received)
    assert sound > size / 61 / 5
    assert wrong < 2.0 * spoilt / 256


@pytest.mark.parametrize("size", [20_000, pytest.param(1_000_000, marks=pytest.mark.long)])
def test_random_commands_never_end_the_simulated_base(size):
    rng, floor = random.Random(3), FreeFloor()
    with SimulatedRoomba(floor) as stub:
        for _ in range(size // 20):
            sent = bytearray(rng.randbytes(20))
            if rng.random() < 0.5:
                sent[0:0] = bytes(rng.choices((128, 131, 132, 137, 145, 148, 140, 149), k=4))
            for command in stub._commands.feed(bytes(sent)):
                if not stub.asleep:
                    stub._obey(command)
            stub.advance(0.015)
            stub.publish()
            assert stub.mode in BaseMode
            assert all(abs(speed) <= 500.0 for speed in stub._wheels._speeds_mm_s)
