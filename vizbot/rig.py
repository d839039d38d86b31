"""Opens the devices of a run; no other module names classes of real ones.

| camera      | base   | clock     |                                                             |
|-------------|--------|-----------|-------------------------------------------------------------|
| `realsense` | roomba | wall      | the robot                                                   |
| recording   | `none` | simulated | as fast as the frames can be processed                      |

`vizbot.rehearsal` opens simulated devices.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from mapping.clip.checkpoint.checkpoint import SHORT_NAMES, find_checkpoint
from mapping.clip.own_encoder import is_class_name, open_class, require_module
from mapping.clip.photos.weights import FETCH, require_weights
from vizbot.config import Config
from vizbot.core.clock import WallClock
from vizbot.core.errors import ConfigError, DeviceError
from vizbot.core.interfaces import Base, Camera, Devices
from vizbot.core.program.interrupts import holding_interrupts
from vizbot.core.simulated_clock import SimulatedClock
from vizbot.core.types import Intrinsics

if TYPE_CHECKING:  # the encoder protocol's module loads torch
    from mapping.clip.embedded.model_files import EmbeddedFiles
    from mapping.clip.encoder import ClipEncoder, TextEncoder
    from mapping.map_bundle import MapBundle

FETCHED_EASILY = f"`hf download {SHORT_NAMES['ViT-B/32']}`, then --clip ViT-B/32"
"""How a person gets the smallest encoder of real pictures that knows open words."""
PHOTOS_FETCHED = f"`{FETCH}`, then --clip photos (24 MB: a thousand names, no sentences)"
"""How a person gets the smallest of all."""


@contextmanager
def opened_devices(
    config: Config, camera: str, base: str, recording: tuple[Intrinsics, float] | None = None
) -> Iterator[Devices]:
    """Open devices as `open_devices` does, and close them, the base first.

    An interrupt comes after they are closed.
    """
    opened = ExitStack()
    try:
        yield open_devices(config, camera, base, recording, opened)
    finally:
        with holding_interrupts():
            opened.close()


def open_devices(
    config: Config,
    camera: str,
    base: str,
    recording: tuple[Intrinsics, float] | None,
    opened: ExitStack,
) -> Devices:
    """Open the devices of the robot, or a recording of its camera.

    Args:
        config: Settings of all devices.
        camera: `realsense`, or the path of a recording.
        base: `roomba` or `none`.
        recording: Intrinsics and metres per unit of depth of a recorded folder without
            `camera.json`.
        opened: Closes the devices.

    Raises:
        ConfigError: there is no such recording.
        DeviceError: a device is missing or does not answer; the line names all that are.
    """
    if camera != "realsense":
        player = opened.enter_context(_open_recording(config, Path(camera), recording))
        return Devices(SimulatedClock(), player, None, None, True)
    from drivers.realsense.camera import RealSense

    wall, missing = WallClock(), []
    eye: Camera | None = None
    wheels: Base | None = None
    try:
        eye = opened.enter_context(RealSense(config.realsense, wall))
    except DeviceError as error:
        missing.append(str(error))
    try:
        wheels = None if base == "none" else open_base(config, wall, opened)
    except DeviceError as error:
        missing.append(str(error))
    if eye is None or missing:
        raise DeviceError("; ".join(missing))  # name all that is missing, not the first alone
    return Devices(wall, eye, wheels, config.mount.T_base_cam if wheels else None, False)


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


def is_photo_encoder(name: str) -> bool:
    """Whether `--clip` names the encoder of real pictures that knows a thousand names."""
    return name == "photos" or name.startswith("photos-")


def require_encoder(name: str, device: str = "cpu") -> None:
    """Refuse an encoder that is not on this machine, before anything of its size is loaded.

    A `device` that is not there is refused for every encoder.

    Raises:
        ConfigError: there are no weights for it here, or no such device.
    """
    if is_rehearsal_encoder(name):
        _embedded_files(name)
    elif is_photo_encoder(name):
        _require_photos(name)
        require_weights()
    elif is_class_name(name):
        require_module(name)
    else:
        find_checkpoint(name)
    _require_compute_device(device)


def require_names(name: str, goals: Sequence[str]) -> None:
    """Refuse goals that an encoder of names alone has none for, before anything is loaded.

    Raises:
        ConfigError: a goal has no name.
    """
    if is_photo_encoder(name):
        from mapping.clip.photos.names import read_name

        for goal in goals:
            read_name(goal)


def _require_compute_device(device: str) -> None:
    if device not in ("cpu", "auto"):  # PyTorch, which knows, takes seconds to load
        from mapping.clip.compute_device import compute_device

        compute_device(device)


def open_encoder(name: str, device: str, half: bool = False) -> ClipEncoder:
    """The encoder that `--clip` names: `embedded`, `photos`, a CLIP's name, a folder or a class.

    `device` and `half` (16-bit floating point) are for CLIP, and `device` for `photos`; a device
    that is not there is refused for every one. A class is code that runs: for the name that a map
    has, which anybody may have written, there is `open_map_encoder`.

    Raises:
        ConfigError: there are no weights for it here, the class breaks its contract, or there is no
            such device.
    """
    _require_compute_device(device)
    if is_rehearsal_encoder(name):
        from mapping.clip.embedded.encoder import open_embedded_clip

        return open_embedded_clip(_embedded_files(name))
    if is_photo_encoder(name):
        from mapping.clip.photos.encoder import open_photo_classes

        _require_photos(name)
        return open_photo_classes(device)
    if is_class_name(name):
        return open_class(name)
    from mapping.clip.encoder import load_clip

    return load_clip(name, device, half)


def open_text_encoder(name: str, device: str, half: bool = False) -> TextEncoder:
    """The same encoder, to ask a saved map with; `embedded` and `photos` take no PyTorch then.

    Raises:
        ConfigError: there are no weights for it here, or no such device.
    """
    if is_photo_encoder(name):
        from mapping.clip.photos.text_encoder import PhotoTexts

        _require_photos(name)
        _require_compute_device(device)
        return PhotoTexts()
    if not is_rehearsal_encoder(name):
        return open_encoder(name, device, half)
    from mapping.clip.embedded.text_encoder import EmbeddedTexts

    _require_compute_device(device)
    return EmbeddedTexts(_embedded_files(name))


def open_map_encoder(bundle: MapBundle, config: Config, clip: str | None = None) -> TextEncoder:
    """The encoder to ask a saved map with: that of the map, unless a person names one.

    A map may come from anywhere, so it opens models alone: a class is code that runs, and is opened
    where a person names it.

    It has the numbers of the belief that were fitted to it: those of the settings' file, else this
    user's, else those that the map was made with.

    Args:
        bundle: The map.
        config: Its encoder's device, precision and calibration count.
        clip: The encoder, as `--clip` names it; None for the one that the map names.

    Raises:
        ConfigError: there are no weights for it here, the class breaks its contract, or the file
            of its calibration cannot be used.
        MapError: the map names a class and no person does, or another encoder made the map.
    """
    from mapping import map_bundle
    from mapping.clip.fitted.encoder import (
        CalibratedEncoder,
        CalibratedTexts,
        calibration_to_ask_with,
    )

    if clip is None:
        map_bundle.require_no_class(bundle)
        clip = bundle.model_id
    named = clip, config.device, config.half
    require_encoder(clip, config.device)
    file = Path(config.clip_calibration) if config.clip_calibration else None
    if len(bundle.pictures):
        texts = open_text_encoder(*named)
        map_bundle.require_encoder(bundle, texts)
        found = calibration_to_ask_with(texts, file, bundle.calibration)
        return texts if found is None else CalibratedTexts(texts, *found)
    encoder = open_encoder(*named)  # the map has no bank: it embeds the pictures
    map_bundle.require_encoder(bundle, encoder)
    found = calibration_to_ask_with(encoder, file, bundle.calibration)
    return encoder if found is None else CalibratedEncoder(encoder, *found)


def calibration_line(encoder: TextEncoder, clip: str) -> str | None:
    """Whether the belief's numbers were fitted to an encoder, in one line.

    None for the encoder that comes along with its numbers, where it has no others.

    Args:
        encoder: As it was opened.
        clip: As it was named.
    """
    from mapping.clip.fitted.encoder import CalibratedEncoder, CalibratedTexts

    if isinstance(encoder, CalibratedEncoder | CalibratedTexts):
        return f"{encoder.model_id} is calibrated for this encoder by {encoder.source}"
    if is_rehearsal_encoder(encoder.model_id):
        return None
    return (
        f"{encoder.model_id}: the belief is not calibrated for this encoder;"
        f" `vizbot calibrate encoder --clip {clip}` fits it"
    )


def _embedded_files(name: str) -> EmbeddedFiles:
    from mapping.clip.embedded.model_files import read_files

    files = read_files()
    if name not in ("embedded", files.model_id):
        raise ConfigError(f"this vizbot has {files.model_id}, not {name!r}: build the map again")
    return files


def _require_photos(name: str) -> None:
    from mapping.clip.photos.text_encoder import model_id

    if name not in ("photos", model_id()):
        raise ConfigError(f"this vizbot has {model_id()}, not {name!r}: build the map again")


def _open_recording(
    config: Config, path: Path, recording: tuple[Intrinsics, float] | None
) -> Camera:
    if path.suffix in (".db3", ".bag"):
        from drivers.realsense.playback import RealSenseRecording

        return RealSenseRecording(config.realsense, path)
    from drivers.tum_sequence import RecordedSequence

    return RecordedSequence(path, *(recording or (None, None)))


def require_mix(camera: str, base: str) -> None:
    """Refuse devices, named as for `require_devices`, that do not go together.

    Raises:
        ConfigError: there is no such mix.
    """
    if base not in ("sim", "roomba", "none"):
        raise ConfigError(f"unknown base {base!r}; use sim, roomba or none")
    if camera not in ("sim", "realsense") and base != "none":
        raise ConfigError(f"the recording {camera} cannot be driven; use --base none")


def open_base(config: Config, clock: WallClock, opened: ExitStack) -> Base:
    """A base without a camera, on the wall clock; `opened` closes it.

    Raises:
        DeviceError: the base is missing or does not answer.
    """
    from drivers.roomba.base import Roomba
    from drivers.roomba.reflex_process.process_link import ProcessLink
    from drivers.roomba.serial_port import SerialAddress

    link = ProcessLink(SerialAddress(config.serial_port).open, config.roomba)
    return opened.enter_context(Roomba(link, clock, config.roomba))
