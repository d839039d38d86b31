"""Searches the sentences that fit a sound: Whisper aligns them with it, a beam keeps the best.

A sentence's score is log p(text | sound) - `PRIOR` log p(text | noise), so that rare words stand a
chance against frequent ones: subtraction of the internal language model, as in McDermott et al., "A
density ratio approach to language model fusion in end-to-end ASR", ASRU 2019, and Meng et al.,
"Internal language model estimation for domain-adaptive end-to-end ASR", SLT 2021.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from vizbot.operator.language.phrase_grammar import Phrasing, Sentence, Stage

if TYPE_CHECKING:
    from ctranslate2.models import Whisper
    from faster_whisper.tokenizer import Tokenizer

Encoded = NDArray[np.float32]
"""(N, D) what Whisper's encoder makes of a sound, 50 rows a second."""

PRIOR = 0.5
"""Weight of how likely a text is in any case; chosen on the even half of
`tests/helpers/spoken.py`."""
END = 0.5
"""How much worse a sentence with something at its end may fit than one without it, in the mean of
its tokens: what is not said makes it worse by 0.9 and more where it is quiet."""
ROWS_PER_SECOND = 50
"""Rows of an encoded sound for each second."""
ENDED = -1.5
"""Logarithm of the probability that nothing more is said, from which a sentence is believed to be
whole: of the sentences for building whole ones had -1.1 and more where it is quiet, those that were
cut at a comma or at "and" less than -1.5."""
FOUND = 1.0
"""Log odds of a thing that the running map finds: it is asked for e times as often as others."""
_KEPT = {Stage.OPENING: 2, Stage.REST: 2, Stage.NEXT_GOAL: 2}
"""Width of the beam after a stage; 3 after others."""
_SHORTLIST = 8
"""Goals tried with each beginning but the best one, which is tried with every goal."""
_FAR = 10.0
"""A beginning that is this far below the best is dropped."""
_JOINT = 5.0
"""Allowance for a sentence that goes on, since its end still explains some of the sound."""
_LEAST = 1e-9
_NEXT = 12
"""Pieces of a sentence that are tried at most, the likeliest by their first token, and all others
that begin with one of these tokens."""
_UNLIKELY = 6.0
"""Those that are this far below the likeliest one are not tried [log]."""
_ENDS_LOOKED_AT = 6
"""Whole sentences of which it is asked whether more is said after them."""
_FASTEST = 18.0
"""Letters in a second of the sound and its tail, which nobody speaks faster than."""
_SLOWEST = 5.0
"""Letters in a second of speech, which nobody speaks slower than: a sentence with fewer leaves some
of the sound out."""
_SILENCE = 1.4
"""How much of the sound and its tail is taken for silence [s]."""
_GOAL_STAGES = (Stage.GOAL, Stage.GOALS, Stage.NEXT_GOAL)


