"""Stream frames against literal bytes: vectors R1 to R9, R15 and R17 of the fact sheet."""

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from drivers.roomba.odometry import counts_between
from drivers.roomba.packets import Packet
from drivers.roomba.stream import StreamParser, encode_sensor_frame
from tests.helpers.roomba_host import R17

R1 = [19, 5, 29, 2, 25, 13, 0, 163]
R4 = [19, 10, 7, 3, 35, 2, 43, 127, 255, 44, 128, 0, 95]
R5 = [19, 10, 7, 0, 35, 2, 43, 128, 0, 44, 127, 255, 98]
STREAM_FRAMES = {
    "R1": (R1, {29: 537, 13: 0}),
    "R2": ([19, 5, 29, 2, 37, 13, 0, 151], {29: 549, 13: 0}),
    "R4": (R4, {7: 3, 35: 2, 43: 32767, 44: -32768}),
    "R5": (R5, {7: 0, 35: 2, 43: -32768, 44: 32767}),
    "R6": ([19, 3, 22, 19, 19, 174], {22: 4883}),
    "R8": ([19, 6, 43, 255, 255, 44, 0, 0, 146], {43: -1, 44: 0}),
    "R9": ([19, 81, 100, *[0] * 80, 56], dict.fromkeys(range(7, 59), 0)),
    "R15": ([19, 3, 22, 58, 154, 0], {22: 15002}),
}


@pytest.mark.parametrize("vector", STREAM_FRAMES)
def test_stream_frames_decode_and_encode(vector):
    frame, values = STREAM_FRAMES[vector]
    ids = [100] if vector == "R9" else list(values)
    assert StreamParser().feed(bytes(frame)) == [values]
    assert StreamParser(ids).feed(bytes(frame)) == [values]
    assert list(encode_sensor_frame(ids, values)) == frame


@pytest.mark.parametrize(
    ("ids", "spoilt"),
    [
        (None, [19, 5, 29, 2, 25, 13, 0, 162]),
        ((29, 13), [19, 5, 29, 2, 25, 13, 0, 162]),
        (None, [19, 5, 29]),
        ((29, 13), [19, 5, 29]),
        ((29, 13), [19, 255]),
    ],
    ids=["checksum", "checksum, known", "truncated", "truncated, known", "length, known"],
)
def test_a_spoilt_frame_is_skipped_and_the_next_one_found(ids, spoilt):
    parser = StreamParser(ids)
    assert parser.feed(bytes(spoilt)) == []
    assert parser.feed(bytes(R1)) == [{29: 537, 13: 0}]
    assert StreamParser(ids).feed(bytes(spoilt + R1)) == [{29: 537, 13: 0}]


def test_a_garbage_length_delays_a_parser_that_knows_nothing_but_costs_no_frame():
    parser = StreamParser()
    # 100 is a whole group, so that all 84 bytes must be awaited before the sum can be wrong.
    assert parser.feed(bytes([19, 81, 100])) == []
    assert parser.feed(bytes(R1 * 10)) == []
    assert len(parser.feed(bytes(R1 * 2))) == 12


def test_frames_of_another_stream_are_not_taken_for_ours():
    assert StreamParser((13, 29)).feed(bytes(R1)) == []
    assert StreamParser((7, 35, 43, 44)).feed(bytes([*R1, *R4])) == [STREAM_FRAMES["R4"][1]]


def test_two_frames_in_one_read_are_both_found():
    values = StreamParser().feed(bytes([*R4, *R5]))
    assert values == [STREAM_FRAMES["R4"][1], STREAM_FRAMES["R5"][1]]
    assert counts_between(values[0][43], values[1][43]) == 1
    assert counts_between(values[0][44], values[1][44]) == -1


OURS = (7, 35, 43, 44)
frames = st.fixed_dictionaries(
    {
        Packet(7): st.integers(0, 15),
        Packet(35): st.integers(0, 3),
        Packet(43): st.integers(-32768, 32767),
        Packet(44): st.integers(-32768, 32767),
    }
)


@given(st.lists(frames, max_size=4), st.binary(max_size=40), st.integers(1, 7))
def test_how_the_line_cuts_the_bytes_does_not_matter(sent, garbage, cut):
    encoded = garbage.join(encode_sensor_frame(OURS, values) for values in sent) + garbage
    whole, parser = StreamParser(OURS), StreamParser(OURS)
    pieces = [encoded[start : start + cut] for start in range(0, len(encoded), cut)]
    assert [v for piece in pieces for v in parser.feed(piece)] == whole.feed(encoded)


@given(st.binary(max_size=60), st.lists(frames, min_size=1, max_size=4))
def test_garbage_before_whole_frames_costs_none_of_them(garbage, sent):
    assume(bytes([19, 10]) not in garbage)  # What our frames begin with.
    encoded = b"".join(encode_sensor_frame(OURS, values) for values in sent)
    assert StreamParser(OURS).feed(garbage + encoded) == sent


@given(st.binary(max_size=400))
def test_no_bytes_break_the_stream_parser(received):
    StreamParser().feed(received)
    parser = StreamParser(OURS)
    parser.feed(received)
    flushed = parser.feed(bytes(13)) + parser.feed(bytes(R4))
    assert flushed[-1] == STREAM_FRAMES["R4"][1]


def test_a_full_group_travels_in_one_frame():
    # R17: front right cliff, mode Safe, encoders -32760 and 1234; the rest is in the packets' test.
    frame = bytes([19, 81, 100, *R17, 179])
    (values,) = StreamParser([100]).feed(frame)
    assert (values[11], values[35], values[43], values[44]) == (1, 2, -32760, 1234)
    assert encode_sensor_frame([100], values) == frame
