"""English phrasings of facts: noun phrases, and ways to say that something is there.

Fields of a phrasing: {bare} "red sofa", {a} "a red sofa", {the} "the red sofa".
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

PLAIN = ("{bare}", "{bare}", "{a}", "{the}")
"""Phrasings of most goals."""

PHOTO = (
    "a photo of {a}", "a photo of the {bare}", "a picture of {a}", "a picture of the {bare}",
    "an image of {a}", "a close-up of {a}", "a snapshot of {a}", "a view of {a}",
    "a photo showing {a}", "a cropped photo of {a}", "a blurry photo of {a}",
    "a bright photo of {a}", "a photo of {a} in a room", "a photo of {a} at home",
    "photo of {a}", "picture of {a}", "a rendering of {a}", "an indoor photo of {a}",
    "a low resolution photo of {a}", "a good photo of {a}", "a photo of one {bare}",
)  # fmt: skip
"""Phrasings of picture captions."""

THERE = (
    "there is {a}", "there is {a} here", "here is {a}", "this is {a}", "this is the {bare}",
    "one can see {a}", "i see {a}", "i can see {a} here", "{a} stands here", "we see {a}",
    "it is {a}", "it shows {a}", "the picture shows {a}", "you can see {a}", "that is {a}",
    "{a} in the room", "{a} is here", "it looks like {a}", "here we have {a}",
    "something like {a}", "some {bare}", "the robot sees {a}", "the camera shows {a}",
)  # fmt: skip
"""Phrasings of statements."""

GO = (
    "go to {the}", "go to {a}", "drive to {the}", "find {the}", "find {a}", "find me {a}",
    "where is {the}", "where is {the}?", "look for {a}", "look for {the}", "search for {a}",
    "take me to {the}", "bring me to {the}", "i want to go to {the}", "i am looking for {a}",
    "move to {the}", "navigate to {the}", "show me {the}", "show me {a}", "stop at {the}",
    "please go to {the}", "can you find {the}", "can you find {a}?", "is there {a}?",
    "go near {the}", "approach {the}", "head to {the}", "travel to {a}", "robot, go to {the}",
    "get to {the}", "where can i find {a}?", "i need {a}", "where do you see {a}?",
)  # fmt: skip
"""Phrasings of requests."""

PHRASINGS = (PLAIN, PHOTO, THERE, GO)
PHRASING_WEIGHTS = (0.46, 0.2, 0.14, 0.2)
"""Weights of the kinds of phrasings."""

WITHHELD_PHRASINGS = (
    "could you lead me over to {the}", "{bare}, please", "a sketch of {a}",
    "would you kindly drive up to {the}", "i would love to see {the} again",
    "hey robot, off to {the}", "what does {the} look like?", "a scene containing {a}",
    "somebody put {a} over there", "make your way towards {the}", "point the lens at {the}",
    "let us visit {the} now", "wait beside {the}", "a frame in which {a} appears",
    "my friends have {a} like that", "have you noticed {the}?", "park yourself near {the}",
    "tell me when you reach {the}", "an old polaroid of {a}", "return to {the} at once",
    "guide us to {the}", "does this home have {a}?", "inspect {the} closely",
    "just roll over to {the}", "a wide shot with {a}", "nearest {bare}", "locate {the}",
    "a webcam image with {a}", "everyone is waiting at {the}", "the one and only {bare}",
)  # fmt: skip
"""Phrasings that no caption has; the encoder is examined with them."""

WITH_COLOUR = ("{colour} {noun}",) * 6 + (
    "{noun} in {colour}", "{noun} that is {colour}", "{colour} coloured {noun}",
    "{noun} of {colour} colour",
)  # fmt: skip
WITH_MATERIAL = ("{material} {noun}",) * 3 + ("{noun} made of {stuff}", "{noun} of {stuff}")
COUNTED: Mapping[str, tuple[str, ...]] = {
    "two": ("two {}", "two {}", "a pair of {}"),
    "several": ("several {}", "many {}", "a group of {}", "a lot of {}"),
}
"""Phrasings of counts."""
RELATED: Mapping[str, tuple[str, ...]] = {
    "on": ("{a} on {b}", "{a} on {b}", "{a} on top of {b}", "{a} that stands on {b}",
           "{a} standing on {b}", "{b} with {a} on it", "{b} with {a} on top"),
    "next to": ("{a} next to {b}", "{b} next to {a}", "{a} next to {b}", "{b} next to {a}",
                "{a} beside {b}", "{b} beside {a}", "{a} by {b}", "{b} by {a}",
                "{a} close to {b}", "{b} near {a}", "{a} near {b}", "{b} standing next to {a}"),
    "in front of": ("{a} in front of {b}", "{a} in front of {b}", "{a} before {b}",
                    "{b} with {a} in front of it", "{b} behind {a}"),
    "above": ("{a} above {b}", "{a} above {b}", "{a} over {b}", "{a} hanging above {b}",
              "{b} under {a}", "{b} below {a}", "{b} with {a} above it"),
}  # fmt: skip
"""Phrasings of a relation of {a} to {b}."""

ROOM = (
    "in {the}", "inside {the}", "a room that is {a}", "the robot is in {the}", "we are in {the}",
    "go into {the}", "drive into {the}", "the inside of {a}", "the interior of {a}",
    "somewhere in {the}", "a view into {the}", "{a} of a home", "enter {the}",
)  # fmt: skip
"""Phrasings of rooms alone."""

_PLURAL = frozenset({"blinds", "drapes", "drawers", "flowers", "laundry", "shelves", "shoes",
                     "stairs", "steps"})  # fmt: skip
"""Names that take no article."""


@dataclass(frozen=True, slots=True)
class NounPhrase:
    """The noun phrase of a phrasing.

    Attributes:
        words: The words without an article.
        counted: Whether it takes "a" or "an".
    """

    words: str
    counted: bool = True

    @staticmethod
    def from_name(name: str, words: str = "") -> NounPhrase:
        """The phrase of a thing's name, with adjectives or more around it in `words`."""
        return NounPhrase(words or name, not _is_plural(name))

    @property
    def with_article(self) -> str:
        """The words with "a" or "an" where they take one."""
        if not self.counted:
            return self.words
        return f"{'an' if self.words[0] in 'aeiou' else 'a'} {self.words}"


def phrased(phrasing: str, noun: NounPhrase) -> str:
    """A phrasing with its noun."""
    return phrasing.format(bare=noun.words, a=noun.with_article, the=f"the {noun.words}")


def plural_noun(name: str) -> str:
    """The plural of a thing's name: "sofas", "boxes", "studies", "chests of drawers"."""
    if _is_plural(name):
        return name
    head, of, rest = name.partition(" of ")
    if head.endswith("shelf"):
        return f"{head[:-1]}ves{of}{rest}"
    if head.endswith("y") and head[-2] not in "aeiou":
        return f"{head[:-1]}ies{of}{rest}"
    return f"{head}{'es' if head.endswith(('s', 'x', 'ch', 'sh')) else 's'}{of}{rest}"


def _is_plural(name: str) -> bool:
    return name.partition(" of ")[0].split()[-1] in _PLURAL
