"""Training patches: views of training homes, cut into patches, with their facts."""

from __future__ import annotations

import io
import logging
import multiprocessing
import os
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import atan2, cos, pi, sin
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field

from mapping.clip.embedded.encoder import to_pixels
from sim_stubs.homes.geometry.house import House
from sim_stubs.homes.geometry.occupancy_slice import FreeSpace
from sim_stubs.realsense.config import ColourNoiseConfig
from sim_stubs.realsense.depth_noise import AutoExposure, noisy_colour
from sim_stubs.world.lighting import Lighting
from sim_stubs.world.renderer import Renderer
from sim_stubs.world.world_plan import D435I_COLOUR
from training.captions.facts import FACTS_DIGEST, Facts
from training.captions.house_facts import HouseFacts
from training.captions.patch_facts import seen
from training.homes import TrainingHome
from vizbot.core.errors import ConfigError
from vizbot.core.files import write_whole
from vizbot.core.geometry import camera_mount, planar
from vizbot.core.settings import SETTINGS
from vizbot.core.types import SE3

logger = logging.getLogger(__name__)
PATCH_EDGES = ((400, 480), (190, 270), (190, 270), (190, 270),
               (90, 140), (90, 140), (90, 140), (90, 140), (90, 140), (48, 70))  # fmt: skip
"""Least and greatest edge of each patch cut from a picture [px]: around the mapper's scales."""
AIMED = 0.65
"""Share of the views and patches that are aimed at a thing."""
NEAREST, FARTHEST = 0.6, 4.5
"""Least and largest distance from which things are viewed [m]."""
NEAR = 1.5
"""Largest distance of a view from beside a thing [m]."""
INDOORS = 0.8
"""Share of the views of a thing from its own room; walls hide most things in the others."""


@dataclass(frozen=True, slots=True, eq=False)
class LabelledPatches:
    """Patches of pictures.

    Attributes:
        pixels: (N, 96, 96, 3) uint8, RGB.
        edges: (N,) int32, edge of each patch in its picture [px].
        facts: Facts of the patches.
    """

    pixels: NDArray[np.uint8]
    edges: NDArray[np.int32]
    facts: Facts

    def __len__(self) -> int:
        return len(self.edges)

    @classmethod
    def load(cls, path: Path) -> Self:
        """Read a file that `save` wrote.

        Raises:
            ConfigError: it has another vocabulary of facts.
        """
        with np.load(path, allow_pickle=False) as arrays:
            if str(arrays["digest"]) != FACTS_DIGEST:
                raise ConfigError(f"{path} knows other facts than this version: delete it")
            facts = Facts(arrays["starts"], arrays["indices"], arrays["strengths"])
            return cls(arrays["pixels"], arrays["edges"], facts)

    @classmethod
    def joined(cls, several: Sequence[Self]) -> Self:
        """All patches of `several`, one after another."""
        return cls(
            np.concatenate([views.pixels for views in several]),
            np.concatenate([views.edges for views in several]),
            Facts.joined([views.facts for views in several]),
        )

    def save(self, path: Path) -> None:
        """Write a file, whole or not at all."""
        content = io.BytesIO()
        np.savez(
            content,
            pixels=self.pixels,
            edges=self.edges,
            starts=self.facts.starts,
            indices=self.facts.indices,
            strengths=self.facts.strengths,
            digest=np.array(FACTS_DIGEST),
        )
        write_whole(path, content.getvalue())


def take_all(
    folder: Path, homes: Sequence[TrainingHome], views: ViewsConfig, workers: int
) -> list[Path]:
    """Files with the patches of the pictures of each home, taken where they are missing."""
    files = [folder / f"{home.name}.npz" for home in homes]
    folder.mkdir(parents=True, exist_ok=True)
    missing = [
        (home, path, views) for home, path in zip(homes, files, strict=True) if not path.exists()
    ]
    os.environ.setdefault("LP_NUM_THREADS", "1")  # Mesa's; there is a process for each core
    with multiprocessing.get_context("spawn").Pool(workers) as pool:
        for done, name in enumerate(pool.imap_unordered(_take_one, missing), 1):
            logger.info("pictures of home %s taken, %d of %d", name, done, len(missing))
    return files


def _take_one(task: tuple[TrainingHome, Path, ViewsConfig]) -> str:
    home, path, views = task
    take_views(home.house(), home.seed, views).save(path)
    return home.name


class ViewsConfig(BaseModel):
    """Settings of the pictures of a home."""

    model_config = SETTINGS

    pictures: int = Field(default=60, gt=0)
    """Pictures of each home; ten patches are cut from each picture."""
    near: float = Field(default=0.0, ge=0.0, le=1.0)
    """Part of the pictures aimed at a thing that are taken from beside it (NEAR)."""


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """A picture of a home, with patches of it.

    Attributes:
        rgb: (480, 640, 3) uint8.
        boxes: (P, 4) int32, u0, v0, u1, v1 of the patches [px], ends excluded.
        things: (P,) index in `House.instances` of what takes up most of each patch; -1 where that
            is walls, floor or ceiling.
        facts: Facts of the patches.
    """

    rgb: NDArray[np.uint8]
    boxes: NDArray[np.int32]
    things: NDArray[np.int64]
    facts: Facts


