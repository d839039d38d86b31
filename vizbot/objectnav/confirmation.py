"""Evidence from close by before the robot reports that it has arrived.

What was similar from across the room may be something else. On its way the robot sees it again and
again; then it stops, and turns until it has it in view. If views from several close positions agree
and it is in sight from where the robot stands, it is the goal. Otherwise the place is refuted: what
has been seen of it so far no longer counts, and the search goes on. The paper has no such step.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from nav.look_around import LookAround
from vizbot.config import ConfirmationConfig
from vizbot.core.types import SE3, STOP, Twist
from vizbot.perception.sightings import Sightings
from vizbot.perception.vicinity import is_within

SAME = 0.02
"""Elements whose similarity differs by less than this are equally good."""
NOTHING = np.zeros(0, np.int64)


@dataclass(slots=True, eq=False)
class _Look:
    """A look from one place.

    Attributes:
        since: Index of the first frame taken there at rest.
        from_xy: (2,) where the robot stands, in `map` [m].
        turn: The turn on the spot.
        until: Index of the frame at the end of the turn; None before.
        threshold: Similarity above which an element is the goal.
        place_xy: (2,) the place that the robot stopped for, in `map` [m].
        within: Elements within this distance of the place may be the goal [m].
    """

    since: int
    from_xy: NDArray[np.float64]
    turn: LookAround
    until: int | None
    threshold: float
    place_xy: NDArray[np.float64]
    within: float


class Confirmation:
    """Confirms or refutes places from close by, while searching for one goal."""

    def __init__(self, config: ConfirmationConfig, turn_rate: float) -> None:
        """Begin with no place refuted.

        Args:
            config: Required evidence.
            turn_rate: Angular velocity of a turn on the spot [rad/s].
        """
        self._config = config
        self._turn_rate = turn_rate
        self._refuted: list[tuple[NDArray[np.float64], int]] = []
        self._look: _Look | None = None
        self._last: _Look | None = None
        self.found = NOTHING
        """Indices of the elements that the last look confirmed, best first; empty if it refuted."""

    @property
    def looking(self) -> bool:
        """Whether a look is under way."""
        return self._look is not None

    def believable(self, sightings: Sightings) -> NDArray[np.float32]:
        """The similarities (N,), reduced at refuted places.

        They are -1 for what was seen there before, and for what is seen later they are reduced by
        `doubt` for every time that the place was refuted.
        """
        similarities = sightings.similarities
        for place_xy, frame in self._refuted:
            there = self._is_at(sightings, place_xy)
            doubted = np.where(
                sightings.frames < frame, np.float32(-1.0), similarities - self._config.doubt
            )
            similarities = np.where(there, doubted, similarities)
        return similarities

    def begin(
        self,
        next_frame: int,
        threshold: float,
        place_xy: NDArray[np.float64],
        within: float,
        T_map_base: SE3,
    ) -> None:
        """Begin a look from here.

        Args:
            next_frame: Index of the first frame taken here at rest.
            threshold: Similarity above which an element is the goal.
            place_xy: (2,) the place that the robot stopped for, in `map` [m].
            within: Elements within this distance of the place may be the goal [m].
            T_map_base: Where the robot stands; it does not turn there a second time.
        """
        from_xy, last = T_map_base[:2, 3].copy(), self._last
        if last is not None and np.linalg.norm(from_xy - last.from_xy) <= self._config.spacing:
            self._look = replace(last, threshold=threshold, place_xy=place_xy, within=within)
        else:
            turn = LookAround(self._turn_rate)
            self._look = _Look(next_frame, from_xy, turn, None, threshold, place_xy, within)

    def interrupt(self) -> None:
        """Drop the look, which neither confirms nor refutes: the robot has been moved."""
        self._look = None

    def step(
        self, sightings: Sightings, frame: int, floor_share: float, T_map_base: SE3
    ) -> Twist | None:
        """What to drive to see what is here; None once `found` holds the result.

        Args:
            sightings: Of the whole map, with believable similarities.
            frame: Index of the newest frame.
            floor_share: A view that shows nothing better counts with this share of the threshold
                (`mapping.clip.view_agreement`).
            T_map_base: Where the robot stands.
        """
        look, patience = self._look, self._config.patience
        if look is None:
            return None
        if self._confirms(look, sightings, 1.0, floor_share):
            return None
        if _awaited(sightings, look.since) and frame < look.since + patience:
            return STOP
        if look.until is None:
            twist = look.turn.twist(T_map_base)
            if twist is not None and frame < look.since + self._config.turn_patience:
                return twist
            look.until = frame
        if _awaited(sightings, look.until) and frame < look.until + patience:
            return STOP
        self._last = look
        if not self._confirms(look, sightings, self._config.in_sight_share, floor_share):
            self._look, self.found = None, NOTHING
            self._refuted.append((look.place_xy, frame + 1))
        return None

    def _confirms(
        self, look: _Look, sightings: Sightings, share: float, floor_share: float
    ) -> bool:
        """Whether something in sight reaches this share of the threshold and close views agree.

        If so, the look ends.
        """
        config, similarities = self._config, sightings.similarities
        in_sight = np.flatnonzero(
            (sightings.frames >= look.since) & (similarities >= share * look.threshold)
        )
        away = np.linalg.norm(sightings.points[in_sight, :2] - look.place_xy, axis=1)
        # A robot that has come back here has been elsewhere in between.
        moved = np.linalg.norm(sightings.seen_from[in_sight] - look.from_xy, axis=1)
        in_sight = in_sight[(moved <= config.spacing) & (away <= look.within)]
        if len(in_sight) == 0:
            return False
        in_sight = in_sight[self._agreed(look, sightings, in_sight, floor_share)]
        if len(in_sight) == 0:
            return False
        in_sight = in_sight[np.argsort(-similarities[in_sight], kind="stable")]
        apart = sightings.points[in_sight] - sightings.points[in_sight[0]]
        alike = similarities[in_sight] >= similarities[in_sight[0]] - SAME
        alike &= np.linalg.norm(apart, axis=1) <= config.agreement.radius
        self._look, self.found = None, in_sight[alike]
        return True

    def _agreed(
        self,
        look: _Look,
        sightings: Sightings,
        chosen: NDArray[np.int64],
        floor_share: float,
    ) -> NDArray[np.bool_]:
        """On which of the chosen elements (N,) views from several close positions agree."""
        config = self._config
        distances = np.linalg.norm(sightings.seen_from - look.place_xy, axis=1)
        near = sightings.take(distances <= config.near).by_position(config.spacing)
        floor = floor_share * look.threshold
        agreed = near.agreed_at(sightings.points[chosen, :2], config.agreement, floor)
        return np.asarray(agreed >= config.share * look.threshold)

    def _is_at(self, sightings: Sightings, place_xy: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which elements (N,) are at a place."""
        return is_within(sightings.points, place_xy, self._config.agreement.radius)


def _awaited(sightings: Sightings, frame: int) -> bool:
    """Whether nothing from `frame` on is embedded; a view without depth never is."""
    return not (sightings.frames >= frame).any()
