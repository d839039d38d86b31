"""A search in the fast world: the robot's search, on true poses and on views made before.

One step is one frame, as in the whole loop: the view from the nearest place, with the nearest
heading, enters the maps; the search decides; and its twist moves the true body for the time of a
frame. What is left out: errors of poses and depth, wires, latencies but that of the embedding, and
the safety behaviours, of which only a plain backing off from contacts is kept.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.episodes.episode import EncoderScale, Episode, EpisodeResult, GoalResult
from benchmarks.episodes.homes import open_benchmark_home, start_of
from benchmarks.episodes.other_encoders import OtherEncoder
from benchmarks.fast_world.minds import BeliefMind, Mind, PaperMind
from mapping.occupancy.depth_mapper import DepthMapper
from nav.recovery import contact_points, edge_points
from sim_stubs.scoring.shortest_path import nearest_path_length
from sim_stubs.scoring.success import judge
from vizbot.config import Config
from vizbot.core.closeable import Closeable
from vizbot.core.diff_drive import wheel_speeds
from vizbot.core.geometry import yaw_of
from vizbot.core.observer import Outcome
from vizbot.core.types import SE3, OccupancyGrid, Twist
from vizbot.objectnav.looks import LookAround
from vizbot.objectnav.search_parts import ALL_PARTS, SearchParts
from vizbot.objectnav.tasks import Decision, Goal, goal_of
from vizbot.rehearsal.belief_fit.places import Places
from vizbot.rehearsal.belief_fit.views import HEADINGS, View, Views, pose_of
from vizbot.rehearsal.config import RehearsalConfig

if TYPE_CHECKING:  # its module loads torch
    from mapping.clip.encoder import ClipEncoder

FRAME_RATE = 3.5
"""Frames a second of the simulated camera; a step is one frame."""
BODY = {"slip_noise": 0.0, "wheel_scale_noise": 0.0, "step": 0.05}
"""Settings of a body that rolls truly, in longer steps."""
BACKING_OFF, BACK_OFF = 3, Twist(-0.1, 0.0)
"""Number of steps in which the robot backs off from what it has touched, and how."""


@dataclass(frozen=True, slots=True)
class SearchRule:
    """A row of the fast world: how the search is run."""

    name: str
    config: Config
    parts: SearchParts = ALL_PARTS


class FastHome(Closeable):
    """A home with the true body of the robot, and the views that were made so far."""

    def __init__(
        self,
        seed: int,
        config: Config,
        encoder: ClipEncoder,
        folder: Path,
        scale: EncoderScale | None = None,
    ) -> None:
        """Open the home.

        Args:
            seed: Number of the home.
            config: Settings of the robot.
            encoder: Embeds the views.
            folder: Keeps the views.
            scale: What is made of the encoder's cosines; None leaves them as they are.
        """
        rehearsal = RehearsalConfig.read(config)
        still = rehearsal.model_copy(update={"world": rehearsal.world.model_copy(update=BODY)})
        self.seed = seed
        self.world = open_benchmark_home(seed, still.within(config))
        self._other = None if scale is None else OtherEncoder(encoder, scale)
        self.encoder: ClipEncoder = self._other or encoder
        self.places = Places.in_world(self.world)
        self.views = Views(self.world, encoder, config.perception, folder / str(seed))
        self._embedded: dict[int, View] = {}

    def close(self) -> None:
        """Keep the new views, and free the renderer."""
        self.views.save()
        self.world.close()

    def view_at(self, T_world_base: SE3) -> tuple[int, View, SE3]:
        """The view nearest to a pose: its number, content, and the T_world_base that it shows."""
        x, y = T_world_base[:2, 3].tolist()
        place = self.places.nearest(x, y)
        heading = round(yaw_of(T_world_base) / (2 * np.pi / HEADINGS)) % HEADINGS
        xy, number = self.places.xy[place], place * HEADINGS + heading
        if number not in self._embedded:
            self._embedded[number] = self._as_embedded(self.views.view(xy, place, heading))
        return number, self._embedded[number], pose_of(xy, heading)

    def _as_embedded(self, view: View) -> View:
        """A view as the encoder has it that the search is given."""
        if self._other is None:
            return view
        embeddings = self._other.embeddings_of_pictures(view.elements.embeddings)
        return replace(view, elements=replace(view.elements, embeddings=embeddings))


class Walk:
    """One search under way.

    Attributes:
        steps: How many were done.
        way: Length of the driven path [m].
    """

    def __init__(self, home: FastHome, rule: SearchRule, episode: Episode) -> None:
        """Put the robot where the episode begins.

        Raises:
            ConfigError: there is no start for its goal.
        """
        config = self._config = rule.config
        self._home, self._rule, self._episode = home, rule, episode
        self._text = episode.goals[0]
        self._goal: Goal = goal_of(home.encoder, self._text, config.objectnav.threshold)
        self._rest()
        home.world.place(*start_of(episode))
        self._shortest = nearest_path_length(home.world, self._text)
        self._mapper = DepthMapper(config.perception.depth_mapper)
        self._mind = self._new_mind()
        self._look_around = LookAround(config.objectnav.look_around_rate)
        self._backing_off = 0
        self.steps, self.way = 0, 0.0

    def run(self) -> EpisodeResult:
        """Search until the robot ends it, or for as long as it may take."""
        began, collisions = time.monotonic(), self._home.world.collisions
        ended: tuple[Outcome, str] = (Outcome.GAVE_UP, "the steps are used up")
        while self.steps < self._config.objectnav.max_steps:
            decision = self._step()
            if decision.ended is not None:
                ended = decision.ended
                break
        self._rest()
        claimed = ended[0] is Outcome.ARRIVED
        world = self._home.world
        verdict = judge(world, self._text, stopped=claimed)
        T = world.T_world_base
        goal = GoalResult(
            self._text,
            verdict.success,
            claimed,
            verdict.reason,
            ended[1],
            None if verdict.distance is None else round(verdict.distance, 3),
            self.steps,
            round(self.way, 3),
            None if self._shortest is None else round(self._shortest, 3),
            round(self.steps / FRAME_RATE, 2),
        )
        stop = round(float(T[0, 3]), 3), round(float(T[1, 3]), 3), round(yaw_of(T), 3)
        wall_seconds = round(time.monotonic() - began, 1)
        hits = world.collisions - collisions
        return EpisodeResult(self._episode, (goal,), hits, None, wall_seconds, (), stop)

    def _step(self) -> Decision:
        """See, map, decide, move."""
        world = self._home.world
        T_map_base = world.T_world_base
        number, view, T_map_pictured = self._home.view_at(T_map_base)
        T_map_cam = T_map_pictured @ world.T_base_cam
        self._mind.see(number, view, T_map_cam, T_map_base[:2, 3])
        # All is anchored to one keyframe at the origin: true poses do not move.
        self._mapper.add_scan(0, T_map_cam, T_map_cam, view.scan)
        self._mapper.mark_free(T_map_base, self._config.navigator.costmap.robot_radius)
        grid = self._mapper.grid()
        if self._backing_off:
            self._backing_off -= 1
            decision = Decision(BACK_OFF, "backing off")
        else:
            self._mind.look(grid, T_map_pictured)
            decision = self._decide(grid, T_map_base)
        self._drive(decision.twist)
        self.steps += 1
        return decision

    def _new_mind(self) -> Mind:
        config, encoder = self._config, self._home.encoder
        if config.objectnav.method == "paper":
            return PaperMind(config, encoder, self._goal)
        return BeliefMind(config, encoder, self._goal, self._rule.parts)

    def _decide(self, grid: OccupancyGrid, T_map_base: SE3) -> Decision:
        settings = self._config.objectnav
        looks = settings.look_around and settings.method != "paper"
        turn = self._look_around.twist(T_map_base) if looks else None
        if turn is not None:
            return Decision(turn, "looking around")
        return self._mind.decide(grid, T_map_base, self.steps)

    def _drive(self, twist: Twist) -> None:
        """Move the body for the time of a frame, and back off from what it touches."""
        world = self._home.world
        wheel_base = RehearsalConfig.read(self._config).world.wheel_base
        before = world.T_world_base
        world.set_wheel_speeds(*wheel_speeds(twist, wheel_base))
        world.advance(1.0 / FRAME_RATE)
        after, contacts = world.T_world_base, world.contacts
        self.way += float(np.linalg.norm(after[:2, 3] - before[:2, 3]))
        if self._backing_off:
            return
        radius = self._config.navigator.costmap.robot_radius
        touched = contact_points(contacts.bump_left, contacts.bump_right, radius)
        touched = np.vstack([touched, edge_points(contacts.cliffs, radius)])
        if len(touched):
            self._mapper.mark_obstacle(after, touched)
            self._mind.interrupt()
            self._backing_off = BACKING_OFF

    def _rest(self) -> None:
        """Let the wheels come to rest."""
        self._home.world.set_wheel_speeds(0.0, 0.0)
        self._home.world.advance(1.0)
