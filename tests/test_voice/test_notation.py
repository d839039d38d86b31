"""The notation of what people say: it reads a line, and makes lines that it reads."""

import random
import re

import pytest

from vizbot.operator.language.command import Decline, GoTo, command_name
from vizbot.operator.language.language import languages, load_language
from vizbot.operator.language.notation import read_pattern
from vizbot.operator.language.sentence_kinds import KINDS


def reads(pattern, line, **parts):
    return re.fullmatch(read_pattern(pattern, parts).regex(("a",), ("m",)), f" {line}")


def test_one_of_several_words_and_words_that_may_be_left_out():
    for line in ("go to it", "drive to it", "go over to it"):
        assert reads("(go|drive) [over] to it", line)
    for line in ("to it", "go over", "go drive to it", "goto it"):
        assert not reads("(go|drive) [over] to it", line)


def test_slots_read_any_words_numbers_and_units():
    assert reads("go to {goal}", "go to the red sofa")["goal"] == "the red sofa"
    assert reads("go {number} {unit}", "go 1.5 m")["number"] == "1.5"
    assert reads("go {number} {unit}", "go a m")["unit"] == "m"
    assert not reads("go {number} {unit}", "go far m")


@pytest.mark.parametrize(
    ("pattern", "line", "goal"),
    [
        ("(go|go to) {goal}", "go to the sofa", "the sofa"),
        ("(go|go to) {goal}", "go home", "home"),
        ("take <me> to {goal}", "take us to bed", "bed"),
    ],
)
def test_of_two_ways_to_say_it_that_of_more_words_is_read_and_parts_have_names(pattern, line, goal):
    assert reads(pattern, line, me="me|us")["goal"] == goal


def test_a_pattern_tells_what_it_begins_with_and_what_is_in_all_that_it_reads():
    pattern = read_pattern("[please] (go|drive) [over] to {goal}", {})
    assert pattern.first_words() == {"please", "go", "drive"}
    assert pattern.marks() == ({"go", "drive"}, {"to"})
    assert read_pattern("{goal} please", {}).first_words() == {"{goal}"}
    assert read_pattern("[please|now]", {}).first_words() == {"please", "now", ""}


@pytest.mark.parametrize("code", languages())
def test_no_rule_passes_over_what_its_pattern_says(code):
    rng = random.Random(0)
    for rule in load_language(code).grammar.rules:
        for _ in range(20):
            slots = {"goal": "sofa", "number": "2", "unit": "m", "word": "could", "rest": "so far"}
            line = rule.pattern.sentence(slots, rng).casefold()
            said = line.split(" ")
            assert rule.begins(said[0]) and rule.fits(frozenset(said)), line
            assert rule.read(line) is not None, line


@pytest.mark.parametrize("pattern", ["(go", "go)", "[go)", "{thing}", "<home>"])
def test_what_is_no_pattern_is_refused(pattern):
    with pytest.raises(ValueError, match=r"missing|closes nothing|no slot|no part"):
        read_pattern(pattern, {})


@pytest.mark.parametrize("code", languages())
@pytest.mark.parametrize("kind", KINDS)
def test_what_a_pattern_says_is_read_as_its_command(code, kind):
    language, rng = load_language(code), random.Random(0)
    goal, number = {"en": ("the sofa", "2"), "de": ("das Sofa", "2")}[code]
    unit = "m"
    for rule in language.grammar.rules:
        if rule.kind != kind:
            continue
        for _ in range(30):
            line = rule.pattern.sentence(
                {"goal": goal, "number": number, "unit": unit, "word": "could", "rest": "so far"},
                rng,
            )
            command = language.grammar.heard(line)
            assert command is not None, line
            if kind not in ("backwards", "forward", "let_in"):
                assert not isinstance(command, Decline), line
            if kind == "go":
                others = ("dock", "where is")  # "go and charge", "show me where the sofa is"
                assert command == GoTo(("sofa",)) or command_name(command) in others, line
