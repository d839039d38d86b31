import numpy as np
import pytest
from numpy.typing import NDArray

from sim_stubs.homes.furniture.decimation import decimated
from sim_stubs.homes.furniture.wavefront import Material, Surface

pytestmark = pytest.mark.slow  # its kernel is compiled for the first model


def grid(count: int, height: float = 0.0) -> NDArray[np.float64]:
    """(F, 3, 3) triangles of a unit square of `count` x `count` cells, facing +z."""
    ticks = np.linspace(0.0, 1.0, count + 1)
    x, y = (axis.ravel() for axis in np.meshgrid(ticks[:-1], ticks[:-1]))
    step = 1.0 / count
    low, right = np.stack([x, y], axis=1), np.stack([x + step, y], axis=1)
    high, up = np.stack([x + step, y + step], axis=1), np.stack([x, y + step], axis=1)
    flat = np.concatenate([np.stack([low, right, high], 1), np.stack([low, high, up], 1)])
    return np.concatenate([flat, np.full((*flat.shape[:2], 1), height)], axis=2)


def area(corners: NDArray[np.float64]) -> float:
    facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return float(np.linalg.norm(facing, axis=1).sum() / 2)


def sheet(corners: NDArray[np.float64]) -> Surface:
    """A surface whose texture coordinates are twice its x and y."""
    return Surface(Material(texture="cloth.png"), corners, 2.0 * corners[..., :2])


def test_a_model_below_the_limit_is_untouched() -> None:
    surface = sheet(grid(3))
    assert decimated([surface], 100)[0] is surface


def test_a_flat_sheet_keeps_its_outline_in_few_triangles() -> None:
    (surface,) = decimated([sheet(grid(20))], 40)
    assert len(surface.corners) <= 40
    assert area(surface.corners) == pytest.approx(1.0, abs=1e-9)


def test_texture_coordinates_stay_where_they_were() -> None:
    corners = grid(20)
    corners[..., 2] = 0.1 * np.sin(3.0 * corners[..., 0])
    (surface,) = decimated([sheet(corners)], 100)
    np.testing.assert_allclose(surface.texcoords, 2.0 * surface.corners[..., :2], atol=1e-6)


def test_a_seam_in_the_texture_stays_sharp() -> None:
    corners = grid(20)
    texcoords = 2.0 * corners[..., :2]
    texcoords[corners[..., 0].mean(axis=1) > 0.5] += [10.0, 0.0]
    (surface,) = decimated([Surface(Material(), corners, texcoords)], 60)
    spans = np.ptp(surface.texcoords[..., 0], axis=1)
    across = (surface.corners[..., 0].min(axis=1) < 0.49) & (
        surface.corners[..., 0].max(axis=1) > 0.51
    )
    assert (spans[~across] < 2.01).all()


def test_flat_surfaces_pay_for_round_ones() -> None:
    bumpy = grid(20)
    bumpy[..., 2] = 0.1 * np.sin(12.0 * bumpy[..., 0]) * np.sin(12.0 * bumpy[..., 1])
    flat, round_ = decimated([sheet(grid(20, height=2.0)), sheet(bumpy)], 300)
    assert len(flat.corners) < 30 < len(round_.corners)
    assert len(flat.corners) + len(round_.corners) <= 300
