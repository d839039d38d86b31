"""Whisper listens: from sound to a command.

Whisper first guesses freely, with examples and the words of the running map as hints. Then the
sentence that fits the sound best is searched among those that ask for something known. It is taken
if it fits nearly as well as the free guess; else the free guess is, as far as it is a command.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

import av
import numpy as np
from av.error import FFmpegError, InvalidDataError
from numpy.typing import NDArray

from vizbot.core.errors import ConfigError
from vizbot.operator.client.endpoint import SPEECH
from vizbot.operator.language.command_grammar import EXAMPLES
from vizbot.operator.voice.beam_search import Encoded, PhraseScorer
from vizbot.operator.voice.intent import Hypothesis, Utterance, after_wake, choose_utterance

if TYPE_CHECKING:
    from ctranslate2 import StorageView
    from faster_whisper import WhisperModel
    from faster_whisper.tokenizer import Tokenizer

Sound = NDArray[np.float32]
"""(N,) samples of one channel at `RATE`, -1 to 1."""

RATE = 16000
"""Samples a second that Whisper takes."""
_GUESSES = 10
_LONGEST = 60
"""Tokens of an answer; a command has less than 40, and noise may make Whisper repeat itself."""
_SLOWEST = 4000
"""Samples a second that speech needs; far less of them would become far too many at `RATE`."""
_ROWS_PER_SECOND = 50
"""Of the encoded sound."""
_TAIL = 50
"""Rows of the encoded sound that are read after its end."""
_LONGEST_COMMAND = 10.0
"""Who speaks longer [s] talks to somebody else; to search would take long."""
_FEATURES = 3000
"""Spectra of Whisper's window of 30 s."""
_REMEDY = "pip install faster-whisper"


class Recogniser:
    """A Whisper model that knows what people may ask a robot for.

    Attributes:
        vocabulary: Phrases that can be asked for, as given.
    """

    def __init__(self, vocabulary: Sequence[str], model: str = SPEECH, threads: int = 0) -> None:
        """Load the model.

        Args:
            vocabulary: Phrases that can be asked for; those beyond the first 220 tokens or so are
                recognised, but not hinted at.
            model: A size (tiny.en, base.en, small, ...), which is downloaded on first use, or a
                folder with a model for faster-whisper.
            threads: Of the processor; 0 leaves it to the library.

        Raises:
            ConfigError: the model or a package is missing.
        """
        self.vocabulary = tuple(vocabulary)
        self._model = _load(model, threads)
        self._tokenizer = _tokenizer(self._model)
        noise = _rows(self._encode(_noise()), len(_noise()))
        self._scorer = PhraseScorer(self._model.model, self._tokenizer, noise)
        self.learn(())

    def learn(self, found: Sequence[str]) -> None:
        """Take note of what the running map finds: it is hinted at first, and sooner understood.

        Args:
            found: Those of the vocabulary; what is not of it is left out.
        """
        known = tuple(phrase for phrase in found if phrase in self.vocabulary)
        others = [phrase for phrase in self.vocabulary if phrase not in known]
        prompt = self._model.get_prompt(
            self._tokenizer,
            self._tokenizer.encode(" " + " ".join(EXAMPLES)),
            without_timestamps=True,
            hotwords=", ".join([*known, *others]) or None,
        )
        self._hints = known, prompt  # at once, since another thread may be listening

    def hear(self, sound: Sound, wake: str | None = None) -> Utterance:
        """What was said, and the command in it.

        Args:
            sound: One utterance.
            wake: What must be said first, except before "stop"; None: nothing.
        """
        spoken = self._spoken(sound)
        if spoken is None:
            return Utterance("", None)
        found, _ = self._hints
        encoded = self._encode(spoken)
        free = self._guesses(encoded)
        known = self._known(_rows(encoded, len(spoken)), free, wake)
        return choose_utterance(free, known, self.vocabulary, wake, found)

    def glance(self, sound: Sound) -> str:
        """What is probably being said; a third of the work of `hear`."""
        spoken = self._spoken(sound)
        hypotheses = self._guesses(self._encode(sound if spoken is None else spoken), 1)
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

    def _guesses(self, encoded: StorageView, count: int = _GUESSES) -> list[Hypothesis]:
        """Made of any words, best first."""
        _, prompt = self._hints
        (result,) = self._model.model.generate(
            encoded,
            [prompt],
            beam_size=count,
            num_hypotheses=count,
            return_scores=True,
            max_length=len(prompt) + _LONGEST,
        )
        texts = [self._tokenizer.decode(tokens).strip() for tokens in result.sequences_ids]
        return [
            Hypothesis(text, score)
            for text, score in zip(texts, result.scores, strict=True)
            if text
        ]

    def _known(self, rows: Encoded, free: list[Hypothesis], wake: str | None) -> list[Hypothesis]:
        """The sentence that asks for something known and fits best, scored beside a free guess."""
        if not free or len(rows) > _LONGEST_COMMAND * _ROWS_PER_SECOND:
            return []
        if wake is not None and after_wake(free[0].text, wake) is None:
            return []
        found, _ = self._hints
        sentences = self._scorer.search(rows, self.vocabulary, found, wake)
        if not sentences:
            return []
        text = sentences[0].text
        fit, fit_of_free = self._scorer.mean_fits(rows, [text, free[0].text])
        return [Hypothesis(text, free[0].score + fit - fit_of_free)]


