"""Recognises speech with Whisper: from sound to a command.

Whisper first decodes freely, with examples and the words of the running map as hints. Where that is
a plain command about known things, heard well, it is believed. Otherwise a sentence of the grammar
is looked for that sounds alike, or searched for in the sound. It is taken if it fits nearly as well
as the free hypothesis, unless that asks for more; otherwise that hypothesis is, if it is a command.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from vizbot.core.errors import ConfigError
from vizbot.operator.client.endpoint import SPEECH
from vizbot.operator.language.command import GoTo, Stop
from vizbot.operator.language.language import ENGLISH, Language
from vizbot.operator.voice.beam_search import ROWS_PER_SECOND, Encoded, PhraseScorer
from vizbot.operator.voice.intent import (
    PLAIN,
    Hypothesis,
    Utterance,
    after_wake,
    choose_utterance,
    plain_utterance,
)
from vizbot.operator.voice.sentence_bank import SentenceBank
from vizbot.operator.voice.sound import Sound, read_sound
from vizbot.operator.voice.sound_decoder import RATE

if TYPE_CHECKING:
    from ctranslate2 import StorageView
    from faster_whisper import WhisperModel
    from faster_whisper.tokenizer import Tokenizer

_HYPOTHESES, _UNHINTED = 10, 5
"""Free hypotheses with the hint and without it: a short sentence that the hint does not expect may
be lost to one that it does ("Who are you?" to "Go on.")."""
_PATIENCE = 2.0
"""How many times as many hypotheses are finished before a search ends: the best one is often not
among the first ("How many bookshelves?" behind "How many book shelves?")."""
_LONGEST = 60
"""Tokens of an answer; a command has less than 40, and noise may make Whisper repeat itself."""
_TAIL = 50
"""Rows of the encoded sound that are read after its end."""
_LONGEST_COMMAND = 10.0
"""Longest command [s]: whoever speaks longer talks to somebody else, and the search takes long."""
_LETTERS_PER_SECOND = 10.0
"""Words that are fewer for their time may lack the end of what was said: Whisper drops some."""
_FASTEST = 22.0
"""Letters in a second of what is said, and of the 0.4 s around it, which nobody speaks faster than:
of the sentences for building the fastest has 17."""
_LOOKED_AT, _ALIKE, _TRIED = 5, 10, 30
"""Free hypotheses for which sentences are looked up that sound alike, how many for each, and how
many of all of them are compared with the sound."""
_WHOLE = 4
"""Those of them that fit best, of which it is asked whether more is said after them."""
_AS_WELL = 0.3
"""How much worse than the best free hypothesis such a sentence may fit and nothing is searched."""
_FEATURES = 3000
"""Spectra of Whisper's window of 30 s."""
_REMEDY = "pip install faster-whisper"
_SIZES = ("tiny.en", "tiny", "base.en", "base", "small.en", "small")
"""Those that answer soon enough on a robot."""
_ON_HUB = re.compile(r"[\w-][\w.-]*/[\w.-]+")


