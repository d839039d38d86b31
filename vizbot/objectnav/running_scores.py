"""How similar everything on the map is to what is asked for, each element asked once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mapping.clip.retrieval import similarities
from vizbot.objectnav.tasks import Goal, Task, Waypoint


class RunningScores:
    """Of the elements of a CLIP map that only grows."""

    def __init__(self) -> None:
        """Nothing is asked for."""
        self._asked: Goal | Waypoint | Task = Task.MAP
        self._scores = np.zeros(0, np.float32)

    def of(
        self, task: Goal | Waypoint | Task, embeddings: NDArray[np.float32]
    ) -> NDArray[np.float32]:
        """Similarities (N,) to a goal, zero for another task.

        Args:
            task: Another one than before begins anew.
            embeddings: (N, D) unit; those asked before come first.
        """
        if task is not self._asked:
            self._asked, self._scores = task, np.zeros(0, np.float32)
        fresh = embeddings[len(self._scores) :]
        if isinstance(task, Goal):
            scores = similarities(fresh, task.embedding)
        else:
            scores = np.zeros(len(fresh), np.float32)
        self._scores = np.concatenate([self._scores, scores])
        return self._scores
