"""What the map of a running robot finds, asked for again and again beside whoever listens."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import Self

from vizbot.core.errors import VizbotError

PERIOD = 10.0
"""So often the robot is asked [s]."""
_PATIENCE = 1.0
"""So long an answer is waited for at the end [s]."""


class VocabularyUpdater:
    """Keeps telling what the map finds; in a thread, since nobody may wait for it to hear "stop".

    Entering it begins, leaving it ends.
    """

    def __init__(
        self,
        vocabulary: Callable[[], Sequence[str]],
        learn: Callable[[Sequence[str]], None],
        period: float = PERIOD,
    ) -> None:
        """Ask nothing yet.

        Args:
            vocabulary: Asks the robot; raises a `VizbotError` where it does not answer.
            learn: Takes the phrases, from another thread; none where the robot does not answer.
            period: Of asking [s].
        """
        self._vocabulary = vocabulary
        self._learn = learn
        self._period = period
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._follow, name="map words", daemon=True)

    def ask(self) -> None:
        """Ask once, now."""
        try:
            found = tuple(self._vocabulary())
        except VizbotError:  # the household's words are left
            found = ()
        self._learn(found)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *exc: object) -> None:
        self._ended.set()
        self._thread.join(_PATIENCE)

    def _follow(self) -> None:
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
"""Things and rooms, in alphabetical order."""
