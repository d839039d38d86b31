# ruff: noqa: RUF001
"""Numbers as people write them: one reader, whatever the spelling."""

from math import degrees, isclose

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vizbot.operator.language.command import Decline, GoTo, Move, Reason
from vizbot.operator.language.language import load_language
from vizbot.operator.language.numeral import digits_of

FULL_WIDTH = str.maketrans("0123456789.,-", "０１２３４５６７８９．，－")
VULGAR = {"½": 0.5, "¼": 0.25, "¾": 0.75, "⅓": 1 / 3, "⅕": 0.2, "⅛": 0.125}


def way(line, code="en"):
    command = load_language(code).grammar.typed(line)
    assert isinstance(command, Move), (line, command)
    return command.moves[0].forward


def value(line):
    text, unread = digits_of(line)
    assert not unread
    return float(text.replace(",", "."))


@pytest.mark.parametrize(
    ("said", "metres"),
    [(".5 m", 0.5), (".25 m", 0.25), ("0,5 m", 0.5), (",5 m", 0.5), ("½ m", 0.5), ("1½ m", 1.5),
     ("1 ½ m", 1.5), ("1 1/2 m", 1.5), ("1/2 m", 0.5), ("1⁄2 m", 0.5), ("half a metre", 0.5),
     ("1.5e0 m", 1.5), ("１.５ m", 1.5), ("１．５ m", 1.5), ("+1 m", 1.0), ("＋1 m", 1.0),
     (".5m", 0.5), ("½m", 0.5), ("50 cm", 0.5), ("50cm", 0.5), ("٢ m", 2.0), ("1½ metres.", 1.5)],
)  # fmt: skip
def test_a_length_is_read_in_every_spelling(said, metres):
    assert isclose(way(f"go forward {said}"), metres, rel_tol=1e-5)


@pytest.mark.parametrize(
    ("said", "metres"),
    [(".5 m", 0.5), ("0,5 m", 0.5), ("½ Meter", 0.5), ("1½ m", 1.5), ("einen halben Meter", 0.5),
     ("５０ cm", 0.5), ("1,5e0 m", 1.5), ("eineinhalb Meter", 1.5)],
)  # fmt: skip
def test_a_german_length_is_read_in_every_spelling(said, metres):
    assert isclose(way(f"fahr {said} vor", "de"), metres, rel_tol=1e-5)


@pytest.mark.parametrize("said", [".9 degrees", "0,9 degrees", "0.9°", "９e-1 degrees"])
def test_an_angle_is_read_in_every_spelling(said):
    command = load_language("en").grammar.typed(f"turn left by {said}")
    assert isclose(degrees(command.moves[0].turn), 0.9)


@pytest.mark.parametrize("sign", "-−–—‐‑﹣－")
def test_a_sign_of_any_kind_is_no_way_ahead(sign):
    said = load_language("en").grammar.typed(f"go forward {sign}1 m")
    assert said == Decline(Reason.BACKWARDS)


@pytest.mark.parametrize(
    "said", ["5€ m", "±1 m", "~1 m", "1-2 m", "1–2 m", "1,000 m", "1/0 m", "5² m", "① m", "1:2 m",
             "50% m", "0.5.5 m", "1×2 m", "+-1 m"]
)  # fmt: skip
def test_a_number_that_touches_an_unknown_character_is_asked_back(said):
    command = load_language("en").grammar.typed(f"go forward {said}")
    assert not isinstance(command, Move)


@pytest.mark.parametrize("sign", ["-", "−", "–", "+", "±", "~", "≈", "=", "- -"])
@pytest.mark.parametrize(
    ("code", "line"),
    [("en", "go forward {} 1 m"), ("en", "turn left by {} 90 degrees"),
     ("en", "go forward 1 m, then go forward {} 2 m"), ("de", "fahr {} 1 m vor"),
     ("de", "fahr {} 1 m vor und dann zum Sofa")],
)  # fmt: skip
def test_a_sign_apart_from_its_number_is_asked_back(code, line, sign):
    assert isinstance(load_language(code).grammar.typed(line.format(sign)), Decline)


def test_a_dash_before_a_number_divides_goals_as_before():
    said = load_language("en").grammar.typed("sofa - 2 pillows")
    assert said == GoTo(("sofa", "2 pillows"))


def test_names_keep_their_digits_and_literals_are_not_read():
    assert digits_of("usb3 hub, r2d2 and 7 up") == ("usb3 hub, r2d2 and 7 up", False)
    assert load_language("en").grammar.literals('find "size 1½"') == ("size 1.5",)


@given(st.integers(0, 999), st.integers(0, 999), st.sampled_from("-−–－+＋") | st.just(""))
def test_a_decimal_is_the_same_in_every_spelling(whole, part, sign):
    meant = float(f"{whole}.{part:03d}1") * (-1 if sign not in ("", "+", "＋") else 1)
    plain = f"{whole}.{part:03d}1"
    spellings = [plain, plain.replace(".", ","), plain.translate(FULL_WIDTH), f"{plain}e0"]
    spellings += [f".{part:03d}1"] if whole == 0 else []
    assert all(isclose(value(sign + each), meant, abs_tol=1e-6) for each in spellings)


@given(st.integers(0, 99), st.sampled_from(sorted(VULGAR)))
def test_a_vulgar_fraction_is_a_decimal(whole, fraction):
    meant = whole + VULGAR[fraction]
    assert isclose(value(f"{whole}{fraction}"), meant, abs_tol=1e-6)
    assert isclose(value(f"{whole} {fraction}"), meant, abs_tol=1e-6)


@given(st.text())
def test_what_was_read_once_is_read_the_same_again(line):
    text, unread = digits_of(line)
    assert digits_of(text) == (text, unread)
