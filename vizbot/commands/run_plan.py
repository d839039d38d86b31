"""What the options of a run ask for, checked before anything heavy is loaded or opened."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from vizbot.commands.config.discovery import load_settings, with_rehearsal
from vizbot.commands.options import DryRunOptions, LaunchOptions, RunOptions, ServiceOptions
from vizbot.commands.sentences import parse_goals
from vizbot.config import Config
from vizbot.core.errors import ConfigError
from vizbot.core.types import Intrinsics
from vizbot.operator.api.listener import require_service
from vizbot.operator.language.language import load_language
from vizbot.operator.viewer.open_viewer import require_rerun
from vizbot.recorder import default_folder, require_run_folder
from vizbot.rig import (
    FETCHED_EASILY,
    PHOTOS_FETCHED,
    is_rehearsal_encoder,
    require_devices,
    require_encoder,
    require_mix,
    require_names,
)

if TYPE_CHECKING:  # loads what a run without a saved map begins without
    from mapping.map_bundle import MapBundle
    from vizbot.rehearsal.choice import RehearsalChoice
    from vizbot.rehearsal.plan_process import PlanProcess

_LIVE = ("sim", "realsense")
"""Cameras that are no recordings."""


@dataclass(frozen=True, slots=True, eq=False)
class RunPlan:
    """What the options of a run ask for, checked before a device is opened.

    Attributes:
        folder: New or empty; it is made when the devices are open.
        config: Settings, with the encoder that `--clip` names.
        saved_map: The map to begin in; None for an empty one.
        rerun: Whether the run is recorded for the rerun viewer.
        map_folder: Where the saved map is; None without one.
    """

    folder: Path
    config: Config
    saved_map: MapBundle | None
    rerun: bool
    map_folder: Path | None = None


@dataclass(frozen=True, slots=True)
class DeviceChoice:
    """The devices of a run, as `Rig` takes them.

    Attributes:
        camera: `sim`, `realsense`, or the path of a recording.
        base: `sim`, `roomba` or `none`.
        recording: Intrinsics and metres per unit of depth of a recorded folder without
            `camera.json`.
        rehearsal: What is simulated; None where nothing is.
    """

    camera: str
    base: str
    recording: tuple[Intrinsics, float] | None = None
    rehearsal: RehearsalChoice | None = None

    @property
    def world(self) -> str:
        """The simulated world; empty where there is none."""
        return "" if self.rehearsal is None else self.rehearsal.world


@dataclass(frozen=True, slots=True, eq=False)
class DryRunPlan:
    """What the options of a dry run ask for.

    Attributes:
        goals: What to go to, in this order.
    """

    run: RunPlan
    devices: DeviceChoice
    goals: Sequence[str]


def plan_run(options: RunOptions) -> RunPlan:
    """Check what can be checked before a device is opened.

    Raises:
        VizbotError: the folder holds something or cannot be made, a setting cannot be used, rerun
            is not installed, or there is no such map.
    """
    folder = options.out or default_folder()
    require_run_folder(folder)
    if options.rerun:
        require_rerun()
    config = load_settings(options.config, options.clip, options.method)
    require_encoder(config.clip, config.device)
    if options.map_folder is None:
        return RunPlan(folder, config, None, options.rerun)
    saved_map, map_folder = _loaded(options.map_folder)
    return RunPlan(folder, config, saved_map, options.rerun, map_folder)


def plan_dry_run(options: DryRunOptions) -> DryRunPlan:
    """Check what can be checked before a device, a world or an encoder is opened.

    Raises:
        VizbotError: an argument cannot be used.
    """
    goals = parse_goals(options.goals or [], load_language(options.service.language))
    _require_something_to_do(goals, options)
    _refuse_service_of_nobody(options)
    devices = _device_choice(goals, options)
    run = plan_run(options.run)
    require_names(run.config.clip, goals)
    if devices.rehearsal is not None:
        run = replace(run, config=with_rehearsal(run.config))
    require_devices(run.config, devices.camera, devices.base)
    if options.serve:
        require_service(options.service.service())
    return DryRunPlan(run, devices, goals)


def plan_launch(options: LaunchOptions) -> RunPlan:
    """Check what can be checked before the doctor examines the devices.

    Raises:
        VizbotError: an argument cannot be used.
    """
    load_language(options.service.language)
    plan = plan_run(options.run)
    _require_encoder_of_pictures(plan.config.clip, options.run.clip)
    require_service(options.service.service())
    return plan


def world_beside(plan: DryRunPlan) -> AbstractContextManager[PlanProcess | None]:
    """A simulated home, planned by another process while this one loads the rest; else nothing."""
    if plan.devices.rehearsal is None:
        return nullcontext()
    from vizbot.rehearsal import choice

    return choice.world_beside(plan.devices.rehearsal, plan.run.config)


def _loaded(given: Path) -> tuple[MapBundle, Path]:
    """The saved map that is given by its folder, its run's or its name; and its folder."""
    from mapping import map_bundle
    from vizbot.operator.session.saved_maps import find_map

    folder = find_map(given)
    map_bundle.require_growable(folder)
    return map_bundle.load(folder), folder


