"""Checks every device and says what is wrong and how to fix it.

Nothing moves. The checks run beside each other, so that one that hangs delays no other.
"""

from __future__ import annotations

import shutil
import subprocess
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mapping.clip.patches import patch_boxes
from vizbot.config import Config
from vizbot.core.errors import ConfigError, DeviceError
from vizbot.core.interfaces import Clock
from vizbot.core.types import BaseState, Charging
from vizbot.rig import (
    FETCHED_EASILY,
    PHOTOS_FETCHED,
    is_rehearsal_encoder,
    open_encoder,
    require_encoder,
)

if TYPE_CHECKING:  # its module loads torch
    from mapping.clip.encoder import ClipEncoder

EmbedImages = Callable[[Sequence[NDArray[np.uint8]]], object]
"""Embeds pictures, as `ClipEncoder` does."""

TIMEOUT = 18.0
"""A check that takes longer has failed [s]."""
_ENCODER_TIMEOUT = 100.0
"""Time after which a check that loads and tries an encoder has failed [s]."""
_TIMED_WHOLE = 5.0
"""Longest time of a frame that is timed as a whole; a slower one is timed by one patch [s]."""
_FEWEST_FRAMES = 0.9
"""Least share of the frames and samples asked for that a stream must give."""
_MOST_SPOILT = 0.01
"""Greatest share of the base's bytes that may belong to no sound frame."""
_SLOW = "end other programs that keep this computer busy, or use another USB adapter"
_NOISY = "use a shorter cable, away from motors"
_MOST_HOLES = 0.5
"""Greatest share of the pixels that may be without depth."""
_MOST_FILTERING = 0.3
"""Greatest share of the time between two frames that depth filters may take."""
_SLOWEST_EMBEDDING = 1.0
"""Longest time to embed the patches of one frame [s]: the robot sees what it finds that late."""
_FASTER = (
    'name a smaller encoder with --clip, set device = "cuda" and half = true, or list fewer'
    " perception.clip_mapper.scales"
)
_AGAIN = {
    "base": "unplug its cable and plug it in again",
    "camera": "unplug it and plug it in again",
    "CLIP": "try again while this computer does nothing else, free memory, or name a smaller model"
    " with --clip",
}


class Grade(StrEnum):
    """How a check ended."""

    GOOD = "good"
    POOR = "poor"
    BAD = "bad"


@dataclass(frozen=True, slots=True)
class Finding:
    """The result of a check.

    Attributes:
        verdict: The grade; `BAD` keeps the robot from being launched.
        found: What was found, in words and figures.
        remedy: What to do about it; empty when all is well.
    """

    subject: str
    verdict: Grade
    found: str
    remedy: str = ""


Check = Callable[[], Iterator[Finding]]


@dataclass(slots=True)
class _Trial:
    """The progress of the encoder's check.

    Attributes:
        began: When it began to load the encoder [s]; None before.
        first_patch: When it began to embed the first patch [s]; None before.
    """

    began: float | None = None
    first_patch: float | None = None


def examine(config: Config, clock: Clock, folder: Path, rehearsal: bool = False) -> list[Finding]:
    """Run all checks at once.

    `folder` holds the folders of runs; `rehearsal`: the rehearsal encoder was asked for by its
    name.
    """
    trial = _Trial()
    checks: dict[str, Check] = {
        "base": lambda: _base(config, clock),
        "camera": lambda: _camera(config, clock),
        "CLIP": lambda: _encoder(config, clock, trial, rehearsal),
        "clock": _time,
        "disk": lambda: _disk(folder),
        "microphone": _microphone,
    }
    under_way = {
        subject: clock.start(lambda check=check: list(check()), 0.0)  # type: ignore[misc]
        for subject, check in checks.items()
    }
    end, findings = clock.now() + TIMEOUT, list[Finding]()
    for subject, pending in under_way.items():
        of_encoder = subject == "CLIP"
        while not pending.ready() and clock.now() < end:
            clock.sleep(0.02)
        while of_encoder and not pending.ready() and _under_way(trial, clock):
            clock.sleep(0.02)
        if not pending.ready():
            hangs = f"no answer within {TIMEOUT:.0f} s"
            slow = _too_slow(config, trial, clock) if of_encoder else None
            findings.append(slow or _failed(subject, hangs))
            continue
        try:
            findings += pending.result()
        except Exception as error:  # of any library or device: other findings still count
            text = " ".join(str(error).split()) or type(error).__name__
            findings.append(_failed(subject, text))
    return findings