def transcribe(wav: Path, recogniser: Recogniser) -> Utterance:
    """What is said in a sound file.

    Raises:
        ConfigError: the file cannot be read.
    """
    return recogniser.hear(read_sound(wav))


def read_sound(source: Path | BinaryIO, longest: float | None = None) -> Sound:
    """A sound file of any usual format, or an open one, as one channel at `RATE`.

    Args:
        source: The file.
        longest: What comes later is not decoded [s]; None: all is.

    Raises:
        ConfigError: the file cannot be read, or holds less than 4000 samples a second.
    """
    named = str(source) if isinstance(source, Path) else "what was sent"
    if isinstance(source, Path) and not source.is_file():
        raise ConfigError(f"{source}: no such file; give a recording, for example a .wav")
    wanted = None if longest is None else round(longest * RATE)
    pieces = [np.zeros(0, np.int16)]
    count = 0
    try:
        resampler = av.AudioResampler("s16", "mono", RATE)
        file = av.open(source, mode="r", metadata_errors="ignore")
        with file, suppress(InvalidDataError):  # where it is torn it ends
            for frame in chain(file.decode(audio=0), [None]):
                if frame is not None and frame.sample_rate < _SLOWEST:
                    raise ConfigError(
                        f"{named} has {frame.sample_rate} samples a second, too few for speech;"
                        f" record with {RATE}"
                    )
                for piece in resampler.resample(frame):
                    pieces.append(piece.to_ndarray()[0])
                    count += piece.samples
                if wanted is not None and count >= wanted:
                    break
    except (FFmpegError, IndexError, ValueError, TypeError) as error:
        raise ConfigError(f"{named} holds no sound that can be read; record a .wav") from error
    return np.concatenate(pieces)[:wanted].astype(np.float32) / np.float32(32768)


def _load(name: str, threads: int) -> WhisperModel:
    try:
        from faster_whisper import WhisperModel
    except ImportError as error:
        raise ConfigError(f"listening needs faster-whisper, not installed: {_REMEDY}") from error
    if Path(name).is_dir() and not (Path(name) / "model.bin").is_file():
        raise ConfigError(f"{name} holds no model.bin; give a folder of a faster-whisper model")
    try:
        return WhisperModel(name, device="cpu", compute_type="int8", cpu_threads=threads)
    except Exception as error:  # Hub, network, disk and ctranslate2 each raise their own
        reason = " ".join(str(error).split())[:120]
        raise ConfigError(
            f"no speech model {name!r} ({reason}); give a size such as tiny.en with the network"
            " up, or the folder of a model for faster-whisper"
        ) from error


def _tokenizer(model: WhisperModel) -> Tokenizer:
    from faster_whisper.tokenizer import Tokenizer

    multilingual = model.model.is_multilingual
    return Tokenizer(model.hf_tokenizer, multilingual, task="transcribe", language="en")


def _rows(encoded: StorageView, samples: int) -> Encoded:
    """Of the encoded window the sound itself, and a little of the silence after it."""
    rows: Encoded = np.asarray(encoded)[0]
    return rows[: math.ceil(samples / RATE * _ROWS_PER_SECOND) + _TAIL]


def _noise() -> Sound:
    """2 s of pink noise, always the same."""
    spectrum = np.fft.rfft(np.random.default_rng(0).standard_normal(2 * RATE))
    spectrum /= np.sqrt(np.maximum(np.arange(len(spectrum)), 100))
    noise = np.fft.irfft(spectrum)
    return np.asarray(0.1 * noise / np.abs(noise).max(), np.float32)