class Recogniser:
    """A Whisper model that expects what people may ask a robot for.

    Attributes:
        vocabulary: Phrases that can be asked for, in the language that is spoken.
    """

    def __init__(
        self,
        vocabulary: Sequence[str],
        model: str = SPEECH,
        language: Language = ENGLISH,
    ) -> None:
        """Load the model.

        Args:
            vocabulary: Phrases that can be asked for, in the encoder's words; those beyond the
                first 220 tokens or so are recognised, but not hinted at.
            model: A size (tiny.en, base, small, ...), which is downloaded on first use, or a
                folder with a model for faster-whisper.
            language: That is spoken.

        Raises:
            ConfigError: the model or a package is missing, or the model knows English alone.
        """
        self.vocabulary = tuple(map(language.lexicon.own, vocabulary))
        self._language = language
        self._model = _load(model)
        self._tokenizer = _tokenizer(self._model, model, language)
        noise = _rows(self._encode(_noise()), len(_noise()))
        self._scorer = PhraseScorer(self._model.model, self._tokenizer, noise, language.spoken)
        self._bank: SentenceBank | None = None
        self._no_hint = self._model.get_prompt(self._tokenizer, [], without_timestamps=True)
        self.learn(())

    def learn(self, found: Sequence[str]) -> None:
        """Prefer what the running map finds: it comes first in the hint to the model."""
        own = map(self._language.lexicon.own, found)
        known = tuple(phrase for phrase in own if phrase in self.vocabulary)
        others = [phrase for phrase in self.vocabulary if phrase not in known]
        prompt = self._model.get_prompt(
            self._tokenizer,
            self._tokenizer.encode(" " + " ".join(self._language.grammar.examples)),
            without_timestamps=True,
            hotwords=", ".join([*known, *others]) or None,
        )
        self._hints = known, prompt  # at once, since another thread may be listening

    def hear(self, sound: Sound, wake: str | None = None) -> Utterance:
        """Recognise the command in an utterance; `wake` is said first, except before "stop"."""
        spoken = self._spoken(sound)
        if spoken is None:
            return Utterance("", None)
        found, _ = self._hints
        encoded = self._encode(spoken)
        free = self._sayable(self._free_hypotheses(encoded), len(spoken) / RATE)
        rows = _rows(encoded, len(spoken))
        plain = plain_utterance(free, self.vocabulary, wake, self._language)
        long_enough = (
            len(free[0].text) >= _LETTERS_PER_SECOND * len(spoken) / RATE if free else False
        )
        if plain is not None and (long_enough or not plain.resolved):
            return self._completed(rows, plain, wake)
        known = self._known(rows, free, wake)
        return choose_utterance(free, known, self.vocabulary, wake, found, self._language)

    def glance(self, sound: Sound) -> str:
        """What is probably being said; a third of the work of `hear`."""
        spoken = self._spoken(sound)
        encoded = self._encode(sound if spoken is None else spoken)
        hypotheses = self._generated(encoded, self._hints[1], 1)
        return hypotheses[0].text if hypotheses else ""

    def speech(self, sound: Sound) -> list[tuple[int, int]]:
        """Where somebody speaks: first sample and the one after the last, of each stretch."""
        from faster_whisper.vad import VadOptions, get_speech_timestamps

        options = VadOptions(min_silence_duration_ms=500, speech_pad_ms=200)
        spans = get_speech_timestamps(sound, options, RATE)
        return [(span["start"], span["end"]) for span in spans]

    def _spoken(self, sound: Sound) -> Sound | None:
        """From the first word to the last; None if nobody speaks."""
        spans = self.speech(sound)
        return sound[spans[0][0] : spans[-1][1]] if spans else None

    def _encode(self, sound: Sound) -> StorageView:
        from faster_whisper.audio import pad_or_trim

        features = self._model.feature_extractor(sound)[..., :_FEATURES]
        return self._model.encode(pad_or_trim(features, _FEATURES))

    def _free_hypotheses(self, encoded: StorageView) -> list[Hypothesis]:
        """Hypotheses of any words, with the hint and without it, best first."""
        best = dict[str, float]()
        for prompt, count in ((self._hints[1], _HYPOTHESES), (self._no_hint, _UNHINTED)):
            for each in self._generated(encoded, prompt, count):
                best[each.text] = max(each.score, best.get(each.text, -math.inf))
        return [Hypothesis(text, best[text]) for text in sorted(best, key=lambda text: -best[text])]

    def _sayable(self, free: Sequence[Hypothesis], seconds: float) -> list[Hypothesis]:
        """Those that can be said in the time: Whisper repeats itself; and every stop."""
        heard = self._language.grammar.heard
        return [
            each
            for each in free
            if len(each.text) <= _FASTEST * seconds or isinstance(heard(each.text), Stop)
        ]

    def _generated(
        self, encoded: StorageView, prompt: Sequence[int], count: int
    ) -> list[Hypothesis]:
        (result,) = self._model.model.generate(
            encoded,
            [prompt],
            beam_size=count,
            num_hypotheses=count,
            patience=_PATIENCE,
            return_scores=True,
            max_length=len(prompt) + _LONGEST,
        )
        texts = [self._tokenizer.decode(tokens).strip() for tokens in result.sequences_ids]
        return [
            Hypothesis(text, score)
            for text, score in zip(texts, result.scores, strict=True)
            if text
        ]

    def _completed(self, rows: Encoded, plain: Utterance, wake: str | None) -> Utterance:
        """A plain utterance, with what was said at its end and is not among its words."""
        if not isinstance(plain.command, GoTo) or plain.command.after is not None:
            return plain
        text = self._scorer.completed(rows, plain.text)
        if text == plain.text:
            return plain
        whole = [Hypothesis(text, PLAIN)]
        return plain_utterance(whole, self.vocabulary, wake, self._language) or plain

    def _known(self, rows: Encoded, free: list[Hypothesis], wake: str | None) -> list[Hypothesis]:
        """Sentences that the grammar makes, scored beside the best free hypothesis, best first.

        They are those that sound like what was heard freely, and, unless one of these fits the
        sound about as well as that, the one that a search finds.
        """
        if not free or len(rows) > _LONGEST_COMMAND * ROWS_PER_SECOND:
            return []
        if wake is not None and after_wake(free[0].text, wake) is None:
            return []
        alike = self._scored(rows, self._alike(free, wake), free[0])
        if alike and alike[0].score >= free[0].score - _AS_WELL:
            return alike[:1]
        found, _ = self._hints
        sentences = self._scorer.search(rows, self.vocabulary, found, wake)
        if not sentences:
            return alike[:1]
        text = sentences[0].text
        if sentences[0].goes_on:
            text = self._scorer.completed(rows, text)
        best = [*alike[:1], *self._scored(rows, [text], free[0])]
        return sorted(best, key=lambda hypothesis: -hypothesis.score)

    def _alike(self, free: Sequence[Hypothesis], wake: str | None) -> list[str]:
        """Sentences of the grammar that sound like one of the best free hypotheses."""
        if self._bank is None:
            self._bank = SentenceBank(self._language.grammar, self._language.spoken)
        start = "" if wake is None else f"{wake.capitalize()}, "
        alike = dict[str, None]()
        for each in free[:_LOOKED_AT]:
            words = each.text if wake is None else after_wake(each.text, wake) or ""
            alike |= dict.fromkeys(filter(None, [self._bank.mission(words, self.vocabulary)]))
            alike |= dict.fromkeys(self._bank.nearest(words, self.vocabulary, _ALIKE))
        return [start + text for text in list(alike)[:_TRIED]]

    def _scored(self, rows: Encoded, texts: Sequence[str], best: Hypothesis) -> list[Hypothesis]:
        """Texts as hypotheses whose scores compare with that of a free one, best first."""
        if not texts:
            return []
        fits = self._scorer.mean_fits(rows, texts)
        best_first = sorted(zip(fits, texts, strict=True), reverse=True)[:_WHOLE]
        likely = [text for _, text in best_first]
        fit_of_best, *fits = self._scorer.whole_fits(rows, [best.text, *likely])
        scores = (best.score + fit - fit_of_best for fit in fits)
        hypotheses = [Hypothesis(text, score) for text, score in zip(likely, scores, strict=True)]
        return sorted(hypotheses, key=lambda hypothesis: -hypothesis.score)