class PhraseScorer:
    """Scores texts by how well they fit a sound; remembers the scores of texts without a sound."""

    def __init__(
        self, whisper: Whisper, tokenizer: Tokenizer, noise: Encoded, phrasing: Phrasing
    ) -> None:
        self._phrasing = phrasing
        self._whisper = whisper
        self._tokenizer = tokenizer
        self._noise = noise
        self._priors: dict[str, float] = {"": 0.0}

    def fits(self, encoded: Encoded, texts: Sequence[str]) -> list[float]:
        """Logarithm of the probability that what is said begins with each text; 0 for none."""
        if not any(texts):
            return [0.0] * len(texts)
        return [
            float(read.sum()) if text else 0.0
            for text, read in zip(texts, self._read(encoded, texts), strict=True)
        ]

    def mean_fits(self, encoded: Encoded, texts: Sequence[str]) -> list[float]:
        """The same in the mean of each text's tokens."""
        return [float(read.mean()) for read in self._read(encoded, texts)]

    def whole_fits(self, encoded: Encoded, texts: Sequence[str]) -> list[float]:
        """The same where nothing more is said after each text."""
        read = self._read(encoded, texts)
        ends = [self._end_fit(encoded, text) for text in texts]
        return [
            float((each.sum() + end) / (len(each) + 1))
            for each, end in zip(read, ends, strict=True)
        ]

    def completed(self, encoded: Encoded, text: str) -> str:
        """The same sentence, with what is asked for at its end where that is in the sound, too.

        Whisper drops the end of some sentences without a trace.
        """
        if self._end_fit(encoded, text) >= ENDED:
            return text
        further = self._phrasing.further(text)
        fit, *fits = self.mean_fits(encoded, [text, *further])
        best = max(range(len(fits)), key=fits.__getitem__)
        if fits[best] >= fit - END:
            return further[best]
        whole, longer = self.whole_fits(encoded, [text, further[best]])
        return further[best] if longer > whole else text

    def _end_fit(self, encoded: Encoded, text: str) -> float:
        """Logarithm of the probability that nothing more is said after a text."""
        expected = self._next_tokens(encoded, self._tokenizer.encode(" " + text))
        return float(expected[self._tokenizer.eot])

    def _read(self, encoded: Encoded, texts: Sequence[str]) -> list[NDArray[np.float64]]:
        """The logarithms of the probabilities of each text's tokens."""
        import ctranslate2

        batch = np.repeat(encoded[None], len(texts), axis=0)
        read = self._whisper.align(
            ctranslate2.StorageView.from_array(batch),
            list(self._tokenizer.sot_sequence),
            [self._tokenizer.encode(" " + text) for text in texts],
            [len(encoded)] * len(texts),
        )
        return [np.log(np.maximum(one.text_token_probs, _LEAST)) for one in read]

    def priors(self, texts: Sequence[str]) -> list[float]:
        """The same without a sound."""
        new = [text for text in texts if text not in self._priors]
        self._priors.update(zip(new, self.fits(self._noise, new), strict=True))
        return [self._priors[text] for text in texts]

    def search(
        self,
        encoded: Encoded,
        goals: Sequence[str],
        found: Sequence[str] = (),
        wake: str | None = None,
    ) -> list[Sentence]:
        """The sentences that fit best, best first; of the goals those `found` are likelier."""
        beam = [Sentence() if wake is None else Sentence(wake.capitalize() + ",")]
        done: list[Sentence] = []
        fewest = _SLOWEST * (len(encoded) / ROWS_PER_SECOND - _SILENCE)
        while beam:
            stage = beam[0].stage
            grown = sorted(self._grown(encoded, beam, goals, found), key=_badness)
            done += [
                each for each in grown if each.stage is Stage.DONE and len(each.text) >= fewest
            ]
            least = max((each.score for each in [*grown, *done]), default=0.0) - _FAR
            going = [each for each in grown if each.stage is not Stage.DONE and each.score > least]
            beam = going[: _KEPT.get(stage, 3)]
        best = sorted(done, key=_badness)[:_ENDS_LOOKED_AT]
        ended = [
            replace(each, score=each.score + self._end_fit(encoded, each.text)) for each in best
        ]
        return sorted(ended, key=_badness)

    def _grown(
        self,
        encoded: Encoded,
        beam: Sequence[Sentence],
        goals: Sequence[str],
        found: Sequence[str],
    ) -> list[Sentence]:
        """All sentences that the beam may become with one piece more."""
        grown: list[Sentence] = []
        for sentence in beam:
            further = self._likely(encoded, sentence, self._phrasing.continued(sentence, goals))
            here = self._scored(encoded, sentence, further, found)
            if sentence is beam[0] and sentence.stage in _GOAL_STAGES:
                goals = [each.piece for each in sorted(here, key=_badness)[:_SHORTLIST]]
            grown += here
        return grown

    def _likely(
        self, encoded: Encoded, sentence: Sentence, further: Sequence[Sentence]
    ) -> Sequence[Sentence]:
        """Those of the sentences that may have been said in the time, and begin likely enough."""
        letters = _FASTEST * len(encoded) / ROWS_PER_SECOND
        sayable = [each for each in further if len(each.text) <= letters] or further[:1]
        if len(sayable) <= _NEXT:
            return sayable
        begun = self._tokenizer.encode(" " + sentence.text) if sentence.text else []
        tokens = [self._tokenizer.encode(" " + each.text) for each in sayable]
        if any(each[: len(begun)] != begun or len(each) == len(begun) for each in tokens):
            return sayable
        expected = self._next_tokens(encoded, begun)
        firsts = [each[len(begun)] for each in tokens]
        likeliest = sorted({*firsts}, key=lambda token: -expected[token])
        least = max(
            expected[sorted(firsts, key=lambda token: -expected[token])[_NEXT - 1]],
            expected[likeliest[0]] - _UNLIKELY,
        )
        return [
            each for each, token in zip(sayable, firsts, strict=True) if expected[token] >= least
        ]

    def _next_tokens(self, encoded: Encoded, begun: Sequence[int]) -> NDArray[np.float32]:
        """The logarithm of the probability of each token after those that were said."""
        import ctranslate2

        prompt = [*self._tokenizer.sot_sequence, self._tokenizer.no_timestamps, *begun]
        (result,) = self._whisper.generate(
            ctranslate2.StorageView.from_array(np.ascontiguousarray(encoded[None])),
            [prompt],
            beam_size=1,
            max_length=max(2 * len(begun) + 2, len(prompt) + 1),  # half of it are steps at most
            return_logits_vocab=True,
            suppress_blank=False,
            suppress_tokens=[],
        )
        logits = np.asarray(result.logits[0][len(begun)], np.float32).reshape(-1)
        shifted = logits - logits.max()
        expected: NDArray[np.float32] = shifted - np.log(np.exp(shifted).sum())
        return expected

    def _scored(
        self,
        encoded: Encoded,
        sentence: Sentence,
        further: Sequence[Sentence],
        found: Sequence[str],
    ) -> list[Sentence]:
        fits = self.fits(encoded, [each.text for each in further])
        scored = []
        for each, fit, prior in zip(further, fits, self._expected(sentence, further), strict=True):
            handicap = sentence.handicap + PRIOR * prior
            if sentence.stage in _GOAL_STAGES and each.piece in found:
                handicap -= FOUND
            if sentence.stage is Stage.REST and each.piece != sentence.ending:
                handicap -= _JOINT
            scored.append(replace(each, handicap=handicap, score=fit - handicap))
        return scored

    def _expected(self, sentence: Sentence, further: Sequence[Sentence]) -> list[float]:
        """How likely each piece is in any case; joints and ends count as certain."""
        if sentence.stage in _GOAL_STAGES:
            many = sentence.stage is Stage.GOALS
            before = self._phrasing.before(many=many)
            pieces = [self._phrasing.plural(each.piece) if many else each.piece for each in further]
            texts = [f"{before} {piece}" for piece in pieces]
        elif sentence.stage in (Stage.OPENING, Stage.VERB, Stage.ARTICLE):
            before, texts = sentence.text, [each.text for each in further]
        else:
            return [0.0] * len(further)
        (expected,) = self.priors([before])
        return [prior - expected for prior in self.priors(texts)]


def _badness(sentence: Sentence) -> float:
    return -sentence.score