def _failed(subject: str, found: str) -> Finding:
    return Finding(subject, Grade.BAD, found, _AGAIN.get(subject, "try again"))


def _base(config: Config, clock: Clock) -> Iterator[Finding]:
    from drivers.roomba.examination import examine_base
    from drivers.roomba.serial_port import open_serial
    from drivers.roomba.service import NO_FRAMES
    from drivers.roomba.stream import PERIOD

    port = config.serial_port
    try:
        opened = open_serial(port)
    except DeviceError as error:
        what, _, remedy = str(error).removeprefix("serial port ").partition("; ")
        yield Finding("serial port", Grade.BAD, what, remedy)
        return
    yield Finding("serial port", Grade.GOOD, f"{port} opened")
    try:
        base = examine_base(opened, clock)
    except OSError as error:
        yield Finding("base", Grade.BAD, f"{port}: {error}", "check its cable")
        return
    finally:
        opened.close()
    state = base.state
    if state is None and base.spoilt:
        yield Finding("base", Grade.BAD, NO_FRAMES, "then run the doctor again")
        return
    if state is None:
        asleep = "no sensor frames: not a Roomba, or asleep"
        yield Finding("base", Grade.BAD, asleep, "press Clean, then check the cable and the port")
        return
    firmware = base.firmware or "firmware unknown"
    shifted = ", reports its mode one too high" if base.mode_offset else ""
    mode = state.mode.name.title()
    yield Finding("base", Grade.GOOD, f"{firmware}, after Start it is in {mode} mode{shifted}")
    frames = f"{base.rate:.0f} frames/s, {100 * base.spoilt:.1f} % of the bytes spoilt"
    clean = base.spoilt < _MOST_SPOILT
    sound = base.rate > _FEWEST_FRAMES / PERIOD and clean
    yield _well_or_poor("base's stream", sound, frames, _SLOW if clean else _NOISY)
    yield from _battery(state)
    if any(state.wheel_drops) or any(state.cliffs):
        found = "a wheel hangs or there is an edge"
        yield Finding("wheels", Grade.POOR, found, "put it on open floor")


def _battery(state: BaseState) -> Iterator[Finding]:
    if state.charging is Charging.FAULT:
        remedy = "wipe the contacts, let the battery cool, then try another one"
        yield Finding("charger", Grade.POOR, "the base reports a charging fault", remedy)
    if state.battery is None:
        yield Finding("battery", Grade.POOR, "not known to the base", "charge it once")
        return
    power = f"{100 * state.battery:.0f} %, {state.voltage:.1f} V, {state.charging.value}"
    if state.battery < 0.2:
        verdict = Grade.BAD if state.battery < 0.1 else Grade.POOR
        remedy = "let it charge first" if state.on_charger else "put it on its dock"
        yield Finding("battery", verdict, power, remedy)
        return
    remedy = "take it off its charger to drive"
    yield _well_or_poor("battery", not state.on_charger, power, remedy)


