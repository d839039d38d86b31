"""Phrases, goals and voices of the test of speech, and the rule that splits them in two halves.

Every list is split by position: the even places (0, 2, ...) are the half on which words are
added to the grammar and thresholds are chosen, the odd places the half on which the figures are
taken. An utterance of a half uses phrases, goals and voices of that half alone.
"""

import itertools
import random
import shutil
import subprocess
from dataclasses import dataclass

import numpy as np
import pytest

from vizbot.operator.language.command import (
    All,
    ComeBack,
    Dock,
    GoTo,
    Stop,
    WhereIs,
    command_name,
    goals_of,
    step_count,
)
from vizbot.operator.language.language import ENGLISH
from vizbot.operator.session.vocabulary import HOUSEHOLD
from vizbot.operator.voice.intent import resolve_command
from vizbot.operator.voice.sound import read_sound
from vizbot.operator.voice.sound_decoder import RATE

speaking = pytest.mark.skipif(
    shutil.which("espeak-ng") is None, reason="nobody speaks: apt-get install espeak-ng"
)
PHRASES = (
    ("go to the {a}", GoTo),
    ("please go to the {a}", GoTo),
    ("could you go to the {a}", GoTo),
    ("drive to the {a} please", GoTo),
    ("find the {a}", GoTo),
    ("could you find the {a}", GoTo),
    ("please find me a {a}", GoTo),
    ("look for the {a}", GoTo),
    ("take me to the {a}", GoTo),
    ("can you take me to the {a}", GoTo),
    ("please take me to the {a}", GoTo),
    ("bring me to the {a}", GoTo),
    ("show me the {a}", GoTo),
    ("please show me the {a}", GoTo),
    ("can you show me the {a}", GoTo),
    ("i want you to go to the {a}", GoTo),
    ("go to the {a}, then the {b}", GoTo),
    ("go to the {a}, then go to the {b}", GoTo),
    ("find the {a} and then the {b}", GoTo),
    ("take me to the {a} and then to the {b}", GoTo),
    ("please find the {a}, then find the {b}", GoTo),
    ("show me the {a}, and then the {b}", GoTo),
    ("where is the {a}", WhereIs),
    ("where's the {a}", WhereIs),
    ("please tell me where the {a} is", WhereIs),
    ("do you know where the {a} is", WhereIs),
    ("where is my {a}", WhereIs),
    ("uh, where is the {a} please", WhereIs),
    ("find all the {c}", All),
    ("go to all the {c}", All),
    ("show me all the {c}", All),
    ("take me to all the {c}", All),
    ("come back", ComeBack),
    ("please come back", ComeBack),
    ("come back to me", ComeBack),
    ("come back here", ComeBack),
    ("dock", Dock),
    ("go home to charge", Dock),
    ("go to your dock", Dock),
    ("please go and charge", Dock),
)
STOPS = (
    "stop",
    "stop now",
    "please stop",
    "stop please",
    "stop stop stop",
    "robot stop",
    "go to the {a}, no, stop",
    "take me to the {a}, stop",
    "stop it",
    "okay stop right there",
)
VOICES = (
    ("en-gb", 165),
    ("en-gb+f2", 150),
    ("en-gb-scotland", 140),
    ("en-gb-x-rp", 160),
    ("en-us", 150),
    ("en-us+f2", 140),
    ("en-us+f3", 130),
    ("en-us+m3", 175),
)
"""Names of espeak-ng and words in a minute."""

BUILDING, FINAL = (7, VOICES[0::2]), (8765, (("en-gb-x-gbclan", 155), ("en-us+m1", 150)))
"""Seed and voices of the sentences that the grammar itself makes: those for building, and those
that are heard once."""
ENDS = ("", ", then come back", " and come back", ", then dock", " and explore", ", then explore")
LEADS = ("go to the {}", "find the {}", "take me to the {}", "could you please go to the {}")
JOINS = (
    ", then the {}",
    " and then go to the {}",
    ", then find the {}",
    ", after that the {}",
    ", afterwards go to the {}",
    " followed by the {}",
    ", and next the {}",
    ", after this the {}",
    ", thereafter the {}",
    " and after the {}",
    ", from there to the {}",
    ", the {}",
    " and the {}",
)
SOONER = ", but first go to the {}"
"""Joins what is done before the rest; nothing stands behind it."""
NAMES = {
    "place": "where are you", "sight": "what do you see", "task": "what are you doing",
    "where": "where is", "go": "go to", "turn_left": "move", "turn_right": "move",
    "turn_around": "move", "forward": "move", "backwards": "nothing: backwards",
    "let_in": "nothing: zone",
}  # fmt: skip
"""What the command is called that a kind of pattern asks for; that of others is called alike."""

DRAWN = 3
"""Sentences of a pattern of which one is said."""

_PAUSE = 0.4


@dataclass(frozen=True)
class SpokenSample:
    """What is said, by whom, and the command that is meant."""

    text: str
    voice: str
    speed: int
    command: object


def utterances(half):
    """Every phrase of a half (0: to look at, 1: for the figures) by every voice of that half."""
    goals, voices = HOUSEHOLD[half::2], VOICES[half::2]
    spoken = []
    for phrase, kind in PHRASES[half::2]:
        for voice, speed in voices:
            place = len(spoken)
            a, b = goals[place * 7 % len(goals)], goals[(place * 11 + 5) % len(goals)]
            text = phrase.format(a=a, b=b, c=_plural(a))
            spoken.append(SpokenSample(text, voice, speed, _meant(kind, phrase, a, b)))
    return spoken


