"""An encoder of one's own: a class by the Protocol `ClipEncoder`, named `MODULE:CLASS`.

It is checked against the contract before it is used, so that an error says which method is wrong,
instead of a map that finds nothing.
"""

from __future__ import annotations

import importlib
import importlib.util
import re
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mapping.clip.reading import Reading
from vizbot.core.errors import ConfigError

if TYPE_CHECKING:  # its module loads torch
    from mapping.clip.encoder import ClipEncoder

_NAME = re.compile(r"[A-Za-z_][\w.]*:[A-Za-z_]\w*")
_TEXTS = ("a chair", "a kitchen", "something red")
_SIZES = ((480, 640), (96, 128), (50, 31))
_PLAIN = ((200, 30, 30), (40, 150, 60), (40, 70, 190))
"""Colours of pictures that every encoder of pictures distinguishes."""
_SAME = 0.999
"""Least cosine between two embeddings of one picture, alone and in a batch."""
_UNIT = 1e-3
"""Greatest difference of a length from 1."""


def is_class_name(name: str) -> bool:
    """Whether this names a class, and no model."""
    return _NAME.fullmatch(name) is not None


def require_module(name: str) -> None:
    """Refuse a `MODULE:CLASS` whose module is nowhere: neither installed nor in this folder.

    Raises:
        ConfigError: there is no such module.
    """
    module = name.partition(":")[0]
    _look_here_too()
    try:
        found = importlib.util.find_spec(module) is not None
    except (ImportError, ValueError):
        found = False
    if not found:
        raise ConfigError(
            f"--clip {name}: there is no module {module}; install it, or start in its folder"
        )


def open_class(name: str) -> ClipEncoder:
    """An encoder of the class that `MODULE:CLASS` names, made without arguments.

    Raises:
        ConfigError: there is no such class, it cannot be made, or it does not keep the contract.
    """
    require_module(name)
    module, _, kind = name.partition(":")
    try:
        encoder = getattr(importlib.import_module(module), kind)()
    except Exception as error:  # any error of that code
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        raise ConfigError(f"--clip {name} cannot be made: {reason}") from error
    if fault := broken_promise(encoder):
        raise ConfigError(f"--clip {name} is no encoder: {fault}")
    made: ClipEncoder = encoder
    return made


def broken_promise(encoder: object) -> str | None:
    """How an encoder breaks the Protocol `ClipEncoder`, in one line; None where it keeps it.

    It is tried on a few texts and pictures.
    """
    for place, check in _CHECKS.items():
        try:
            fault = check(encoder)
        except Exception as error:  # any error of that code
            fault = " ".join(f"{place}: {type(error).__name__}: {error}".split())
        if fault:
            return fault
    return None


def _values(encoder: Any) -> str | None:
    if not isinstance(encoder.model_id, str) or not encoder.model_id.isprintable():
        return "model_id is no text of one line"
    if not isinstance(encoder.dimension, int) or encoder.dimension < 1:
        return f"dimension is {encoder.dimension!r}, no whole number above 0"
    if not -1.0 < encoder.threshold < 1.0:
        return f"threshold is {encoder.threshold!r}, no cosine"
    if encoder.log_odds is not None:
        scale, bias = encoder.log_odds
        if not (np.isfinite(scale) and np.isfinite(bias) and scale > 0):
            return f"log_odds is {encoder.log_odds!r}, no scale above 0 and bias"
    if not (encoder.notice is None or isinstance(encoder.notice, str)):
        return f"notice is {encoder.notice!r}, neither a text nor None"
    return None


def _texts(encoder: Any) -> str | None:
    return _embeds(encoder, "embed_texts", encoder.embed_texts, _TEXTS)


def _readings(encoder: Any) -> str | None:
    reading = encoder.reading(_TEXTS[0])
    if isinstance(reading, Reading) and isinstance(reading.text, str):
        return None
    return f"reading returns {reading!r}, no Reading"


def _images(encoder: Any) -> str | None:
    rng = np.random.default_rng(0)
    noise = [rng.integers(0, 256, (*size, 3), np.uint8) for size in _SIZES]
    plain = [
        np.full((*size, 3), colour, np.uint8)
        for size, colour in zip(_SIZES[::-1], _PLAIN, strict=True)
    ]
    return _embeds(encoder, "embed_images", encoder.embed_images, [*noise, *plain])


_CHECKS: Mapping[str, Callable[[Any], str | None]] = {
    "its values": _values,
    "embed_texts": _texts,
    "reading": _readings,
    "embed_images": _images,
}
"""Checks, by where they look."""


def _embeds(encoder: Any, name: str, embed: Callable[[Any], Any], inputs: Any) -> str | None:
    for count in (0, len(inputs)):
        found = embed(list(inputs)[:count])
        wanted = (count, encoder.dimension)
        if not isinstance(found, np.ndarray):
            return f"{name} returns {type(found).__name__}, no array"
        if found.dtype != np.float32 or found.shape != wanted:
            return f"{name} returns {found.dtype} {found.shape}, not float32 {wanted}"
    lengths: NDArray[np.floating] = np.linalg.norm(found, axis=1)
    if not (np.abs(lengths - 1.0) < _UNIT).all():
        return f"{name} returns rows of length {lengths.min():.3g} to {lengths.max():.3g}, not 1"
    for one, row in zip(inputs, found, strict=True):
        if not (embed([one]) @ row >= _SAME).all():
            return (
                f"{name} embeds the same thing otherwise when it is alone: rows come in the order"
                " of what they are of, and none depends on the others"
            )
    return None


def _look_here_too() -> None:
    """Find modules in this folder, after all that are installed."""
    if (here := str(Path.cwd())) not in sys.path:
        sys.path.append(here)