def _require_encoder_of_pictures(clip: str, typed: str | None) -> None:
    """Refuse the rehearsal encoder among real things, unless a person names it."""
    if is_rehearsal_encoder(clip) and typed is None:
        raise ConfigError(
            f"clip {clip}: the rehearsal encoder knows simulated homes alone; choose one of real"
            f" pictures, {FETCHED_EASILY}, or {PHOTOS_FETCHED} (docs/robot.md compares them, vizbot"
            " doctor times them), or rehearse with --clip embedded"
        )


def _require_something_to_do(goals: Sequence[str], options: DryRunOptions) -> None:
    if not goals and not options.explore and not options.serve:
        raise ConfigError("no TEXT and no --explore: nothing to do. See: vizbot dry-run --help")
    if goals and options.explore and options.serve:
        raise ConfigError("--explore with --serve takes no TEXT; ask for it after the exploration")


def _refuse_service_of_nobody(options: DryRunOptions) -> None:
    """Refuse options of serving where nothing is served; `--language` is also for goals."""
    if options.serve:
        return
    usual, asked = ServiceOptions(), options.service
    of_service = {
        "--host": (asked.host, usual.host),
        "--port": (asked.port, usual.port),
        "--tls-certificate": (asked.certificate, usual.certificate),
        "--tls-key": (asked.key, usual.key),
        "--speech": (asked.speech, usual.speech),
    }
    for option, (value, default) in of_service.items():
        if value != default:
            raise ConfigError(f"{option} {value} needs a served run; add --serve")


def _device_choice(goals: Sequence[str], options: DryRunOptions) -> DeviceChoice:
    camera, base, intrinsics = options.camera, options.base, options.intrinsics
    if base is None:
        base = "sim" if camera in _LIVE else "none"
    if options.explore and base == "none":
        raise ConfigError("--explore drives; give --base sim or roomba")
    if intrinsics is not None and (camera in _LIVE or Path(camera).is_file()):
        raise ConfigError(f"--intrinsics are not for the camera {camera!r}, which has its own")
    if camera != "sim" and (options.labels is not None or options.start is not None):
        raise ConfigError(f"--labels and --start are for --camera sim, not for {camera!r}")
    if camera not in _LIVE and not Path(camera).exists():
        raise ConfigError(
            f"no camera {camera!r}; give sim, realsense, or a recording: a folder in TUM's layout,"
            " a .db3 or a .bag file"
        )
    require_mix(camera, base)
    rehearsal = None
    if "sim" in (camera, base) or options.faults is not None:
        from vizbot.rehearsal.choice import choose

        goal = goals[0] if goals and not options.explore else ""
        told = (options.labels, options.start, options.faults)
        rehearsal = choose(camera, base, options.world, goal, *told)
    return DeviceChoice(camera, base, _recording(intrinsics), rehearsal)


def _recording(intrinsics: str | None) -> tuple[Intrinsics, float] | None:
    if intrinsics is None:
        return None
    from drivers.tum_sequence import parse_intrinsics

    return parse_intrinsics(intrinsics)
