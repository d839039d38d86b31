"""Opens the devices of a run, real or simulated in any mix; no other module names device classes.

| camera      | base   | clock     |                                                             |
|-------------|--------|-----------|-------------------------------------------------------------|
| `sim`       | `sim`  | simulated | the world advances both in lockstep                         |
| `sim`       | `none` | simulated | the robot stands still                                      |
| `sim`       | roomba | wall      | the world's robot follows the encoders of the real base     |
| `realsense` | `sim`  | wall      | the base drives on an empty floor that nothing shows        |
| `realsense` | roomba | wall      | the robot                                                   |
| recording   | `none` | simulated | as fast as the frames can be processed                      |
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Self

from mapping.clip.checkpoint.checkpoint import SHORT_NAMES, find_checkpoint
from mapping.clip.own_encoder import is_class_name, open_class, require_module
from sim_stubs.faults.catalogue import FaultSchedule, PlannedFault
from vizbot.config import Config
from vizbot.core.clock import WallClock
from vizbot.core.devices import Devices
from vizbot.core.errors import ConfigError, DeviceError
from vizbot.core.geometry import yaw_of
from vizbot.core.interfaces import Base, Camera
from vizbot.core.program.interrupts import holding_interrupts
from vizbot.core.types import Intrinsics
from vizbot.mixed_devices import FollowedBase, WithoutImu

if TYPE_CHECKING:  # the encoder protocol's module loads torch
    from mapping.clip.embedded.model_files import EmbeddedFiles
    from mapping.clip.encoder import ClipEncoder, TextEncoder
    from mapping.map_bundle import MapBundle
    from sim_stubs.clock import SimulatedClock
    from sim_stubs.faults.faulty_base import FaultyRoomba
    from sim_stubs.world.world import World

log = logging.getLogger(__name__)

FETCHED_EASILY = f"`hf download {SHORT_NAMES['ViT-B/32']}`, then --clip ViT-B/32"
"""How a person gets the smallest encoder of real pictures."""


class Rig:
    """Open devices, and the world they stand in when it is simulated.

    Attributes:
        devices: The devices for the robot.
        world: The simulated world, for the scorer and its pictures alone; None on hardware and with
            recordings.
        schedule: When which fault happens, for the encoder and the scorer; None without faults.
        faulty_base: The simulated base with faults, for the scorer alone; None without faults.
    """

    def __init__(
        self,
        config: Config,
        camera: str,
        base: str,
        world: str | World,
        recording: tuple[Intrinsics, float] | None = None,
        first_goal: str = "",
        faults: Sequence[PlannedFault] = (),
    ) -> None:
        """Open everything, or nothing.

        Args:
            config: Settings of all devices.
            camera: `sim`, `realsense`, or the path of a recording.
            base: `sim`, `roomba` or `none`.
            world: The world of what is simulated. One that is open already is not closed here.
            recording: Intrinsics and metres per unit of depth of a recorded folder without
                `camera.json`.
            first_goal: A simulated world puts the robot down far from it. The robot does not learn
                it.
            faults: Faults that happen. The robot does not learn them.

        Raises:
            ConfigError: there is no such mix, world or recording, or a fault has no device to
                happen to.
            DeviceError: a device is missing or does not answer.
        """
        require_mix(camera, base, faults)
        self.world: World | None = None
        self.schedule: FaultSchedule | None = None
        self.faulty_base: FaultyRoomba | None = None
        self._faults = faults
        with ExitStack() as opened:
            self.devices = self._open(config, camera, base, world, recording, first_goal, opened)
            if faults:
                self._disturb_camera()
            self._opened = opened.pop_all()

    def close(self) -> None:
        """Close every device, the base first; an interrupt comes after it."""
        with holding_interrupts():
            self._opened.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exc: object) -> None:
        self.close()

    def _open(
        self,
        config: Config,
        camera: str,
        base: str,
        world: str | World,
        recording: tuple[Intrinsics, float] | None,
        first_goal: str,
        opened: ExitStack,
    ) -> Devices:
        from sim_stubs.clock import SimulatedClock

        mount = config.mount.T_base_cam
        if camera not in ("sim", "realsense"):
            player = opened.enter_context(_open_recording(config, Path(camera), recording))
            return Devices(SimulatedClock(), player, None, None, True)
        if camera == "realsense":
            from drivers.realsense.camera import RealSense

            wall, missing = WallClock(), []
            eye: Camera | None = None
            wheels: Base | None = None
            try:
                eye = opened.enter_context(RealSense(config.realsense, wall))
            except DeviceError as error:
                missing.append(str(error))
            try:
                wheels = None if base == "none" else open_base(config, base, wall, opened)
            except DeviceError as error:
                missing.append(str(error))
            if eye is None or missing:
                raise DeviceError("; ".join(missing))  # all that is missing, not the first alone
            seen = WithoutImu(eye) if base == "sim" else eye
            return Devices(wall, seen, wheels, mount if wheels else None, False)

        from sim_stubs.realsense.camera import SimulatedRealSense
        from sim_stubs.world.world_name import open_world

        if isinstance(world, str):
            world = opened.enter_context(open_world(world, config.world, mount, first_goal))
        self.world = world
        clock = SimulatedClock() if base != "roomba" else WallClock()
        view = SimulatedRealSense(world, clock, config.sim_camera)
        sim_camera = opened.enter_context(view)
        if base == "none":
            return Devices(clock, sim_camera, None, mount, False)
        if isinstance(clock, SimulatedClock):
            lockstep = self._open_lockstep_base(config, world, clock, opened)
            return Devices(clock, sim_camera, lockstep, mount, False)
        base_in_world = FollowedBase(open_base(config, base, clock, opened), world)
        return Devices(clock, WithoutImu(sim_camera), base_in_world, mount, False)

    def _open_lockstep_base(
        self, config: Config, world: World, clock: SimulatedClock, opened: ExitStack
    ) -> Base:
        from drivers.roomba.base import Roomba
        from drivers.roomba.serial_port import open_serial
        from drivers.roomba.service import LockstepLink
        from sim_stubs.roomba.base import SimulatedRoomba

        stub: SimulatedRoomba | FaultyRoomba
        if self._faults:
            from sim_stubs.faults.faulty_base import FaultyRoomba

            self.schedule = schedule = FaultSchedule(self._faults, clock.now, world.seed)
            clock.slow_down(schedule.slowness)
            stub = FaultyRoomba(
                world,
                schedule,
                world.seed,
                lambda T: world.place(float(T[0, 3]), float(T[1, 3]), yaw_of(T)),
            )
            self.faulty_base = stub
        else:
            stub = SimulatedRoomba(world)
        opened.enter_context(stub)
        clock.attach(stub)
        link = LockstepLink(
            lambda: stub.lockstep_port(open_serial(stub.path)), clock, config.roomba
        )
        with holding_interrupts():  # one amid a message would be a loss of bytes
            return opened.enter_context(Roomba(link, clock, config.roomba))

    def _disturb_camera(self) -> None:
        """Wrap the camera so that faults happen to it."""
        from sim_stubs.faults.faulty_camera import FaultyCamera

        devices = self.devices
        seed = 0 if self.world is None else self.world.seed
        began = devices.clock.now()

        def now() -> float:  # a recording is read without waiting: its stamps are the time
            return camera.elapsed if devices.recorded else devices.clock.now() - began

        schedule = self.schedule or FaultSchedule(self._faults, now, seed)
        camera = FaultyCamera(
            devices.camera, devices.clock, schedule, seed, recorded=devices.recorded
        )
        self.schedule, self.devices = schedule, replace(devices, camera=camera)


def require_devices(config: Config, camera: str, base: str) -> None:
    """Refuse devices that are not plugged in, before anything heavy is loaded; none is opened.

    Args:
        config: Says which camera and which port.
        camera: `sim`, `realsense`, or the path of a recording.
        base: `sim`, `roomba` or `none`.

    Raises:
        DeviceError: camera or base is missing; the line names both where both are.
    """
    missing = []
    if camera == "realsense":
        try:
            from drivers.realsense.discovery import find_camera
            from drivers.realsense.sdk import rs

            find_camera(rs.context(), config.realsense.serial)
        except DeviceError as error:
            missing.append(str(error))
    if base == "roomba":
        from drivers.roomba.serial_port import require_port

        try:
            require_port(config.serial_port)
        except DeviceError as error:
            missing.append(str(error))
    if missing:
        raise DeviceError("; ".join(missing))


def is_rehearsal_encoder(name: str) -> bool:
    """Whether `--clip` names the encoder that knows nothing but simulated homes."""
    return name == "embedded" or name.startswith("embedded-")


def require_encoder(name: str, device: str = "cpu") -> None:
    """Refuse an encoder that is not on this machine, before anything of its size is loaded.

    Args:
        name: As `--clip` takes it.
        device: As the setting of that name; one that is not there is refused for every encoder.

    Raises:
        ConfigError: there are no weights for it here, or no such device.
    """
    if is_rehearsal_encoder(name):
        _embedded_files(name)
    elif is_class_name(name):
        require_module(name)
    else:
        find_checkpoint(name)
    _require_compute_device(device)


def _require_compute_device(device: str) -> None:
    if device not in ("cpu", "auto"):  # PyTorch, which knows, takes seconds to load
        from mapping.clip.encoder import compute_device

        compute_device(device)


def open_encoder(name: str, device: str, half: bool = False) -> ClipEncoder:
    """The encoder that `--clip` names: `embedded`, a short or hub name, a folder or a class.

    `device` and `half` (16-bit floating point) are for the models that run on PyTorch; a device
    that is not there is refused for every one. A class is code that runs: for the name that a map
    has, which anybody may have written, there is `open_map_encoder`.

    Raises:
        ConfigError: there are no weights for it here, the class keeps no contract, or there is no
            such device.
    """
    _require_compute_device(device)
    if is_rehearsal_encoder(name):
        from mapping.clip.embedded.encoder import open_embedded_clip

        return open_embedded_clip(_embedded_files(name))
    if is_class_name(name):
        return open_class(name)
    from mapping.clip.encoder import load_clip

    return load_clip(name, device, half)


def open_text_encoder(name: str, device: str, half: bool = False) -> TextEncoder:
    """The same encoder, to ask a saved map with; the embedded one takes no PyTorch then.

    Raises:
        ConfigError: there are no weights for it here, or no such device.
    """
    if not is_rehearsal_encoder(name):
        return open_encoder(name, device, half)
    from mapping.clip.embedded.text_encoder import EmbeddedTexts

    _require_compute_device(device)
    return EmbeddedTexts(_embedded_files(name))


def open_map_encoder(
    bundle: MapBundle, device: str, half: bool = False, clip: str | None = None
) -> TextEncoder:
    """The encoder to ask a saved map with: that of the map, unless a person names one.

    A map may come from anywhere, so it opens models alone: a class is code that runs, and is opened
    where a person names it.

    Args:
        bundle: The map.
        device: Where a model on PyTorch runs.
        half: Whether that computes in 16-bit floating point.
        clip: What a person names, as `--clip` takes it; None for the encoder that the map names.

    Raises:
        ConfigError: there are no weights for it here, or the class keeps no contract.
        MapError: the map names a class and no person does, or another encoder made the map.
    """
    from mapping import map_bundle

    if clip is None:
        map_bundle.require_no_class(bundle)
        clip = bundle.model_id
    require_encoder(clip, device)
    whole = len(bundle.pictures) == 0  # a map of before: the encoder embeds the bank of pictures
    encoder = open_encoder(clip, device, half) if whole else open_text_encoder(clip, device, half)
    map_bundle.require_encoder(bundle, encoder)
    return encoder


def _embedded_files(name: str) -> EmbeddedFiles:
    from mapping.clip.embedded.model_files import read_files

    files = read_files()
    if name not in ("embedded", files.model_id):
        raise ConfigError(f"this vizbot has {files.model_id}, not {name!r}: build the map again")
    return files


def _open_recording(
    config: Config, path: Path, recording: tuple[Intrinsics, float] | None
) -> Camera:
    if path.suffix in (".db3", ".bag"):
        from drivers.realsense.playback import RealSenseRecording

        return RealSenseRecording(config.realsense, path)
    from drivers.tum_sequence import RecordedSequence

    return RecordedSequence(path, *(recording or (None, None)))


def require_mix(camera: str, base: str, faults: Sequence[PlannedFault] = ()) -> None:
    """Refuse devices that do not go together, and faults that none of them can have.

    Args:
        camera: `sim`, `realsense`, or the path of a recording.
        base: `sim`, `roomba` or `none`.
        faults: Faults that are to happen.

    Raises:
        ConfigError: there is no such mix, or a fault has no device to happen to.
    """
    if base not in ("sim", "roomba", "none"):
        raise ConfigError(f"unknown base {base!r}; use sim, roomba or none")
    recorded = camera not in ("sim", "realsense")
    if recorded and base != "none":
        raise ConfigError(f"the recording {camera} cannot be driven; use --base none")
    if (camera, base) == ("sim", "sim"):
        return
    for planned in faults:
        fault = planned.fault
        if fault.device == "base" or fault.name == "encoder-slow":
            raise ConfigError(
                f"--faults {fault.name} happens to a simulated base and camera, not to --base"
                f" {base}; use --camera sim --base sim"
            )


def open_base(config: Config, base: str, clock: WallClock, opened: ExitStack) -> Base:
    """A base without a camera, on the wall clock.

    Args:
        config: Settings, with the serial port.
        base: `roomba`, or `sim` for one on an endless empty floor.
        clock: The clock of the run.
        opened: Closes the base.

    Raises:
        DeviceError: the base is missing or does not answer.
    """
    from drivers.roomba.base import Roomba
    from drivers.roomba.reflex_process.process_link import ProcessLink
    from drivers.roomba.serial_port import SerialAddress

    port = config.serial_port
    if base == "sim":
        from sim_stubs.roomba.base import SimulatedRoomba
        from sim_stubs.roomba.wall_clock import on_wall_clock
        from sim_stubs.world.free_floor import FreeFloor

        port = opened.enter_context(on_wall_clock(SimulatedRoomba(FreeFloor()))).path
    link = ProcessLink(SerialAddress(port).open, config.roomba)
    return opened.enter_context(Roomba(link, clock, config.roomba))
