"""The scorer: did the robot get there? It knows the truth, and the robot never sees it."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np

from sim_stubs.house import Instance
from sim_stubs.world import World

REACH = 2.0
"""The robot must stop this near [m] (paper, section IV-C)."""
LOOKS = 12
"""Directions of a full turn; their pictures overlap."""
VISIBLE_PIXELS = 50
"""This much of the thing must be in sight in one of them."""


@dataclass(frozen=True, slots=True)
class Verdict:
    """What the scorer says.

    Attributes:
        success: Stopped by itself, within reach, in sight by turning.
        distance: From the robot's centre to the nearest instance on the plan [m]; None when the
            world has none.
        visible: Whether turning on the spot brings an instance within reach into sight.
        reason: Why not, in a few words; empty on success.
    """

    success: bool
    distance: float | None
    visible: bool
    reason: str


def judge(world: World, text: str, *, stopped: bool) -> Verdict:
    """Score the robot where it stands.

    Args:
        world: The truth.
        text: The goal in words: a label ("yellow chair"), or its last words ("chair", which any
            chair fulfils).
        stopped: Whether the robot says that it has arrived.
    """
    wanted = [i for i, it in enumerate(world.instances) if _is(it, text)]
    if not wanted:
        return Verdict(False, None, False, f"no {text.strip()} in this world")
    distances = [distance_to(world, world.instances[i]) for i in wanted]
    nearest = min(distances)
    within = [i for i, distance in zip(wanted, distances, strict=True) if distance <= REACH]
    visible = bool(within) and is_visible(world, within)
    reason = ""
    if not stopped:
        reason = "did not stop by itself"
    elif not within:
        reason = f"{nearest:.2f} m away"
    elif not visible:
        reason = "not in sight"
    return Verdict(reason == "", nearest, visible, reason)


def distance_to(world: World, instance: Instance) -> float:
    """From the robot's centre to the nearest point of the instance's footprint [m]."""
    T = instance.T_world_piece
    local = T[:2, :2].T @ (world.T_world_base[:2, 3] - T[:2, 3])
    return float(np.linalg.norm(np.maximum(np.abs(local) - instance.piece.size[:2] / 2, 0.0)))


def is_visible(world: World, instances: list[int]) -> bool:
    """Whether a turn on the spot brings one of the `instances` (indices) into sight."""
    for turn in np.arange(LOOKS) * 2 * pi / LOOKS:
        shown = world.segment(float(turn))
        if any(np.count_nonzero(shown == i) >= VISIBLE_PIXELS for i in instances):
            return True
    return False


def _is(instance: Instance, text: str) -> bool:
    label, words = instance.label.casefold(), " ".join(text.casefold().split())
    return label == words or label.endswith(f" {words}")
