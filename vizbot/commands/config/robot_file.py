"""The settings file that `vizbot config init` writes."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from mapping.clip.checkpoint.checkpoint import SHORT_NAMES
from vizbot.commands.config.settings_table import Setting, Table, toml_value
from vizbot.core.errors import ConfigError, DeviceError
from vizbot.operator.printing import printable
from vizbot.rig import FETCHED_EASILY, PHOTOS_FETCHED, require_encoder

_WIDTH = 98
"""Letters of a comment's line."""
_BEGINNING = """\
# Settings of this robot, for vizbot. A line that begins with # and no space is a setting at its
# default, or ... where it has none: take the # away to change it. docs/settings.md has all settings
# with their bounds, the advanced ones last, and `vizbot config show` prints those in use.
"""


@dataclass(frozen=True, slots=True)
class Seen:
    """What is written of a device.

    Attributes:
        value: Value of its setting; None if no device was seen.
        remark: What was seen, in a sentence.
    """

    value: str | None
    remark: str


def seen_devices() -> dict[str, Seen]:
    """What there is on this machine, by the setting that names it; none is opened."""
    return {
        "clip": _seen_encoder(),
        "serial_port": _seen_port(),
        "realsense.serial": _seen_camera(),
    }


def robot_file(tables: Sequence[Table], devices: Mapping[str, Seen], *, every: bool) -> str:
    """The text of the file, with `devices` by the setting that names each."""
    parts = [_BEGINNING]
    for table in tables:
        if table.heading.startswith("[["):
            continue  # the list itself shows its entries
        key = table.heading.strip("[]")
        settings = [each for each in table.settings if every or not each.advanced]
        shown = {f"{key}.{each.name}".lstrip("."): each for each in settings}
        if shown and key:
            parts.append(_heading(table))
        parts += [_entry(each, devices.get(path)) for path, each in shown.items()]
    return "\n".join(parts)


def _heading(table: Table) -> str:
    about = _comment(f"{table.description} {table.caution}")
    return f"{about}{'#' if table.caution else ''}{table.heading}\n"


def _entry(setting: Setting, seen: Seen | None) -> str:
    """A setting below its description; only what was seen is no comment."""
    if seen is not None:
        setting = replace(setting, description=f"{setting.description} {seen.remark}")
    about = _comment(setting.description)
    if setting.name == "clip":
        about += "".join(f"# {line}\n" for line in choices_text())
    if seen is not None and seen.value is not None:
        return f"{about}{setting.name} = {toml_value(seen.value)}\n"
    if setting.default is None:
        return f"{about}#{setting.name} = ...\n"
    return f"{about}#{setting.name} = {setting.default}\n"


def _comment(text: str) -> str:
    """The text as comments; no letter of a device's name ends a line or is none of TOML."""
    lines = textwrap.wrap(printable(text), _WIDTH, break_on_hyphens=False)
    return "".join(f"# {line}\n" for line in lines)


def _seen_encoder() -> Seen:
    fetched = fetched_encoders()
    if fetched:
        return Seen(fetched[0], f"Fetched here: {', '.join(fetched)}.")
    return Seen(None, f"Fetch one, as by {FETCHED_EASILY} here, or by {PHOTOS_FETCHED}.")


def _seen_port() -> Seen:
    from drivers.roomba.serial_port import serial_adapters

    try:
        return _first([(path, path) for path in serial_adapters()], "the base's cable")
    except DeviceError as error:
        return _nothing(str(error))


def _seen_camera() -> Seen:
    try:
        from drivers.realsense.examination import cameras

        found = [(camera.serial, f"{camera.name} {camera.serial}") for camera in cameras()]
    except (DeviceError, RuntimeError) as error:  # the SDK is missing, or fails
        return _nothing(str(error))
    return _first(found, "the camera")


def _first(found: Sequence[tuple[str, str]], wanted: str) -> Seen:
    """The first of what was found, each as its value and its name."""
    if not found:
        return _nothing(f"plug in {wanted}, or name it")
    return Seen(found[0][0], f"Seen here: {', '.join(name for _, name in found)}.")


def _nothing(reason: str) -> Seen:
    return Seen(None, f"None was seen here: {reason}.")


@dataclass(frozen=True, slots=True)
class EncoderChoice:
    """An encoder on a computer.

    Attributes:
        computer: What it runs on.
        frame: Time for the 25 patches of a frame [s].
        meaning: What that means for a search.
    """

    computer: str
    encoder: str
    frame: float
    meaning: str


CHOICES = (
    EncoderChoice(
        "an NVIDIA GPU (an H200)",
        'clip = "ViT-L/14", device = "cuda", half = true',
        0.017,
        "every frame is looked at",
    ),
    EncoderChoice(
        "a PC or a NUC (one core of Zen 4; more cores take less)",
        'clip = "ViT-B/32"',
        2.9,
        "a look in 1.5 m at full speed, two in the first turn: it may pass a thing by",
    ),
    EncoderChoice(
        "a PC or a NUC (one core of Zen 4; more cores take less)",
        'clip = "photos"',
        1.6,
        "a look in 0.8 m at full speed, three in the first turn; a thousand names, no sentences",
    ),
    EncoderChoice(
        "16 cores of a server",
        'clip = "ViT-L/14"',
        4.7,
        "a look in 2.4 m at full speed, one or two in the first turn: ViT-B/32 sees more",
    ),
    EncoderChoice(
        "a PC or a NUC (one core of Zen 4)",
        'clip = "ViT-L/14"',
        53.0,
        "a look in a minute: most of a home is passed by unseen; do not take it",
    ),
    EncoderChoice(
        "any",
        'clip = "embedded"',
        0.065,
        "for rehearsals: it knows simulated homes alone, and launch refuses it",
    ),
)
"""As measured (docs/hardware.md); distances follow from the speed limits."""


def choices_text() -> list[str]:
    """The table in lines of plain text, two for each encoder."""
    lines = ["Choose the encoder: computer; seconds for a frame; what that means for a search."]
    for each in CHOICES:
        lines.append(f"  {each.encoder}")
        lines.append(f"    {each.computer}; {each.frame:g} s; {each.meaning}")
    return lines


def fetched_encoders() -> list[str]:
    """The published encoders that are on this machine, by their short names; none is loaded."""
    found = []
    for name in (*SHORT_NAMES, "photos"):
        try:
            require_encoder(name)
        except ConfigError:
            continue
        found.append(name)
    return found
