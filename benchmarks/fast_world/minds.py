"""What decides in the fast world: the robot's search by belief, or the paper's.

A mind keeps what was seen and says what to do next; `benchmarks.fast_world.walk` moves the robot.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from mapping.clip.mapped_frames import MappedFrame
from mapping.clip.mapper import ClipMap
from mapping.clip.places.place_rows import PlaceMap
from mapping.clip.scores import Background
from nav.frontier import FrontierSearch
from sim_stubs.world.world_plan import D435I_COLOUR
from vizbot.config import Config
from vizbot.core.types import SE3, OccupancyGrid
from vizbot.objectnav.belief_search import BeliefSearch
from vizbot.objectnav.candidates import question_of
from vizbot.objectnav.paper_search import PaperSearch, RunningScores
from vizbot.objectnav.search_parts import ALL_PARTS, SearchParts
from vizbot.objectnav.tasks import Decision, Goal
from vizbot.perception.sightings import Sightings
from vizbot.rehearsal.belief_fit.views import View

if TYPE_CHECKING:  # its module loads torch
    from mapping.clip.encoder import ClipEncoder

_POSES = {0: np.eye(4)}
"""All is anchored to one keyframe at the origin: true poses do not move."""


class Mind(Protocol):
    """Searches for one goal."""

    def see(self, number: int, view: View, T_map_cam: SE3, from_xy: NDArray[np.float64]) -> None:
        """Take the view of this step; it is in the map one step later, as an embedding is.

        Args:
            number: Of the view.
            view: What it shows.
            T_map_cam: Where its picture was taken.
            from_xy: (2,) where the robot is, in `map` [m].
        """
        ...

    def look(self, grid: OccupancyGrid, T_map_base: SE3) -> None:
        """Mark what the camera sees from a pose as explored."""
        ...

    def interrupt(self) -> None:
        """Forget the present way: something else has moved the robot."""
        ...

    def decide(self, grid: OccupancyGrid, T_map_base: SE3, step: int) -> Decision:
        """What to do in this step."""
        ...


class PaperMind:
    """The paper's method, with the CLIP map of one goal, and from where its elements were seen."""

    def __init__(self, config: Config, encoder: ClipEncoder, goal: Goal) -> None:
        """Begin with nothing seen."""
        self._goal, self._search = goal, PaperSearch(config.navigator)
        self._map, self._scores = ClipMap(encoder.dimension), RunningScores()
        self._seen_from: list[NDArray[np.float64]] = []
        self._keyframes: dict[int, int] = {}
        self._pending: tuple[int, View, SE3] | None = None

    def see(self, number: int, view: View, T_map_cam: SE3, from_xy: NDArray[np.float64]) -> None:
        """Take the view of this step."""
        if self._pending is not None:
            before, seen, T_map_before = self._pending
            keyframe = self._keyframes.setdefault(before, len(self._keyframes))
            frame = MappedFrame(len(self._seen_from) - 1, keyframe, T_map_before, 0.0)
            self._map.add(frame, seen.elements)
        self._pending = number, view, T_map_cam
        self._seen_from.append(from_xy)

    def look(self, grid: OccupancyGrid, T_map_base: SE3) -> None:
        """Do nothing: the paper knows no frontiers."""

    def interrupt(self) -> None:
        """Forget the present way."""
        self._search.interrupt()

    def decide(self, grid: OccupancyGrid, T_map_base: SE3, step: int) -> Decision:
        """What to do in this step."""
        elements = self._map.elements
        sightings = Sightings(
            elements.points_keyframe,
            self._scores.similarities_to(self._goal, elements.embeddings),
            np.array(self._seen_from)[elements.frames],
        )
        return self._search.go(self._goal, sightings, grid, T_map_base)


class BeliefMind:
    """The search by belief."""

    def __init__(
        self,
        config: Config,
        encoder: ClipEncoder,
        goal: Goal,
        parts: SearchParts = ALL_PARTS,
    ) -> None:
        """Begin with nothing seen.

        Args:
            config: Settings of the robot.
            encoder: Embeds the background.
            goal: What is looked for.
            parts: Parts that the search has.
        """
        self._background = Background.embedded_by(encoder)
        self._map, self._places = ClipMap(encoder.dimension), PlaceMap(D435I_COLOUR)
        self._statistics = np.zeros((0, 2), np.float32)
        self._goal, self._question = goal, question_of(goal)
        self._frontiers = FrontierSearch(config.frontier)
        self._search = BeliefSearch(config, self._frontiers, parts)
        self._robot_radius = config.navigator.costmap.robot_radius
        self._pending: tuple[View, SE3] | None = None

    def see(self, number: int, view: View, T_map_cam: SE3, from_xy: NDArray[np.float64]) -> None:
        """Take the view of this step, if it is new."""
        if self._pending is not None:
            seen, T_map_before = self._pending
            frame = MappedFrame(len(self._places.frames), 0, T_map_before, 0.0)
            self._places.add(frame, T_map_before, seen.footprint, len(self._map))
            self._map.add(frame, seen.elements)
            fresh = self._background.statistics(seen.elements.embeddings)
            self._statistics = np.concatenate([self._statistics, fresh])
        self._pending = (view, T_map_cam) if self._places.is_new_view(T_map_cam, 0.0) else None

    def look(self, grid: OccupancyGrid, T_map_base: SE3) -> None:
        """Mark what the camera sees."""
        self._frontiers.look(grid, T_map_base, self._robot_radius)

    def interrupt(self) -> None:
        """Forget the present way."""
        self._search.interrupt()

    def decide(self, grid: OccupancyGrid, T_map_base: SE3, step: int) -> Decision:
        """What to do in this step."""
        places = self._places
        belief = self._search.belief_of(self._goal, self._question).update(
            self._map.embeddings,
            self._statistics,
            self._background.pictures,
            places.rows,
            places.placed(_POSES),
        )
        belief = self._search.as_judged(self._goal, belief)
        return self._search.go(self._goal, belief, grid, T_map_base)
