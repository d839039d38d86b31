"""One more try before a task ends in vain: what the robot only bumped into may be gone."""

from __future__ import annotations

from nav.frontier import FrontierSearch
from vizbot.core.observer import Outcome
from vizbot.core.types import STOP
from vizbot.objectnav import reasons
from vizbot.objectnav.tasks import Decision, Errand
from vizbot.perception.interfaces import ObstacleMapper

IN_VAIN = (Outcome.NOT_FOUND, Outcome.EXPLORED)


class SecondTry:
    """Takes what the bumper touched for gone where a task would end in vain, once in a task.

    A person, a pet or a door that has moved since would close the room behind it for good, since no
    camera need have seen it. Edges and virtual walls stay.
    """

    def __init__(self) -> None:
        self._tried: Errand | None = None

    def instead_of(
        self, decision: Decision, task: Errand, mapper: ObstacleMapper, frontiers: FrontierSearch
    ) -> Decision:
        """The decision; where it would end the task in vain, a step that lets it go on instead.

        `mapper` knows what was touched; `frontiers` that were given up because of it are open
        again.
        """
        if decision.ended is None or decision.ended[0] not in IN_VAIN:
            return decision
        again = task is not self._tried and mapper.forget_touched()
        self._tried = task if again else None
        if not again:
            return decision
        frontiers.reopen()
        return Decision(STOP, "trying again", why=reasons.MAY_BE_GONE)