def _camera(config: Config, clock: Clock) -> Iterator[Finding]:
    from drivers.realsense.camera import RealSense
    from drivers.realsense.examination import cameras, examine_camera

    settings = config.realsense
    try:
        with ExitStack() as opened:
            eye = opened.enter_context(RealSense(settings, clock))
            seen = examine_camera(eye, clock)
            filter_cost = eye.filter_cost
    except DeviceError as error:
        what, _, remedy = str(error).partition("; ")
        yield Finding("camera", Grade.BAD, what, remedy)
        return
    for camera in cameras():
        named = f"{camera.name}, serial {camera.serial}, firmware {camera.firmware}"
        found, fast = f"{named}, USB {camera.usb}", camera.usb.startswith("3")
        yield _well_or_poor("camera", fast, found, "use a USB 3 port and a USB 3 cable")
    yield _rate("camera's frames", seen.rate, settings.fps, "close other programs, use USB 3")
    holes = f"{100 * seen.holes:.0f} % of the pixels without depth"
    remedy = "clean the lenses, look at something lit 0.3 to 4 m away"
    yield _well_or_poor("depth", seen.holes < _MOST_HOLES, holes, remedy)
    if filter_cost > 0.0:
        share = filter_cost * settings.fps
        cost = f"{1000 * filter_cost:.1f} ms a frame, {100 * share:.0f} % of its time"
        remedy = "do without [realsense.filters.spatial]"
        yield _well_or_poor("depth filters", share < _MOST_FILTERING, cost, remedy)
    if not settings.imu or seen.gyro_rate == 0.0:
        without = "none: wheels alone say how far the robot turns"
        yield Finding("gyroscope", Grade.POOR, without, "use a D435i, set imu = true")
        return
    yield _rate("gyroscope", seen.gyro_rate, settings.gyro_rate, "use a USB 3 port")
    # It depends on its IMU whether a D435i has 63 and 250 (BMI055) or 100 and 200 (BMI085).
    remedy = "use a USB 3 port, or set accel_rate to what it has: 63, 100, 200 or 250"
    yield _rate("accelerometer", seen.accel_rate, settings.accel_rate, remedy)
    rest = f"{seen.gyro_bias:.4f} rad/s at rest, gravity {seen.gravity:.2f} m/s^2"
    still = seen.gyro_bias < config.perception.slam.dead_reckoning.greatest_bias
    still = still and abs(seen.gravity - 9.81) < 0.5
    remedy = "keep the robot still, then calibrate the camera's IMU"
    yield _well_or_poor("IMU", still, rest, remedy)


def _rate(subject: str, rate: float, wanted: float, remedy: str) -> Finding:
    found = f"{rate:.0f}/s of {wanted:.0f}/s"
    return _well_or_poor(subject, rate >= _FEWEST_FRAMES * wanted, found, remedy)


def _encoder(config: Config, clock: Clock, trial: _Trial, rehearsal: bool) -> Iterator[Finding]:
    trial.began = began = clock.now()
    from mapping.clip.encoder import gpu_name  # loads torch, which takes a while on slow disks

    try:
        require_encoder(config.clip, config.device)
        encoder = open_encoder(config.clip, config.device, config.half)
    except ConfigError as error:
        said = str(error)
        what, _, remedy = said.partition("; " if "; " in said else ": ")
        yield Finding("CLIP", Grade.BAD, what, remedy)
        return
    if is_rehearsal_encoder(config.clip):
        yield _of_rehearsals(config, clock, encoder, trial, rehearsal)
    else:
        loaded = clock.now() - began
        took = _frame_time(encoder.embed_images, config, clock, trial)
        notice = f" ({encoder.notice})" if encoder.notice else ""
        found = f"{encoder.model_id} on {config.device}, {took}, loaded in {loaded:.1f} s{notice}"
        yield _well_or_poor("CLIP", took.seconds < _SLOWEST_EMBEDDING, found, _FASTER)
    yield Finding("GPU", Grade.GOOD, gpu_name() or "none: CLIP runs on the processor")


def _of_rehearsals(
    config: Config, clock: Clock, encoder: ClipEncoder, trial: _Trial, rehearsal: bool
) -> Finding:
    """The finding for the rehearsal encoder with a real camera; its remedy is timed here."""
    from mapping.clip.encoder import untrained_images

    took = _frame_time(untrained_images(config.device, config.half), config, clock, trial)
    found = f"{encoder.model_id} is the rehearsal encoder, which knows simulated homes alone"
    remedy = f"{FETCHED_EASILY} ({took} on {config.device} here), or {PHOTOS_FETCHED}"
    if rehearsal:
        return Finding("CLIP", Grade.POOR, found, remedy)
    remedy = f"{remedy}, or rehearse with --clip embedded"
    return Finding("CLIP", Grade.BAD, found, remedy)


def _under_way(trial: _Trial, clock: Clock) -> bool:
    return trial.began is not None and clock.now() < trial.began + _ENCODER_TIMEOUT


