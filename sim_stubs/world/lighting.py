"""Lighting of a home: brightness, colour temperature, and the lamps that are lit for a picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

LAMPS = 7
"""Most lamps at once: OpenGL's fixed pipeline has eight lights, and one is the headlight."""
FADE = 1.0
"""Distance over which a lamp fades before seven others are nearer [m]."""
LAMP = np.array([0.50, 0.49, 0.475])
"""Red, green and blue of a lamp under neutral lighting."""


@dataclass(frozen=True, slots=True)
class Lighting:
    """Lighting of a home.

    Attributes:
        brightness: Factor of all lights.
        temperature: Colour temperature left after the camera's white balance [K], 2700 to 6500;
            5000 is neutral, less is warmer.
    """

    brightness: float = 1.0
    temperature: float = 5000.0

    @staticmethod
    def drawn(rng: np.random.Generator) -> Lighting:
        """Random lighting, from dim to bright and from warm to cool."""
        return Lighting(float(np.exp(rng.uniform(-0.35, 0.25))), float(rng.uniform(4000, 6200)))

    @property
    def rgb(self) -> NDArray[np.float64]:
        """(3,) factors of red, green and blue, the brightness in them."""
        # sRGB of black bodies after T. Helland's fit to M. Charity's table.
        kelvin = (2700.0, 4000.0, 5000.0, 6500.0)
        table = np.array([[255, 167, 87], [255, 206, 166], [255, 228, 206], [255, 254, 250]])
        tint = np.array([np.interp(self.temperature, kelvin, table[:, i]) for i in range(3)])
        tint = tint / table[2]
        return np.asarray(self.brightness * tint / tint.mean())


def lamp_weights(lamps: NDArray[np.float64], position: NDArray[np.float64]) -> NDArray[np.float64]:
    """Brightness of each lamp (N,), 0 to 1, for a camera at `position`; at most seven are lit.

    The nearest lamps are lit. The weights change steadily with the position, so that no
    lamp is seen to go on or off.
    """
    if len(lamps) <= LAMPS:
        return np.ones(len(lamps))
    distances = np.linalg.norm(lamps - position, axis=1)
    return np.asarray(np.clip((np.sort(distances)[LAMPS] - distances) / FADE, 0.0, 1.0))
