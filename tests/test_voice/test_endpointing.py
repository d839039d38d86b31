import numpy as np
import pytest

from vizbot.operator.language.command import ComeBack, Stop
from vizbot.operator.language.language import ENGLISH
from vizbot.operator.voice.endpointing import Listener
from vizbot.operator.voice.intent import Utterance
from vizbot.operator.voice.sound_decoder import RATE

HALF = RATE // 2
SILENCE = np.zeros(HALF, np.float32)
SPEECH = np.ones(HALF, np.float32)


class ScriptedEar:
    """Takes samples that are not zero for speech; says what it was told to have heard."""

    def __init__(self, said, so_far=""):
        self.said, self.so_far, self.utterances = said, so_far, []

    def hear(self, sound, wake=None):
        self.utterances.append(sound)
        return Utterance(self.said, ENGLISH.grammar.heard(self.said))

    def glance(self, sound):
        return self.so_far

    def speech(self, sound):
        (loud,) = np.nonzero(sound)
        return [(int(loud[0]), int(loud[-1]) + 1)] if len(loud) else []


def take_all(ear, *blocks):
    listener = Listener(ear, None)
    return [heard for block in blocks if (heard := listener.take(block)) is not None]


def test_silence_says_nothing_and_is_not_kept():
    ear = ScriptedEar("come back")
    assert take_all(ear, *[SILENCE] * 50, SPEECH, SILENCE, SILENCE) != []
    assert len(ear.utterances[0]) <= 4 * HALF


@pytest.mark.parametrize(
    ("so_far", "commands"), [("", [ComeBack()]), ("stop", [Stop(), ComeBack()])]
)
def test_an_utterance_ends_with_a_pause_and_may_begin_with_a_stop(so_far, commands):
    ear = ScriptedEar("come back", so_far)
    heard = take_all(ear, SILENCE, SPEECH, SPEECH, SILENCE, SILENCE, SILENCE)
    assert [each.command for each in heard] == commands


def test_stop_is_told_once_and_before_the_utterance_ends():
    ear = ScriptedEar("no, stop", so_far="no, stop")
    listener = Listener(ear, "hey robot")
    assert listener.take(SPEECH).command == Stop()
    assert ear.utterances == []
    assert [listener.take(block) for block in (SPEECH, SILENCE, SILENCE)] == [None] * 3


def test_endless_talk_is_cut():
    assert len(take_all(ScriptedEar("what a day"), *[SPEECH] * 65)) == 2


def test_small_blocks_are_gathered():
    ear = ScriptedEar("come back")
    blocks = np.split(np.concatenate([SPEECH, SILENCE, SILENCE, SILENCE]), 20)
    assert len(take_all(ear, *blocks)) == 1