def stops(half, voices=None):
    """Every way to say stop of a half by every voice, as a default by those of that half."""
    goals = HOUSEHOLD[half::2]
    return [
        SpokenSample(phrase.format(a=goals[5 * place % len(goals)]), voice, speed, Stop())
        for place, phrase in enumerate(STOPS[half::2])
        for voice, speed in voices or VOICES[half::2]
    ]


def ruled(seed, voices):
    """A sentence of each pattern of the grammar, in its order; four of each that says "go".

    It is the one of the fewest words among some: with many of the words that a pattern may leave
    out, most sentences are such as nobody says ("travel exploring a bit the whole surroundings").
    """
    rng = random.Random(seed)
    texts = [
        min((rule_text(rule, rng) for _ in range(DRAWN)), key=lambda text: len(text.split()))
        for rule in ENGLISH.grammar.rules
        for _ in range(4 if rule.kind == "go" else 1)
    ]
    return _spoken(texts, voices)


def missions(seed, voices):
    """Missions of up to three goals with all that may stand at their end, one of three goals for
    each join, and what is joined without a goal: moves, and explorations with their end.
    """
    rng = random.Random(seed)
    ends = itertools.product((1, 2, 3), ENDS)
    texts = [_mission(rng.choices(JOINS, k=count - 1), end, rng) for count, end in ends]
    texts += [_mission([rng.choice(JOINS[:3]), join], "", rng) for join in (*JOINS, SOONER)]
    rules = ENGLISH.grammar.rules
    moves = [rule for rule in rules if rule.kind in ("turn_left", "turn_right", "forward")]
    explorations = [rule for rule in rules if rule.kind == "explore"]
    texts += [_followed(moves, ", then turn around", rng) for _ in range(4)]
    texts += [_followed(explorations, end, rng) for end in (ENDS[1], ENDS[3]) for _ in range(2)]
    return _spoken(texts, voices)


def rule_text(rule, rng):
    """A sentence of a pattern that is read as what the pattern asks for."""
    turns, many = rule.kind.startswith("turn"), rule.kind in ("all", "how_many")
    name = NAMES.get(rule.kind, rule.kind.replace("_", " "))

    def draw():
        goal = rng.choice(HOUSEHOLD)
        slots = {
            "goal": _plural(goal) if many else f"the {goal}",
            "number": rng.choice(("ten", "thirty", "ninety") if turns else ("one", "two", "three")),
            "unit": rng.choice(("metres", "feet", "steps")),
            "word": "house",
            "rest": "see here",
        }
        return rule.pattern.sentence(slots, rng)

    return _drawn(draw, lambda command: command_name(command) == name)


def _mission(joins, end, rng):
    """A sentence that asks for one thing more than it has joins, and for what is at its end."""

    def draw():
        first, *others = rng.sample(HOUSEHOLD, 1 + len(joins))
        joined = (join.format(other) for join, other in zip(joins, others, strict=True))
        return rng.choice(LEADS).format(first) + "".join(joined) + end

    return _drawn(draw, lambda command: step_count(command) == 1 + len(joins) + bool(end))


def _followed(rules, end, rng):
    """A sentence of one of some patterns, and what is at its end."""
    return _drawn(
        lambda: rule_text(rng.choice(rules), rng) + end, lambda command: step_count(command) == 2
    )


def _drawn(draw, fits):
    """What is drawn first and is a command that fits, about nothing but things of the household."""
    for _ in range(200):
        command = ENGLISH.grammar.heard(text := draw())
        if command is None or not fits(command):
            continue
        if {*goals_of(_resolved(command))} <= {*HOUSEHOLD}:
            return text
    raise AssertionError(f"{text!r} and others are read as something else")


def _spoken(texts, voices):
    """The texts with their voices in turn, and what they mean."""
    return [
        SpokenSample(text, *voice, _resolved(ENGLISH.grammar.heard(text)))
        for text, voice in zip(texts, itertools.cycle(voices), strict=False)
    ]


def _resolved(command):
    return resolve_command(command, HOUSEHOLD)[0]


def _meant(kind, phrase, a, b):
    if kind is GoTo:
        return GoTo((a, b) if "{b}" in phrase else (a,))
    return kind(a) if "{" in phrase else kind()


def _plural(goal):
    first, of, rest = goal.partition(" of ")
    for end, ends in (("shelf", "shelves"), ("y", "ies"), ("ch", "ches"), ("s", "s"), ("", "s")):
        if first.endswith(end):
            return first.removesuffix(end) + ends + of + rest


def speak(utterance, folder):
    """Samples (N,) float32, with a pause before and after."""
    wav = record(utterance, folder)
    pause = np.zeros(int(_PAUSE * RATE), np.float32)
    return np.concatenate([pause, read_sound(wav), pause])


def record(utterance, folder):
    """The path of a WAV file of it."""
    wav = folder / "speech.wav"
    options = ["-v", utterance.voice, "-s", str(utterance.speed), "-w", str(wav)]
    subprocess.run(["espeak-ng", *options, utterance.text], check=True)
    return wav


def with_noise(speech, decibels, seed):
    """The same with pink noise (power falls with frequency) so far below the speech's power.

    The power of speech is that of the 20 ms in which there is some: more than 1 % of the loudest.
    """
    rng = np.random.default_rng(seed)
    spectrum = np.fft.rfft(rng.standard_normal(len(speech)))
    spectrum /= np.sqrt(np.maximum(np.fft.rfftfreq(len(speech), 1 / RATE), 50.0))
    noise = np.fft.irfft(spectrum, len(speech))
    length = RATE // 50
    powers = np.mean(speech[: len(speech) // length * length].reshape(-1, length) ** 2, axis=1)
    power = powers[powers > 0.01 * powers.max()].mean() / 10 ** (decibels / 10)
    return (speech + noise * np.sqrt(power / np.mean(noise**2))).astype(np.float32)
