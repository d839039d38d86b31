"""The device that encoders compute on."""

from __future__ import annotations

import torch

from vizbot.core.errors import ConfigError


def compute_device(name: str) -> torch.device:
    """The device of PyTorch that a setting names; `auto` is CUDA where there is a device.

    Raises:
        ConfigError: there is no such device.
    """
    if name == "auto":
        return torch.device("cuda" if torch.cuda.is_available() else "cpu")
    try:
        device = torch.device(name)
    except RuntimeError as error:
        raise ConfigError(f"no device {name!r} for CLIP; give cpu, cuda or auto") from error
    if device.type == "cuda" and (device.index or 0) >= torch.cuda.device_count():
        raise ConfigError(f"no device {name!r} for CLIP on this machine; give cpu or auto")
    return device