def transcribe(wav: Path, recogniser: Recogniser) -> Utterance:
    """Recognise what is said in a sound file.

    Raises:
        SoundError: the file cannot be read.
    """
    return recogniser.hear(read_sound(wav))


def require_model(name: str) -> None:
    """Refuse what is no speech model, before one is loaded; whether it is here yet is not checked.

    Raises:
        ConfigError: the package is missing, or `name` is neither a size, nor a name on the hub, nor
            a folder with a model.
    """
    try:
        from faster_whisper import available_models
    except ImportError as error:
        raise ConfigError(f"listening needs faster-whisper, not installed: {_REMEDY}") from error
    if Path(name).is_dir():
        if not (Path(name) / "model.bin").is_file():
            raise ConfigError(f"{name} holds no model.bin; give a folder of a faster-whisper model")
    elif name not in available_models() and not _ON_HUB.fullmatch(name):
        raise ConfigError(
            f"no speech model {name!r}; give a size ({', '.join(_SIZES)}), or the folder of a model"
            " for faster-whisper"
        )


def _load(name: str) -> WhisperModel:
    require_model(name)
    from faster_whisper import WhisperModel

    try:
        return WhisperModel(name, device="cpu", compute_type="int8")
    except Exception as error:  # Hub, network, disk and ctranslate2 each raise their own
        reason = " ".join(str(error).split())[:120]
        raise ConfigError(
            f"no speech model {name!r} ({reason}); give a size such as tiny.en with the network"
            " up, or the folder of a model for faster-whisper"
        ) from error


def _tokenizer(model: WhisperModel, name: str, language: Language) -> Tokenizer:
    from faster_whisper.tokenizer import Tokenizer

    multilingual = model.model.is_multilingual
    if not multilingual and language.code != "en":
        raise ConfigError(
            f"the speech model {name!r} knows English alone; give a multilingual one, for example"
            " --speech base"
        )
    return Tokenizer(model.hf_tokenizer, multilingual, task="transcribe", language=language.code)


def _rows(encoded: StorageView, samples: int) -> Encoded:
    """The rows of an encoded window that hold the sound, and a little of the silence after it."""
    rows: Encoded = np.asarray(encoded)[0]
    return rows[: math.ceil(samples / RATE * ROWS_PER_SECOND) + _TAIL]


def _noise() -> Sound:
    """2 s of pink noise, always the same."""
    spectrum = np.fft.rfft(np.random.default_rng(0).standard_normal(2 * RATE))
    spectrum /= np.sqrt(np.maximum(np.arange(len(spectrum)), 100))
    noise = np.fft.irfft(spectrum)
    return np.asarray(0.1 * noise / np.abs(noise).max(), np.float32)
