"""Opens the devices of a rehearsal, real and simulated in any mix.

| camera      | base   | clock     |                                                             |
|-------------|--------|-----------|-------------------------------------------------------------|
| `sim`       | `sim`  | simulated | the world advances both in lockstep                         |
| `sim`       | `none` | simulated | the robot stands still                                      |
| `sim`       | roomba | wall      | the world's robot follows the encoders of the real base     |
| `realsense` | `sim`  | wall      | the base drives on an empty floor that nothing shows        |

A mix without anything simulated is opened by `vizbot.rig`, and faults may happen to its camera.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from drivers.roomba.base import Roomba
from drivers.roomba.serial_port import open_serial
from drivers.roomba.service import LockstepLink
from sim_stubs.faults.catalogue import FaultSchedule, PlannedFault
from sim_stubs.faults.faulty_base import FaultyRoomba
from sim_stubs.faults.faulty_camera import FaultyCamera
from sim_stubs.faults.faulty_program import FaultyEncoder, FaultyObserver, Killer
from sim_stubs.roomba.base import SimulatedRoomba, on_wall_clock
from sim_stubs.world.body import FreeFloor
from vizbot.config import Config
from vizbot.core.clock import WallClock
from vizbot.core.closeable import Closeable
from vizbot.core.geometry import yaw_of
from vizbot.core.interfaces import Base, Clock, Devices
from vizbot.core.observer import Observer
from vizbot.core.program.interrupts import holding_interrupts
from vizbot.core.simulated_clock import SimulatedClock
from vizbot.core.types import Intrinsics
from vizbot.rehearsal.choice import RehearsalChoice, require_faults
from vizbot.rehearsal.config import RehearsalConfig
from vizbot.rehearsal.mixed_devices import FollowedBase, WithoutImu
from vizbot.rehearsal.plan_process import PlanProcess
from vizbot.rig import open_base, open_devices, require_mix

if TYPE_CHECKING:  # their modules load MuJoCo, PyTorch and the simulated homes
    from mapping.clip.encoder import ClipEncoder
    from sim_stubs.scoring.success import GoalScorer
    from sim_stubs.world.world import World


class Rig(Closeable):
    """Open devices, and the world they stand in when it is simulated.

    Attributes:
        devices: The devices for the robot.
        world: The simulated world, for the scorer and its pictures alone; None on hardware and with
            recordings.
        schedule: When which fault happens, for the encoder and the scorer; None without faults.
        faulty_base: The simulated base with faults, for the scorer alone; None without faults.
        scorer: Judges goals by the simulated world, once `judges` has made it.
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
        require_mix(camera, base)
        require_faults(camera, base, faults)
        self.world: World | None = None
        self.schedule: FaultSchedule | None = None
        self.faulty_base: FaultyRoomba | None = None
        self.scorer: GoalScorer | None = None
        self._faults = faults
        with ExitStack() as opened:
            if camera == "sim":
                self.devices = self._open_in_world(config, base, world, first_goal, opened)
            elif base == "sim":
                config = with_simulated_base(config, opened)
                devices = open_devices(config, camera, "roomba", recording, opened)
                self.devices = replace(devices, camera=WithoutImu(devices.camera))
            else:
                self.devices = open_devices(config, camera, base, recording, opened)
            if faults:
                self._disturb_camera()
            self._opened = opened.pop_all()

    def disturbed(self, encoder: ClipEncoder) -> ClipEncoder:
        """The encoder with its faults; itself without any."""
        return encoder if self.schedule is None else FaultyEncoder(encoder, self.schedule)

    def on_faulty_disk(self, observer: Observer) -> list[Observer]:
        """An observer that writes to the disk with its faults, and what may kill the program."""
        if self.schedule is None:
            return [observer]
        return [FaultyObserver(observer, self.schedule), Killer(self.schedule)]

    def judges(self) -> list[Observer]:
        """The scorer of goals by the simulated world; none where no base drives in one."""
        if self.world is None or self.devices.base is None:
            return []
        from sim_stubs.scoring.success import GoalScorer

        self.scorer = GoalScorer(self.world)
        return [self.scorer]

    def close(self) -> None:
        """Close every device, the base first; an interrupt comes after it."""
        with holding_interrupts():
            self._opened.close()

    def _open_in_world(
        self, config: Config, base: str, world: str | World, first_goal: str, opened: ExitStack
    ) -> Devices:
        from sim_stubs.realsense.camera import SimulatedRealSense
        from sim_stubs.world.world_name import open_world

        mount, rehearsal = config.mount.T_base_cam, RehearsalConfig.read(config)
        if isinstance(world, str):
            world = opened.enter_context(open_world(world, rehearsal.world, mount, first_goal))
        self.world = world
        wall, lockstep = WallClock(), SimulatedClock()
        clock: Clock = wall if base == "roomba" else lockstep
        view = SimulatedRealSense(world, clock, rehearsal.sim_camera)
        sim_camera = opened.enter_context(view)
        if base == "none":
            return Devices(clock, sim_camera, None, mount, False)
        if base == "sim":
            wheels = self._open_lockstep_base(config, world, lockstep, opened)
            return Devices(clock, sim_camera, wheels, mount, False)
        base_in_world = FollowedBase(open_base(config, wall, opened), world)
        return Devices(clock, WithoutImu(sim_camera), base_in_world, mount, False)

    def _open_lockstep_base(
        self, config: Config, world: World, clock: SimulatedClock, opened: ExitStack
    ) -> Base:
        stub: SimulatedRoomba | FaultyRoomba
        if self._faults:
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


def with_simulated_base(config: Config, opened: ExitStack) -> Config:
    """The same settings with the serial port of a base that is simulated on an endless empty floor.

    Args:
        config: Of the robot.
        opened: Ends the simulation.
    """
    stub = opened.enter_context(on_wall_clock(SimulatedRoomba(FreeFloor())))
    return config.model_copy(update={"serial_port": stub.path})


def open_world_and_encoder(
    config: Config,
    choice: RehearsalChoice,
    planned: PlanProcess | None,
    open_encoder: Callable[[], ClipEncoder],
    opened: ExitStack,
) -> tuple[World | str, ClipEncoder]:
    """The world of a rehearsal, opened first because it refuses more; and the encoder.

    The encoder of a planned world opens beside it: waits for the plan and for MuJoCo leave it the
    interpreter.

    Args:
        config: Of the robot.
        choice: Of the world.
        planned: Its plan, under way; None where it is not.
        open_encoder: Opens the encoder.
        opened: Closes the world.
    """
    mount, body = config.mount.T_base_cam, RehearsalConfig.read(config).world
    if planned is None:
        if not choice.world:
            return "", open_encoder()
        from sim_stubs.world.world_name import open_world

        named = (choice.first_goal, choice.labels, choice.start)
        world = opened.enter_context(open_world(choice.world, body, mount, *named))
        return world, open_encoder()
    with ThreadPoolExecutor(1) as beside:
        encoder = beside.submit(open_encoder)
        import sim_stubs.world.renderer  # noqa: F401
        from sim_stubs.world.world import World

        plan = planned.plan()
        shape = partial(planned.shape, plan)
        world = opened.enter_context(World.of_plan(plan, body, mount, shape))
        return world, encoder.result()
