"""The choice of what a run simulates, checked before anything is opened."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path

from sim_stubs.faults.catalogue import PlannedFault, parse_faults
from sim_stubs.world.world_spec import parse_start, require_world, seed_of
from vizbot.config import Config
from vizbot.core.errors import ConfigError
from vizbot.rehearsal.config import RehearsalConfig
from vizbot.rehearsal.plan_process import PlanProcess


@dataclass(frozen=True, slots=True)
class RehearsalChoice:
    """What is simulated in a run.

    Attributes:
        world: The simulated world; empty where its camera is a real one, or a recording.
        first_goal: A simulated world puts the robot down far from it.
        labels: TOML file with labels of what is in an MJCF or SDF file.
        start: x, y [m], yaw [rad] where a simulated world puts the robot down instead.
        faults: Planned faults, which the robot does not know of.
    """

    world: str
    first_goal: str = ""
    labels: Path | None = None
    start: tuple[float, float, float] | None = None
    faults: Sequence[PlannedFault] = ()


def choose(
    camera: str,
    base: str,
    world: str,
    first_goal: str = "",
    labels: Path | None = None,
    start: str | None = None,
    faults: str | None = None,
) -> RehearsalChoice:
    """What the options of a dry run ask for, as the command takes them.

    Raises:
        ConfigError: there is no such world, start or fault, or a fault has no device to happen to.
    """
    planned = [] if faults is None else parse_faults(faults)
    require_faults(camera, base, planned)
    if camera != "sim":
        world = ""
    else:
        require_world(world, labels)
    place = None if start is None else parse_start(start)
    return RehearsalChoice(world, first_goal, labels, place, planned)


def require_faults(camera: str, base: str, faults: Sequence[PlannedFault]) -> None:
    """Refuse faults that none of the devices can have.

    Raises:
        ConfigError: a fault has no device to happen to.
    """
    if (camera, base) == ("sim", "sim"):
        return
    for planned in faults:
        fault = planned.fault
        if fault.device == "base" or fault.name == "encoder-slow":
            raise ConfigError(
                f"--faults {fault.name} happens to a simulated base and camera, not to --base"
                f" {base}; use --camera sim --base sim"
            )


def world_beside(
    choice: RehearsalChoice, config: Config
) -> AbstractContextManager[PlanProcess | None]:
    """A simulated home, planned by another process while this one loads the rest; else nothing."""
    if seed_of(choice.world) is None:
        return nullcontext()
    body = RehearsalConfig.read(config).world
    outline = body.outline(config.mount.height, config.mount.forward)
    return PlanProcess(choice.world, outline, choice.first_goal, choice.start)
