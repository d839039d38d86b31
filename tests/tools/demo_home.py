"""The home of the demo: the first one for development whose goal is some way off.

`python -m tests.tools.demo_home` prints it; training has rendered none of these homes.
"""

from __future__ import annotations

import typer

from sim_stubs.homes.furniture.procedural import DEVELOPMENT
from sim_stubs.homes.goal_chair import GOAL
from sim_stubs.scoring.shortest_path import nearest_path_length
from sim_stubs.world.body import WorldConfig
from sim_stubs.world.world_name import open_world

LEAST_WAY = 5.0
"""The true way from the start to the demo's goal is longer [m]."""


def demo_home() -> int:
    """The first of the homes 1100, 1101, ... with a yellow chair over LEAST_WAY from the start."""
    return next(seed for seed in DEVELOPMENT if _way(seed) > LEAST_WAY)


def _way(seed: int) -> float:
    """True length of the way to the goal [m]; 0 where there is no goal, or no way."""
    with open_world(str(seed), WorldConfig(), text=GOAL) as world:
        return nearest_path_length(world, GOAL) or 0.0


if __name__ == "__main__":
    typer.echo(f'"{GOAL}" --world {demo_home()}')
