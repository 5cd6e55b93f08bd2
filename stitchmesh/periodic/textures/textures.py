# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Texture maps of one period of a fabric that tile without a seam, seen from its right side.

Column i and row j of a map are shares of the periods u and v (``texture_plan``): where the periods are not at right
angles a map is sheared, and a renderer that lays its texture coordinates along u and v shows it right. Normals and
directions are not sheared: x is along u, y at right angles to it in the fabric, z to its right side.

Each pixel is the mean of 2 by 2 samples of the yarns as exact round tubes. Colours are those of the yarns' dyes, let
down where the fabric around a place stands higher, which keeps light out from every side alike; there is no lamp in
them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError, YarnError
from stitchmesh.lattice import Lattice
from stitchmesh.mesh import FloatArray
from stitchmesh.periodic.textures.plan import Plan
from stitchmesh.periodic.textures.surface import Surface, surface_at
from stitchmesh.periodic.textures.tubes import Tubes, tubes_above
from stitchmesh.periodic.textures.visibility import visible_pieces
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.colours import WOOLS
from stitchmesh.yarn.tiling import tile_yarns

SAMPLES = 2
"""Along each side of a pixel."""
LARGEST = 8192
"""Pixels along a side."""
ROWS_AT_ONCE = 32
"""Rows of pixels that are coloured together."""
HOLLOWS = ((0.25, 2.0), (0.75, 1.0), (2.0, 0.5))
"""Widths of the surroundings of a place in yarn radii, and how much each keeps light out."""


@dataclass(frozen=True, eq=False, kw_only=True)
class TextureMaps:
    """Maps of one period, the top row first, as pictures are."""

    lattice: Lattice
    """Periods that a map spans [cm]."""
    depth: float
    """From the lowest to the highest point of the yarns [cm]."""
    colour: FloatArray
    """sRGB from 0 to 1, shape (h, w, 3); holes have the mean colour, so that nothing shows at their rims."""
    height: FloatArray
    """Above the lowest point of the yarns [cm], shape (h, w); 0 in holes."""
    normal: FloatArray
    """Unit normals, shape (h, w, 3); (0, 0, 1) in holes."""
    opacity: FloatArray
    """Share of each pixel that yarn covers, shape (h, w)."""
    tangent: FloatArray
    """Directions of the yarn on top, shape (h, w, 3): a unit vector (x, y) in the fabric's plane and how steeply the
    yarn climbs along it, the sine of the angle; 0 in holes."""


def texture_maps(
    yarns: YarnSet, *, width: int, height: int | None = None, tiles: tuple[int, int] = (1, 1)
) -> TextureMaps:
    """Colour, height, normal, opacity and direction of a fabric that repeats.

    Args:
        yarns: a set on a lattice.
        width: pixels along the courses.
        height: pixels along the wales; where None, as many as make pixels about as high as wide.
        tiles: periods along the courses and along the wales that a map shows.

    Raises:
        ParameterError: a size or a number of tiles is not a whole number from 1, or a size is above 8192.
        YarnError: the set has no lattice.
    """
    cell = yarns if tiles == (1, 1) else tile_yarns(yarns, *tiles, periodic=True)
    if cell.lattice is None:
        raise YarnError("textures: the yarns do not repeat; expected a cell on a lattice, such as a periodic swatch")
    size = np.linalg.norm(cell.lattice.periods, axis=1)
    _check_size("width", width)
    height = max(1, round(float(width * size[1] / size[0]))) if height is None else height
    _check_size("height", height)
    fine = Plan(cell.lattice, SAMPLES * width, SAMPLES * height)
    tubes = tubes_above(cell, fine)
    maps = _mean_maps(tubes, fine, _linear(WOOLS)[cell.colour % len(WOOLS)])
    low, high = tubes.depth
    covered = maps["opacity"] > 0.0
    relief = np.where(covered, maps["height"] - low, 0.0)
    light = _openness(relief, Plan(cell.lattice, width, height), float(cell.radius.mean()))
    return TextureMaps(
        lattice=cell.lattice,
        depth=high - low,
        colour=_coloured(maps["colour"], light, covered)[::-1],
        height=relief[::-1],
        normal=np.where(covered[:, :, None], maps["normal"], [0.0, 0.0, 1.0])[::-1],
        opacity=maps["opacity"][::-1],
        tangent=maps["tangent"][::-1],
    )


