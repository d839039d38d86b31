"""Pictures of finished episodes: the true home with the driven path, and the last frame."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.episodes.episode import EpisodeResult
from benchmarks.episodes.homes import open_episode
from sim_stubs.scoring.success import instances_of, rooms_of
from sim_stubs.world.world import World
from vizbot.config import Config

Image = NDArray[np.uint8]

_RED, _GREEN, _BLUE, _DARK = (215, 40, 35), (20, 160, 60), (30, 80, 220), (40, 40, 46)
_LINE = 30
_JPEG_QUALITY = 80


@dataclass(frozen=True, slots=True)
class Picture:
    """A picture of an episode.

    Attributes:
        jpeg: The picture as JPEG.
        attributions: Author and licence of each model of furniture in it.
    """

    jpeg: bytes
    attributions: tuple[str, ...]


def draw_episode(result: EpisodeResult, config: Config) -> Picture:
    """Draw an episode from its result alone: the home is built anew."""
    with open_episode(result.episode, config) as world:
        world.place(*result.stop)
        picture = compose_picture(world, result)
        attributions = tuple(world.attributions)
    _, encoded = cv2.imencode(
        ".jpg", cv2.cvtColor(picture, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY]
    )
    return Picture(bytes(encoded), attributions)


def compose_picture(world: World, result: EpisodeResult) -> Image:
    """Draw the home and the last frame side by side, with the results of the goals below.

    Args:
        world: The world with the robot where it stopped.
        result: The result to draw.

    Returns:
        An RGB image. The path is red, its start blue; the last goal is outlined in green.
    """
    plan = world.top_view()
    text = result.goals[-1].text
    things = (world.instances[i] for i in instances_of(world, text))
    outlines = [room.polygon for room in rooms_of(world, text)]
    for outline in outlines or [it.footprint for it in things]:
        _polyline(plan, world, outline, _GREEN, closed=True)
    _polyline(plan, world, np.array(result.track).reshape(-1, 2), _RED)
    x, y, yaw = result.stop
    stop, ahead = np.array([x, y]), np.array([x + 0.4 * np.cos(yaw), y + 0.4 * np.sin(yaw)])
    _disc(plan, world, np.array(result.track[0] if result.track else stop), _BLUE)
    _disc(plan, world, stop, _RED)
    _polyline(plan, world, np.array([stop, ahead]), _RED)
    pictures = np.hstack([plan, world.render()[0]])
    caption = np.full((_LINE * len(result.goals), pictures.shape[1], 3), 255, np.uint8)
    for line, goal in enumerate(result.goals):
        text = f"home {result.episode.home}, {goal.text}: {goal.reason or 'success'}"
        text += f"  ({goal.steps} steps, {goal.path_length:.1f} m driven)"
        corner = (10, _LINE * line + 20)
        cv2.putText(caption, text, corner, cv2.FONT_HERSHEY_SIMPLEX, 0.55, _DARK, 1, cv2.LINE_AA)
    return np.asarray(np.vstack([pictures, caption]), np.uint8)


def _polyline(
    picture: Image,
    world: World,
    xy: NDArray[np.float64],
    colour: tuple[int, int, int],
    closed: bool = False,
) -> None:
    pixels = world.on_top_view(xy).round().astype(np.int32)
    cv2.polylines(picture, [pixels], closed, colour, 2, cv2.LINE_AA)


def _disc(
    picture: Image, world: World, xy: NDArray[np.float64], colour: tuple[int, int, int]
) -> None:
    column, row = world.on_top_view(xy).round().astype(int)
    cv2.circle(picture, (int(column), int(row)), 6, colour, -1, cv2.LINE_AA)