def take_views(house: House, seed: int, views: ViewsConfig) -> LabelledPatches:
    """Patches of pictures of a home, taken from places that a robot can reach.

    Raises:
        DeviceError: the machine cannot render.
    """
    pixels, edges, facts = [], [], []
    for picture in pictures(house, seed, views):
        pixels.append(to_pixels([picture.rgb[v0:v1, u0:u1] for u0, v0, u1, v1 in picture.boxes]))
        edges.append(picture.boxes[:, 2] - picture.boxes[:, 0])
        facts.append(picture.facts)
    return LabelledPatches(np.concatenate(pixels), np.concatenate(edges), Facts.joined(facts))


def pictures(house: House, seed: int, views: ViewsConfig) -> Iterator[Picture]:
    """Pictures of a home, taken from places that a robot can reach.

    Raises:
        DeviceError: the machine cannot render.
    """
    rng = np.random.default_rng((seed, 3))
    house_facts = HouseFacts.from_house(house)
    places = _places(house)
    eye = Renderer(house, D435I_COLOUR, Lighting.drawn(rng))
    noise = ColourNoiseConfig()
    try:
        for _ in range(views.pictures):
            T_world_cam = _viewpoint(house_facts, places, views.near, rng)
            rgb, depth = eye.render(T_world_cam)
            gain = AutoExposure(noise).gain(rgb, 0.0) * float(rng.uniform(0.85, 1.15))
            rgb = noisy_colour(rgb, gain, float(rng.exponential(2.0)), noise, rng)
            segmentation = eye.segment(T_world_cam)
            boxes = _boxes(segmentation, rng)
            most = [
                np.bincount(segmentation[v0:v1, u0:u1].ravel() + 1).argmax() - 1
                for u0, v0, u1, v1 in boxes
            ]
            facts = seen(house_facts, segmentation, depth, T_world_cam, D435I_COLOUR, boxes)
            yield Picture(rgb, boxes, np.array(most, np.int64), facts)
    finally:
        eye.close()


def _places(house: House) -> NDArray[np.float64]:
    """x, y (N, 2) where the robot can get from the start [m].

    Where the start of a home that was furnished anew is taken, it starts where there is most room.
    """
    space = FreeSpace.from_house(house)
    reached = space.reached(house.start[0], house.start[1])
    if not reached.any():
        widest = np.unravel_index(space.clear.argmax(), space.clear.shape)
        (start,) = space.grid.pixels_to_xy(np.array([widest[::-1]]))
        reached = space.reached(start[0], start[1])
    rows, columns = np.nonzero(reached)
    return space.grid.pixels_to_xy(np.column_stack([columns, rows]))


def _viewpoint(
    house_facts: HouseFacts,
    places: NDArray[np.float64],
    near_share: float,
    rng: np.random.Generator,
) -> SE3:
    """A pose of the camera, aimed at a thing or not; all classes are aimed at equally often."""
    house = house_facts.house
    counts = Counter(it.label for it in house.instances)
    weights = np.array([1.0 / counts[it.label] for it in house.instances])
    yaw = float(rng.uniform(-pi, pi))
    x, y = places[rng.integers(len(places))]
    if rng.random() < AIMED:
        thing = house.instances[rng.choice(len(weights), p=weights / weights.sum())]
        offsets = np.array([thing.x, thing.y]) - places
        distances = np.linalg.norm(offsets, axis=1)
        farthest = NEAR if near_share and rng.random() < near_share else FARTHEST
        near = np.nonzero((distances > NEAREST) & (distances < farthest))[0]
        if rng.random() < INDOORS:
            rooms = house_facts.rooms.rooms_at(places)
            near = near[rooms[near] == rooms[np.argmin(distances)]]
        if len(near):
            chosen = near[rng.integers(len(near))]
            x, y = places[chosen]
            yaw = atan2(offsets[chosen, 1], offsets[chosen, 0]) + float(rng.normal(0.0, 0.3))
    mount = camera_mount(
        height=float(rng.uniform(0.5, 0.7)),
        forward=0.05,
        tilt=float(rng.normal(0.15, 0.05)),
    )
    roll = float(rng.normal(0.0, 0.01))
    T_roll = np.eye(4)
    T_roll[:2, :2] = [[cos(roll), -sin(roll)], [sin(roll), cos(roll)]]
    return np.asarray(planar(float(x), float(y), yaw) @ mount @ T_roll)


def _boxes(segmentation: NDArray[np.int32], rng: np.random.Generator) -> NDArray[np.int32]:
    """Squares (P, 4) u0, v0, u1, v1 to cut from a picture [px], inside it."""
    height, width = segmentation.shape
    things = np.unique(segmentation[::4, ::4])
    things = things[things >= 0]
    boxes = []
    for least, greatest in PATCH_EDGES:
        edge = int(rng.integers(least, greatest + 1))
        u, v = rng.integers(width), rng.integers(height)
        if len(things) and rng.random() < AIMED:
            rows, columns = np.nonzero(segmentation == things[rng.integers(len(things))])
            pixel = rng.integers(len(rows))
            u, v = columns[pixel], rows[pixel]
        u0 = int(np.clip(u - edge // 2, 0, width - edge))
        v0 = int(np.clip(v - edge // 2, 0, height - edge))
        boxes.append((u0, v0, u0 + edge, v0 + edge))
    return np.array(boxes, np.int32)
