"""Reads the weights of a checkpoint: safetensors, or the tensors of a pickle, in one file or more.

Whatever a file holds, it runs nothing: a pickle is read by PyTorch's own reader of tensors.
"""

from __future__ import annotations

import errno
import pickle
from pathlib import Path
from typing import Any

import torch
from safetensors import SafetensorError
from safetensors.torch import load_file

from mapping.clip.checkpoint.checkpoint import ClipCheckpoint
from vizbot.core.files import parse_json, read_regular

_LARGEST_LIST = 16 * 1024 * 1024
"""Size of the list of several files [bytes]."""
_MOST_FILES = 200
_POINTER = b"version https://git-lfs"
"""How the stand-in begins that git leaves where large files are kept elsewhere."""
_LONGEST_REASON = 200
"""Most letters of a library's own words."""


def read_tensors(checkpoint: ClipCheckpoint) -> dict[str, torch.Tensor]:
    """The tensors of a checkpoint by their names, in memory.

    Raises:
        ConfigError: a file is missing, not whole, or more than tensors; or there is too little
            memory.
    """
    tensors: dict[str, torch.Tensor] = {}
    for path in _files(checkpoint):
        tensors |= _tensors_of(checkpoint, path)
    return tensors


def reason_of(error: Exception) -> str:
    """What a library says, in one line."""
    said = " ".join(str(error).split()) or type(error).__name__
    return said if len(said) <= _LONGEST_REASON else f"{said[: _LONGEST_REASON - 3]}..."


def lacks_memory(error: Exception) -> bool:
    """Whether a library failed because there is too little memory; each says it otherwise."""
    if isinstance(error, OSError):
        return error.errno == errno.ENOMEM
    if isinstance(error, (MemoryError, torch.OutOfMemoryError)):
        return True
    return isinstance(error, RuntimeError) and (
        "allocate memory" in str(error) or "not enough memory" in str(error)
    )


def _files(checkpoint: ClipCheckpoint) -> list[Path]:
    """The file, or those that a list names beside it."""
    weights = checkpoint.weights
    if weights.suffix != ".json":
        return [weights]
    try:
        names = sorted(set(parse_json(read_regular(weights, _LARGEST_LIST))["weight_map"].values()))
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise checkpoint.refused(f"has a {weights.name} that lists no files") from error
    if not 0 < len(names) <= _MOST_FILES or any(name != Path(name).name for name in names):
        raise checkpoint.refused(f"has a {weights.name} that lists no files beside it")
    if missing := [name for name in names if not (weights.parent / name).is_file()]:
        raise checkpoint.refused(
            f"lacks {len(missing)} of its {len(names)} files of weights, {missing[0]} first"
        )
    return [weights.parent / name for name in names]


def _tensors_of(checkpoint: ClipCheckpoint, path: Path) -> dict[str, torch.Tensor]:
    try:
        with path.open("rb") as file:
            beginning = file.read(len(_POINTER))
    except OSError as error:
        fault = f"has a {path.name} that cannot be read: {error.strerror}"
        raise checkpoint.refused(fault) from error
    if beginning == _POINTER:
        raise checkpoint.refused(
            f"has a stand-in of Git LFS instead of {path.name}, whose content was not fetched"
        )
    try:
        read = load_file if path.suffix == ".safetensors" else _unpickled
        tensors = read(path)
    except SafetensorError as error:
        fault = f"has a {path.name} that is damaged or not whole ({reason_of(error)})"
        raise checkpoint.refused(fault) from error
    except pickle.UnpicklingError as error:
        raise checkpoint.refused(_fault_of_pickle(path, error)) from error
    # Readers of PyTorch raise whatever the bytes of a file that was cut off lead them to.
    except (
        OSError, EOFError, MemoryError, RuntimeError, ValueError, LookupError, TypeError,
        AttributeError, AssertionError,
    ) as error:  # fmt: skip
        if lacks_memory(error):
            size = f"{path.stat().st_size / 1e9:.1f} GB"
            fault = f"does not fit into this computer's memory: {path.name} has {size}"
            raise checkpoint.refused(fault) from error
        raise checkpoint.refused(f"has a {path.name} that is damaged or not whole") from error
    if not isinstance(tensors, dict) or not all(
        isinstance(name, str) and isinstance(each, torch.Tensor) for name, each in tensors.items()
    ):
        raise checkpoint.refused(f"has a {path.name} that is no table of tensors")
    return tensors


def _unpickled(path: Path) -> Any:
    return torch.load(path, map_location="cpu", weights_only=True)


def _fault_of_pickle(path: Path, error: pickle.UnpicklingError) -> str:
    said = str(error)
    if "GLOBAL" in said or "nsupported class" in said:
        return f"has a {path.name} that holds more than tensors, which might run: it is refused"
    return f"has a {path.name} that is damaged or not whole"