def _check_size(name: str, pixels: int) -> None:
    if not isinstance(pixels, int | np.integer) or not 1 <= pixels <= LARGEST:
        raise ParameterError(f"textures: got a {name} of {pixels} pixels; expected a whole number from 1 to {LARGEST}")


def _mean_maps(tubes: Tubes, fine: Plan, dyes: FloatArray) -> dict[str, FloatArray]:
    """Means of the samples of each pixel, bottom row first; of what is there, where some samples see through."""
    visible = visible_pieces(tubes, fine)
    step = SAMPLES * ROWS_AT_ONCE
    bands = []
    for first in range(0, fine.height, step):
        surface = surface_at(tubes, fine, visible, first, min(first + step, fine.height))
        bands.append(_means(surface, dyes))
    return {name: np.concatenate([band[name] for band in bands]) for name in bands[0]}


def _means(surface: Surface, dyes: FloatArray) -> dict[str, FloatArray]:
    covered = surface.covered.astype(np.float64)
    share = _blocks(covered).mean(axis=2)
    seen = np.maximum(_blocks(covered).sum(axis=2), 1.0)
    normal = _blocks(surface.normal).sum(axis=2)
    dyed = np.where(surface.covered[:, :, None], dyes[surface.yarn], 0.0)
    return {
        "opacity": share,
        "height": _blocks(surface.height).sum(axis=2) / seen,
        "normal": normal / np.maximum(np.linalg.norm(normal, axis=2), 1e-12)[:, :, None],
        "colour": _blocks(dyed).sum(axis=2) / seen[:, :, None],
        "tangent": _tangents(surface),
    }


def _tangents(surface: Surface) -> FloatArray:
    """Direction of the highest sample of each pixel: two yarns that run against each other have no mean."""
    height = np.where(surface.covered, surface.height, -np.inf)
    highest = _blocks(height).argmax(axis=2)
    direction = _blocks(surface.direction)
    chosen = np.take_along_axis(direction, highest[:, :, None, None], axis=2)[:, :, 0]
    level = np.maximum(np.hypot(chosen[:, :, 0], chosen[:, :, 1]), 1e-12)
    return np.concatenate([chosen[:, :, :2] / level[:, :, None], chosen[:, :, 2:]], axis=2)


def _blocks(values: FloatArray) -> FloatArray:
    """Samples of each pixel together, shape (rows * 2, columns * 2, ...) to (rows, columns, 4, ...)."""
    rows, columns = values.shape[0] // SAMPLES, values.shape[1] // SAMPLES
    split = values.reshape(rows, SAMPLES, columns, SAMPLES, *values.shape[2:])
    return split.swapaxes(1, 2).reshape(rows, columns, SAMPLES**2, *values.shape[2:])


def _openness(relief: FloatArray, plan: Plan, radius: float) -> FloatArray:
    """Share of the light from all around that reaches each place, from how far it lies below its surroundings."""
    light = np.ones_like(relief)
    for width, strength in HOLLOWS:
        hollow = np.maximum(_smoothed(relief, plan, width * radius) - relief, 0.0) / radius
        light /= 1.0 + strength * hollow
    return light


def _smoothed(values: FloatArray, plan: Plan, width: float) -> FloatArray:
    """Mean under a Gaussian bell of that standard deviation [cm], over all images: a product of Fourier series."""
    wave = np.linalg.inv(plan.periods).T * 2 * np.pi
    row, column = np.fft.fftfreq(plan.height) * plan.height, np.fft.rfftfreq(plan.width) * plan.width
    x = column * wave[0, 0] + row[:, None] * wave[1, 0]
    y = column * wave[0, 1] + row[:, None] * wave[1, 1]
    bell = np.exp(-0.5 * width**2 * (x**2 + y**2))
    return np.fft.irfft2(np.fft.rfft2(values) * bell, s=values.shape)


def _coloured(linear: FloatArray, light: FloatArray, covered: NDArray[np.bool_]) -> FloatArray:
    """The sRGB of dyes under a share of the light, and their mean where there is no yarn."""
    lit = linear * light[:, :, None]
    mean = lit[covered].mean(axis=0) if covered.any() else np.zeros(3)
    value = np.where(covered[:, :, None], lit, mean)
    return np.where(value <= 0.0031308, 12.92 * value, 1.055 * np.maximum(value, 1e-9) ** (1 / 2.4) - 0.055)


def _linear(value: FloatArray) -> FloatArray:
    """Linear colour of sRGB from 0 to 1 (IEC 61966-2-1)."""
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)
