"""The household's words, and which of them the map of a running robot finds."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import Self

from vizbot.core.errors import VizbotError

PERIOD = 10.0
"""Period of asking the robot [s]."""
_PATIENCE = 1.0
"""Longest wait for an answer at the end [s]."""


class VocabularyUpdater:
    """Keeps a recogniser's vocabulary up to date with the map of the robot.

    It asks in a thread of its own: hearing "stop" must not wait for the robot's answer. Entering
    starts the thread, leaving ends it.
    """

    def __init__(
        self,
        vocabulary: Callable[[], Sequence[str]],
        learn: Callable[[Sequence[str]], None],
        period: float = PERIOD,
    ) -> None:
        """Create it without asking.

        `vocabulary` asks the robot, and raises a `VizbotError` where it does not answer; `learn`
        takes the phrases, from another thread, none where it does not. It is asked every `period`
        [s].
        """
        self._vocabulary = vocabulary
        self._learn = learn
        self._period = period
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._work, name="vocabulary", daemon=True)

    def ask(self) -> None:
        """Ask once, now."""
        try:
            found = tuple(self._vocabulary())
        except VizbotError:  # the words of any household are still there
            found = ()
        self._learn(found)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *exc: object) -> None:
        self._ended.set()
        self._thread.join(_PATIENCE)

    def _work(self) -> None:
        while not self._ended.is_set():
            self.ask()
            self._ended.wait(self._period)


HOUSEHOLD: tuple[str, ...] = (
    "armchair", "backpack", "bathroom", "bathtub", "bed", "bedroom", "bench", "bicycle",
    "black suitcase", "blue armchair", "bookshelf", "bottle", "brown wardrobe", "bunk bed",
    "cardboard box", "carpet", "chair", "chest of drawers", "clock", "coffee machine",
    "coffee table", "computer", "crib", "cup", "curtain", "desk", "dining table", "door",
    "dryer", "electric fan", "fireplace", "floor lamp", "green plant", "guitar", "hallway",
    "keyboard", "kid's room", "kitchen", "kitchen cabinet", "lamp", "laptop",
    "laundry basket", "laundry room", "living room", "microwave", "mirror", "nightstand",
    "office chair", "oven", "piano", "picture", "plant", "printer", "radiator", "red sofa",
    "refrigerator", "shelf", "shower", "sink", "sofa", "stairs", "stool", "study", "suitcase",
    "table", "table lamp", "teddy bear", "television", "toilet", "trash can", "umbrella",
    "vacuum cleaner", "vase", "wardrobe", "washing machine", "white table", "window",
    "yellow chair",
)  # fmt: skip
"""Things and rooms of any household, in alphabetical order."""
