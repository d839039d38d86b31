"""Commands against literal bytes: vectors H1 to H23 of the fact sheet of the manual."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.roomba.commands import (
    BAUD_RATES,
    CLOCKWISE,
    COUNTER_CLOCKWISE,
    LAYOUTS,
    STRAIGHT,
    Command,
    CommandParser,
    Days,
    Leds,
    Motors,
    Opcode,
    check,
    encode,
)
from drivers.roomba.packets import Buttons

HOST_TO_ROBOT = {
    "H1": ([(Opcode.DRIVE, -200, 500)], [137, 255, 56, 1, 244]),
    "H2": ([(Opcode.DRIVE, 300, STRAIGHT)], [137, 1, 44, 128, 0]),
    "H3": ([(Opcode.DRIVE, 300, 32767)], [137, 1, 44, 127, 255]),
    "H4": ([(Opcode.DRIVE, 150, CLOCKWISE)], [137, 0, 150, 255, 255]),
    "H5": ([(Opcode.DRIVE, 150, COUNTER_CLOCKWISE)], [137, 0, 150, 0, 1]),
    "H6": ([(Opcode.DRIVE, 500, -2000)], [137, 1, 244, 248, 48]),
    "H7": ([(Opcode.DRIVE, -500, 2000)], [137, 254, 12, 7, 208]),
    "H8": ([(Opcode.DRIVE_DIRECT, 200, -200)], [145, 0, 200, 255, 56]),
    "H9": ([(Opcode.DRIVE_DIRECT, -500, 500)], [145, 254, 12, 1, 244]),
    "H10": ([(Opcode.DRIVE_DIRECT, 250, 150)], [145, 0, 250, 0, 150]),
    "H11": ([(Opcode.DRIVE_DIRECT, 0, 0)], [145, 0, 0, 0, 0]),
    "H12": ([(Opcode.DRIVE_PWM, 255, -255)], [146, 0, 255, 255, 1]),
    "H13": ([(Opcode.PWM_MOTORS, -64, 32, 127)], [144, 192, 32, 127]),
    "H14": (
        [(Opcode.MOTORS, Motors.MAIN_BRUSH | Motors.SIDE_BRUSH | Motors.SIDE_BRUSH_CLOCKWISE)],
        [138, 13],
    ),
    "H15": ([(Opcode.LEDS, Leds.DOCK, 0, 128)], [139, 4, 0, 128]),
    "H16": ([(Opcode.LEDS, Leds.CHECK_ROBOT | Leds.DOCK, 255, 255)], [139, 12, 255, 255]),
    "H17": (
        [(Opcode.SONG, 0, 69, 32, 72, 16), (Opcode.PLAY, 0)],
        [140, 0, 2, 69, 32, 72, 16, 141, 0],
    ),
    "H18": ([(Opcode.QUERY_LIST, 7, 13)], [149, 2, 7, 13]),
    "H19": ([(Opcode.QUERY_LIST, 43, 44)], [149, 2, 43, 44]),
    "H20": (
        [
            (Opcode.STREAM, 29, 13),
            (Opcode.PAUSE_RESUME_STREAM, 0),
            (Opcode.PAUSE_RESUME_STREAM, 1),
        ],
        [148, 2, 29, 13, 150, 0, 150, 1],
    ),
    "H21": ([(Opcode.STREAM, 7, 35, 43, 44)], [148, 4, 7, 35, 43, 44]),
    "H22": (
        [(Opcode.SCHEDULE, Days.WEDNESDAY | Days.FRIDAY, *[0] * 6, 15, 0, 0, 0, 10, 36, 0, 0)],
        [167, 40, 0, 0, 0, 0, 0, 0, 15, 0, 0, 0, 10, 36, 0, 0],
    ),
    "H23": (
        [
            (Opcode.SET_DAY_TIME, 3, 15, 30),
            (Opcode.BUTTONS, Buttons.DOCK),
            (Opcode.DIGIT_LEDS_ASCII, *b"ABCD"),
            (Opcode.BAUD, BAUD_RATES.index(19200)),
        ],
        [168, 3, 15, 30, 165, 4, 164, 65, 66, 67, 68, 129, 7],
    ),
}


@pytest.mark.parametrize("vector", HOST_TO_ROBOT)
def test_commands_encode_to_the_bytes_of_the_manual(vector):
    commands, expected = HOST_TO_ROBOT[vector]
    assert list(b"".join(encode(*command) for command in commands)) == expected


@pytest.mark.parametrize("vector", HOST_TO_ROBOT)
def test_the_bytes_of_the_manual_parse_to_commands_one_byte_at_a_time(vector):
    commands, encoded = HOST_TO_ROBOT[vector]
    parser = CommandParser()
    parsed = [command for byte in encoded for command in parser.feed(bytes([byte]))]
    assert parsed == [Command(opcode, tuple(arguments)) for opcode, *arguments in commands]


@pytest.mark.parametrize(
    ("opcode", "byte"),
    [
        (Opcode.RESET, 7),
        (Opcode.START, 128),
        (Opcode.CONTROL, 130),
        (Opcode.SAFE, 131),
        (Opcode.FULL, 132),
        (Opcode.POWER, 133),
        (Opcode.SPOT, 134),
        (Opcode.CLEAN, 135),
        (Opcode.MAX, 136),
        (Opcode.SEEK_DOCK, 143),
        (Opcode.STOP, 173),
    ],
)
def test_commands_without_data_are_their_opcode(opcode, byte):
    assert encode(opcode) == bytes([byte])
    assert list(CommandParser().feed(bytes([byte]))) == [Command(opcode)]


def test_the_commands_that_no_vector_covers_encode_as_the_tables_say():
    assert list(encode(Opcode.SENSORS, 35)) == [142, 35]
    assert list(encode(Opcode.SCHEDULING_LEDS, 127, 31)) == [162, 127, 31]
    assert list(encode(Opcode.DIGIT_LEDS_RAW, 1, 2, 64, 127)) == [163, 1, 2, 64, 127]


@pytest.mark.parametrize(
    ("opcode", "arguments"),
    [
        (Opcode.DRIVE, (501, STRAIGHT)),
        (Opcode.DRIVE, (0, 2001)),
        (Opcode.DRIVE_DIRECT, (0, -501)),
        (Opcode.DRIVE_DIRECT, (0,)),
        (Opcode.DRIVE_DIRECT, (0, 0, 0)),
        (Opcode.DRIVE_PWM, (256, 0)),
        (Opcode.PWM_MOTORS, (-128, 0, 0)),
        (Opcode.PWM_MOTORS, (0, 0, 128)),
        (Opcode.MOTORS, (32,)),
        (Opcode.LEDS, (16, 0, 0)),
        (Opcode.SONG, (5, 60, 32)),
        (Opcode.SONG, (0, *[60, 1] * 17)),
        (Opcode.SONG, (0, 60)),
        (Opcode.PLAY, (-1,)),
        (Opcode.SENSORS, (102,)),
        (Opcode.STREAM, (7, 59)),
        (Opcode.PAUSE_RESUME_STREAM, (2,)),
        (Opcode.DIGIT_LEDS_ASCII, (65, 66, 67, 31)),
        (Opcode.SCHEDULE, (1, 24, 0, *[0] * 12)),
        (Opcode.SET_DAY_TIME, (7, 0, 0)),
        (Opcode.BAUD, (12,)),
        (Opcode.START, (0,)),
    ],
)
def test_arguments_outside_the_manual_are_refused(opcode, arguments):
    with pytest.raises(ValueError, match=opcode.name):
        encode(opcode, *arguments)


def test_a_command_with_missing_data_swallows_the_start_of_the_next():
    parser = CommandParser()
    assert list(parser.feed(bytes([145, 0, 0, 0]))) == []
    assert list(parser.feed(bytes([145, 0, 100, 0, 100]))) == [
        Command(Opcode.DRIVE_DIRECT, (0, 145))
    ]


def test_bytes_that_are_no_opcode_are_skipped():
    parser = CommandParser()
    assert list(parser.feed(bytes([0, 255, 147, 151, 166, 131]))) == [Command(Opcode.SAFE)]


@st.composite
def commands(draw):
    opcode = draw(st.sampled_from(Opcode))
    layout = LAYOUTS[opcode]
    count = draw(st.integers(0, min(layout.most, 20)))
    values = [
        draw(st.integers(-32768, 32767).filter(argument.allowed.__contains__))
        if argument.size == 2
        else draw(st.sampled_from([v for v in range(-128, 256) if v in argument.allowed]))
        for argument in layout.fixed + layout.repeated * count
    ]
    return Command(opcode, tuple(values))


@given(st.lists(commands(), max_size=6), st.lists(st.integers(1, 9), min_size=1))
def test_any_commands_survive_the_line_however_it_is_cut(sent, cuts):
    encoded = b"".join(encode(command.opcode, *command.arguments) for command in sent)
    parser, received, start, turn = CommandParser(), [], 0, 0
    while start < len(encoded):
        end = start + cuts[turn % len(cuts)]
        received += parser.feed(encoded[start:end])
        start, turn = end, turn + 1
    assert received == sent


@given(st.binary(max_size=300))
def test_no_bytes_break_the_command_parser(received):
    for command in CommandParser().feed(received):
        assert command.opcode in Opcode.__members__.values()


def test_check_names_the_argument_and_its_range():
    with pytest.raises(ValueError, match="right velocity 600 is not -500 to 500"):
        check(Command(Opcode.DRIVE_DIRECT, (600, 0)))
