"""Contacts of a round robot with a mast in a house, and edges of the floor under it."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np
from numpy.typing import NDArray

from sim_stubs.homes.geometry.house import House
from sim_stubs.homes.geometry.occupancy_slice import PlanGrid, clearance, grid_around, occupied
from sim_stubs.homes.geometry.solids import triangles
from sim_stubs.world.body import Contacts, Outline

BASE_LAYER = (0.02, 0.10)
"""Heights of the layer of the base [m]; the robot drives over lower things."""
FLOOR_LAYER = (-0.03, 0.02)
"""Heights between which a surface counts as floor [m]."""
TOUCH = 0.003
"""Largest gap of a contact [m]."""
CENTRE = np.radians(10.0)
"""The bumper pressed within this of straight ahead presses both switches [rad]."""
CLIFF_BEARINGS = tuple(np.radians([60.0, 15.0, -15.0, -60.0]))
"""Bearings of the cliff sensors: left, front left, front right, right [rad]."""


class ContactMap:
    """The true shapes of a house in two layers: the base's, and above it the mast's."""

    def __init__(self, house: House, outline: Outline, resolution: float = 0.01) -> None:
        """Cut the house into layers of cells with edges of `resolution` [m]."""
        everything = triangles(house.parts())
        self._grid = grid_around(everything, resolution)
        self._base = _Layer(everything, *BASE_LAYER, self._grid)
        self._mast = _Layer(everything, BASE_LAYER[1], outline.mast_height, self._grid)
        self._floor = occupied(everything, *FLOOR_LAYER, self._grid)
        self._radius, self._mast_radius = outline.radius, outline.mast_radius
        self._mast_forward = outline.mast_forward
        self._wheels = outline.wheel_base / 2
        self._gap = (np.nan, np.nan, np.nan), 0.0

    def gap(self, x: float, y: float, yaw: float) -> float:
        """Free space around the robot [m]; negative where it overlaps something."""
        # A step asks three times: where it ends, what it touches there, where the next one starts.
        if self._gap[0] != (x, y, yaw):
            mast = self._mast.distance(
                x + self._mast_forward * cos(yaw), y + self._mast_forward * sin(yaw)
            )
            gap = min(self._base.distance(x, y) - self._radius, mast - self._mast_radius)
            self._gap = (x, y, yaw), gap
        return self._gap[1]

    def free(self) -> tuple[NDArray[np.bool_], PlanGrid]:
        """Cells (rows, cols) of about 5 cm where the robot can stand without contact.

        With any heading, and with the whole base over floor.
        """
        step = max(1, round(0.05 / self._grid.resolution))
        middles = slice(step // 2, None, step)
        edge = clearance(~self._floor, self._grid)
        clear = np.minimum(self._base.clear, edge)[middles, middles] > self._radius
        clear &= self._mast.clear[middles, middles] > self._mast_forward + self._mast_radius
        return clear, PlanGrid(self._grid.origin, step * self._grid.resolution, clear.shape)

    def contacts(self, x: float, y: float, yaw: float) -> Contacts:
        """Contacts of bumper, cliff sensors and wheels.

        A touch from behind stops the robot but presses no switch. The mast is guarded by a strip
        that works the same switches.
        """
        left = right = False
        if self.gap(x, y, yaw) < TOUCH:
            for bearing in self._touched(x, y, yaw):
                left |= -CENTRE < bearing < pi / 2
                right |= -pi / 2 < bearing < CENTRE
        reach = 0.9 * self._radius
        cliffs = [
            not self._has_floor(x + reach * cos(yaw + b), y + reach * sin(yaw + b))
            for b in CLIFF_BEARINGS
        ]
        drops = self.wheel_drops(x, y, yaw)
        return Contacts(
            bool(left), bool(right), (cliffs[0], cliffs[1], cliffs[2], cliffs[3]), drops
        )

    def wheel_drops(self, x: float, y: float, yaw: float) -> tuple[bool, bool]:
        """Whether there is no floor below the left and the right wheel."""
        dx, dy = -sin(yaw) * self._wheels, cos(yaw) * self._wheels
        return not self._has_floor(x + dx, y + dy), not self._has_floor(x - dx, y - dy)

    def _touched(self, x: float, y: float, yaw: float) -> list[float]:
        """Bearings of everything in contact [rad, -pi to pi]."""
        mast_x = x + self._mast_forward * cos(yaw)
        mast_y = y + self._mast_forward * sin(yaw)
        return [
            *self._base.bearings(x, y, yaw, self._radius),
            *self._mast.bearings(mast_x, mast_y, yaw, self._mast_radius),
        ]

    def _has_floor(self, x: float, y: float) -> bool:
        cell = self._grid.cell_of(x, y)
        return cell is not None and bool(self._floor[cell])


class _Layer:
    """One slice with its distance field.

    Attributes:
        clear: (rows, cols) distance to the nearest surface [m].
    """

    def __init__(
        self, everything: NDArray[np.float64], low: float, high: float, grid: PlanGrid
    ) -> None:
        self._grid = grid
        self._occupied = occupied(everything, low, high, grid)
        self.clear = clearance(self._occupied, grid)

    def distance(self, x: float, y: float) -> float:
        """Distance to the nearest surface [m], interpolated between cells; 0 outside."""
        column = (x - self._grid.origin[0]) / self._grid.resolution - 0.5
        row = (y - self._grid.origin[1]) / self._grid.resolution - 0.5
        rows, columns = self._grid.shape
        if not (0 <= row < rows - 1 and 0 <= column < columns - 1):
            return 0.0
        i, j = int(row), int(column)
        s, t = row - i, column - j
        (low_left, low_right), (high_left, high_right) = self.clear[i : i + 2, j : j + 2].tolist()
        below = low_left * (1 - t) + low_right * t
        above = high_left * (1 - t) + high_right * t
        return float(below * (1 - s) + above * s)

    def bearings(self, x: float, y: float, yaw: float, radius: float) -> NDArray[np.float64]:
        """Bearings of the surfaces that a disc touches, relative to its heading [rad]."""
        reach = radius + TOUCH + self._grid.resolution
        low, high = (
            self._grid.to_pixels(np.array([x, y]) + sign * reach).astype(int) for sign in (-1, 1)
        )
        low = low.clip(0)
        window = self._occupied[low[1] : high[1] + 2, low[0] : high[0] + 2]
        rows, columns = np.nonzero(window)
        offsets = self._grid.pixels_to_xy(np.column_stack([columns, rows]) + low) - (x, y)
        near = np.hypot(offsets[:, 0], offsets[:, 1]) < reach
        angles = np.arctan2(offsets[near, 1], offsets[near, 0]) - yaw
        return np.asarray((angles + pi) % (2 * pi) - pi)