def _too_slow(config: Config, trial: _Trial, clock: Clock) -> Finding | None:
    """The finding for an encoder that has not embedded a patch or two yet; None without one."""
    if trial.began is None:
        return None
    if trial.first_patch is None:
        loading = f"{config.clip}: not loaded after {clock.now() - trial.began:.0f} s"
        return Finding("CLIP", Grade.POOR, loading, _FASTER)
    patches = len(_black_patches(config))
    least = (clock.now() - trial.first_patch) / 2 * patches
    return Finding("CLIP", Grade.POOR, f"{config.clip}: over {least:.0f} s a frame", _FASTER)


@dataclass(frozen=True, slots=True)
class _FrameTime:
    """How long an encoder takes for a frame.

    Attributes:
        seconds: Time for all patches [s].
        patches: Their number.
        whole: Whether all were embedded; else the time is a single patch's, times their number.
    """

    seconds: float
    patches: int
    whole: bool

    def __str__(self) -> str:
        about = "" if self.whole else "about "
        return f"{about}{_short(self.seconds)} a frame ({self.patches} patches)"


def _frame_time(embed: EmbedImages, config: Config, clock: Clock, trial: _Trial) -> _FrameTime:
    """Time a frame; a slow encoder by single patches."""
    patches = _black_patches(config)
    trial.first_patch = clock.now()
    took = len(patches) * _embedding_time(embed, patches[:1], clock)
    if took > _TIMED_WHOLE:  # the first time takes longer
        took = len(patches) * _embedding_time(embed, patches[:1], clock)
        if took > _TIMED_WHOLE:
            return _FrameTime(took, len(patches), False)
    took = _embedding_time(embed, patches, clock)
    if took < _SLOWEST_EMBEDDING:  # on a GPU the first batch of its size takes longer, too
        took = _embedding_time(embed, patches, clock)
    return _FrameTime(took, len(patches), True)


def _embedding_time(
    embed: EmbedImages, patches: Sequence[NDArray[np.uint8]], clock: Clock
) -> float:
    began = clock.now()
    embed(patches)
    return clock.now() - began


def _black_patches(config: Config) -> list[NDArray[np.uint8]]:
    """As many patches as the CLIP map cuts from one frame, and of their sizes."""
    settings = config.realsense
    boxes = patch_boxes(settings.width, settings.height, config.perception.clip_mapper)
    return [np.zeros((v1 - v0, u1 - u0, 3), np.uint8) for u0, v0, u1, v1 in boxes]


def _short(seconds: float) -> str:
    return f"{1000 * seconds:.0f} ms" if seconds < 1.0 else f"{seconds:.1f} s"


def _time() -> Iterator[Finding]:
    now = time.strftime("%Y-%m-%d %H:%M %Z")
    asked = shutil.which("timedatectl")
    synchronised = ""
    if asked is not None:
        command = [asked, "show", "--property=NTPSynchronized", "--value"]
        with suppress(subprocess.TimeoutExpired):  # the clock is then taken to be right
            asking = subprocess.run(command, capture_output=True, text=True, timeout=5)
            synchronised = asking.stdout.strip()
    found = f"{now}, not synchronised" if synchronised == "no" else now
    yield _well_or_poor("clock", synchronised != "no", found, "run `timedatectl set-ntp true`")


def _disk(folder: Path) -> Iterator[Finding]:
    whole = folder.absolute()
    nearest = next(each for each in (whole, *whole.parents) if each.exists())
    free = shutil.disk_usage(nearest).free / 1e9
    found = f"{free:.1f} GB free for {folder}"
    if free < 1.0:
        yield Finding("disk", Grade.BAD, found, "delete old runs")
    else:
        yield _well_or_poor("disk", free >= 5.0, found, "delete old runs")


def _microphone() -> Iterator[Finding]:
    try:
        streams = Path("/proc/asound/pcm").read_text(encoding="utf-8").splitlines()
    except OSError:
        streams = []
    heard = [stream.split(":")[1].strip() for stream in streams if "capture" in stream]
    found = ", ".join(heard) or "none"
    yield _well_or_poor("microphone", bool(heard), found, "plug one in to give goals by voice")


def _well_or_poor(subject: str, well: bool, found: str, remedy: str) -> Finding:
    verdict = Grade.GOOD if well else Grade.POOR
    return Finding(subject, verdict, found, "" if well else remedy)
