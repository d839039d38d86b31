"""Whisper listens: from sound to a command.

The words of the grammar and of the running map are given to Whisper as hints, and it is asked for
its ten best guesses instead of one: the first that is a command for something known is taken. Where
none is, it listens once more with no other words to choose from. What it then finds is taken only
if it fits the sound nearly as well as what it made of it freely.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

import numpy as np
from numpy.typing import NDArray

from vizbot.core.errors import ConfigError
from vizbot.operator.grammar import EXAMPLES, WORDS
from vizbot.operator.hearing import Guess, Heard, choose

if TYPE_CHECKING:
    from faster_whisper import WhisperModel
    from faster_whisper.tokenizer import Tokenizer

Sound = NDArray[np.float32]
"""(N,) samples of one channel at `RATE`, -1 to 1."""

RATE = 16000
"""Samples a second that Whisper takes."""
DEFAULT_MODEL = "tiny.en"
_GUESSES = 10
_LONGEST = 60
"""Tokens of an answer; a command has less than 40, and noise may make Whisper repeat itself."""
_FEATURES = 3000
"""Spectra of Whisper's window of 30 s."""
_REMEDY = "pip install faster-whisper"


class Recogniser:
    """A Whisper model that knows what people may ask a robot for.

    Attributes:
        vocabulary: Phrases that can be found, as given.
    """

    def __init__(
        self, vocabulary: Sequence[str], model: str = DEFAULT_MODEL, threads: int = 0
    ) -> None:
        """Load the model.

        Args:
            vocabulary: Phrases that can be found; those beyond the first 220 tokens or so are
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
        self._prompt = self._model.get_prompt(
            self._tokenizer,
            self._tokenizer.encode(" " + " ".join(EXAMPLES)),
            without_timestamps=True,
            hotwords=", ".join(self.vocabulary) or None,
        )
        self._foreign = _all_but(self._tokenizer, [*WORDS, *self.vocabulary])

    def hear(self, sound: Sound, wake: str | None = None) -> Heard:
        """What was said, and the command in it.

        Args:
            sound: One utterance.
            wake: What must be said first, except before "stop"; None: nothing.
        """
        if not self.speech(sound):
            return Heard("", None)
        encoded = self._encode(sound)
        free = self._guesses(encoded, [-1])
        known = [] if not free else self._guesses(encoded, self._foreign)
        return choose(free, known, self.vocabulary, wake)

    def glance(self, sound: Sound) -> str:
        """What is probably being said; a third of the work of `hear`."""
        guesses = self._guesses(self._encode(sound), [-1], 1)
        return guesses[0].text if guesses else ""

    def speech(self, sound: Sound) -> list[tuple[int, int]]:
        """Where somebody speaks: first sample and the one after the last, of each stretch."""
        from faster_whisper.vad import VadOptions, get_speech_timestamps

        options = VadOptions(min_silence_duration_ms=500, speech_pad_ms=200)
        spans = get_speech_timestamps(sound, options, RATE)
        return [(span["start"], span["end"]) for span in spans]

    def _encode(self, sound: Sound) -> object:
        from faster_whisper.audio import pad_or_trim

        spans = self.speech(sound)
        spoken = sound[spans[0][0] : spans[-1][1]] if spans else sound
        features = self._model.feature_extractor(spoken)[..., :_FEATURES]
        return self._model.encode(pad_or_trim(features, _FEATURES))

    def _guesses(
        self, encoded: object, suppressed: list[int], count: int = _GUESSES
    ) -> list[Guess]:
        """Best first; `suppressed` are tokens not to be used, -1 those that are no speech."""
        (result,) = self._model.model.generate(
            encoded,
            [self._prompt],
            beam_size=count,
            num_hypotheses=count,
            return_scores=True,
            suppress_tokens=suppressed,
            max_length=len(self._prompt) + _LONGEST,
        )
        texts = [self._tokenizer.decode(tokens).strip() for tokens in result.sequences_ids]
        return [
            Guess(text, score) for text, score in zip(texts, result.scores, strict=True) if text
        ]


def transcribe(wav: Path, recogniser: Recogniser) -> Heard:
    """What is said in a sound file.

    Raises:
        ConfigError: the file cannot be read.
    """
    return recogniser.hear(read_sound(wav))


def read_sound(source: Path | BinaryIO) -> Sound:
    """A sound file of any usual format, or an open one, as one channel at `RATE`.

    Raises:
        ConfigError: the file cannot be read.
    """
    named = str(source) if isinstance(source, Path) else "what was sent"
    if isinstance(source, Path) and not source.is_file():
        raise ConfigError(f"{source}: no such file; give a recording, for example a .wav")
    try:
        from av.error import FFmpegError
        from faster_whisper import decode_audio
    except ImportError as error:
        raise ConfigError(f"reading sound needs faster-whisper: {_REMEDY}") from error
    try:
        sound = decode_audio(named if isinstance(source, Path) else source, RATE)
    except (FFmpegError, IndexError, ValueError, TypeError) as error:
        raise ConfigError(f"{named} holds no sound that can be read; record a .wav") from error
    return np.asarray(sound, np.float32)


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


def _all_but(tokenizer: Tokenizer, phrases: Sequence[str]) -> list[int]:
    """All tokens but those that the phrases, with large or small letters, are written with."""
    words = {word for phrase in phrases for word in phrase.split()}
    words |= {word + "s" for word in words} | {word.capitalize() for word in words}
    kept = {token for word in words for token in tokenizer.encode(" " + word)}
    kept |= {token for mark in ".,?!" for token in tokenizer.encode(mark)}
    kept.add(tokenizer.eot)
    return [token for token in range(tokenizer.tokenizer.get_vocab_size()) if token not in kept]
