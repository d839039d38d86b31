"""From a terminal's bytes to key events."""

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vizbot.operator.teleop.key_parser import (
    PATIENCE,
    FocusLost,
    KeyboardFlags,
    KeyEvent,
    KeyParser,
    Stroke,
)

SEQUENCES = {
    b"w": [KeyEvent("w", text="w")],
    b"W": [KeyEvent("w", text="W")],
    b"+": [KeyEvent("+", text="+")],
    b"\x03": [KeyEvent("ctrl+c")],
    b"\x1b[A": [KeyEvent("up")],
    b"\x1bOD": [KeyEvent("left")],
    b"\x1b[1;2C": [KeyEvent("right")],
    b"\x1b[1;1:2B": [KeyEvent("down", Stroke.REPEAT)],
    b"\x1b[1;1:3A": [KeyEvent("up", Stroke.RELEASE)],
    b"\x1b[57419u": [KeyEvent("up")],
    b"\x1b[119;;119u": [KeyEvent("w", text="w")],
    b"\x1b[119;65:1;87u": [KeyEvent("w", text="w")],
    b"\x1b[119;1:2u": [KeyEvent("w", Stroke.REPEAT)],
    b"\x1b[119;5:3u": [KeyEvent("w", Stroke.RELEASE)],
    b"\x1b[49;2;43u": [KeyEvent("1", text="+")],
    b"\x1b[61:43;2u": [KeyEvent("=")],
    b"\x1b[27u": [KeyEvent("escape")],
    b"\x1b[99;5u": [KeyEvent("ctrl+c")],
    b"\x1b[?27u": [KeyboardFlags(27)],
    b"\x1b[O": [FocusLost()],
    # Not of use here: other keys, Ctrl and Alt with a key, answers to what others asked.
    b"\x1b[119;5u": [],
    b"\x1b[119;1:9u": [],
    b"\x1b[57441;2u": [],
    b"\x1b[3~": [],
    b"\x1b[[A": [],
    b"\x1bOP": [],
    b"\x1b[I": [],
    b"\x1b[?62;22c": [],
    "ü".encode(): [],
    b"\r": [],
}

streams = st.lists(st.sampled_from(list(SEQUENCES)) | st.binary(max_size=4)).map(b"".join)


def parsed(*pieces):
    """Events of a stream in pieces, and of what is left when nothing more comes."""
    parser = KeyParser()
    events = [event for piece in pieces for event in parser.feed(piece, 0.0)]
    return events + parser.feed(b"", PATIENCE)


@pytest.mark.parametrize(("sent", "events"), SEQUENCES.items())
def test_what_a_terminal_sends_for_a_key_is_that_key(sent, events):
    assert parsed(sent) == events


@given(st.lists(st.sampled_from(list(SEQUENCES))))
def test_sequences_that_come_together_are_told_apart(sent):
    assert parsed(b"".join(sent)) == [event for each in sent for event in SEQUENCES[each]]


@given(streams, st.data())
def test_wherever_a_stream_is_cut_its_events_are_the_same(stream, data):
    cuts = sorted(data.draw(st.lists(st.integers(0, len(stream)), max_size=8)))
    edges = [0, *cuts, len(stream)]
    pieces = [stream[a:b] for a, b in itertools.pairwise(edges)]
    assert parsed(*pieces) == parsed(stream)
    assert parsed(*(bytes([each]) for each in stream)) == parsed(stream)


@given(st.binary(), st.sampled_from([b"\x1b[", b"\x1b[1;", b"\x1bO", b"\x1b[?", b""]))
def test_no_bytes_whatever_are_an_error(stream, begun):
    parsed(begun + stream + begun)


def test_escape_alone_is_a_key_once_nothing_follows_in_time():
    parser = KeyParser()
    assert parser.feed(b"\x1b", 1.0) == []
    assert parser.feed(b"", 1.0 + PATIENCE / 2) == []
    assert parser.feed(b"", 1.0 + PATIENCE) == [KeyEvent("escape")]


def test_escape_and_a_key_at_once_are_both_heard():
    assert parsed(b"\x1b ") == [KeyEvent("escape"), KeyEvent(" ", text=" ")]


@pytest.mark.parametrize("begun", [b"\x1b[", b"\x1b[1;", b"\x1b[?2", b"\x1b[" + b"1" * 64])
def test_a_sequence_that_breaks_off_swallows_no_stop(begun):
    assert parsed(begun, b" ") == [KeyEvent(" ", text=" ")]
    parser = KeyParser()
    assert parser.feed(begun, 0.0) == []
    assert parser.feed(b"w", PATIENCE) == [KeyEvent("w", text="w")]
