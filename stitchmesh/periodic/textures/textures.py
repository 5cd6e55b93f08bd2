# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Texture maps of one period of a fabric, seen from its right side, that tile without a seam.

Column i and row j of a map are fractions of the periods u and v (``tubes``). If the periods are not at right angles,
the map is sheared; a renderer that maps its texture coordinates to u and v shows the map correctly. Normals and
directions are not sheared: x runs along u, y at right angles to u in the plane of the fabric, and z points to the right
side.

Each pixel is the mean of 2 by 2 samples of the yarns as exact round tubes of their apparent radius. The yarns have
their own colours, darker where the surrounding fabric is higher, because less light arrives there from all sides; no
lamp is included.

The position of each sample on the centre line of the uppermost yarn is improved by Newton's method on the curve. With d
= p - c_xy, w^2 = r^2 - d^2 and g = d c'_xy, the top f of the ball at parameter s has the derivatives

    f' = c'_z + g / w,    f'' = c''_z + (d c''_xy - c'_xy^2) / w - g^2 / w^3

A step that does not increase f is rejected. The normal is the normal of the ball, (d, w) / r.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError, YarnError, check_kind
from stitchmesh.lattice import Lattice
from stitchmesh.memory_need import BASE_MEMORY, BYTES_PER_TEXTURE_SAMPLE, check_memory
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mesh.palette import colours_of, linear_colour, srgb_colour
from stitchmesh.periodic.textures.tubes import PixelGrid, Tubes, tubes_above
from stitchmesh.periodic.textures.visibility import Visible, visible_pieces
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.tiling import tile_yarns


@dataclass(frozen=True)
class PixelSurface:
    """The surface at the pixels of some rows of a plan, bottom row first; all values are 0 where there is no yarn."""

    covered: NDArray[np.bool_]
    """Whether there is yarn, shape (rows, width)."""
    yarn: IntArray
    """Number of the uppermost yarn, shape (rows, width)."""
    height: FloatArray
    """z of the surface [cm], shape (rows, width)."""
    normal: FloatArray
    """Unit normal, shape (rows, width, 3)."""
    direction: FloatArray
    """Unit vector along the yarn, shape (rows, width, 3)."""


def surface_at(tubes: Tubes, plan: PixelGrid, visible: Visible, first: int, last: int) -> PixelSurface:
    """Return the surface at the rows ``first`` to ``last - 1`` of a plan."""
    rows = slice(first, last)
    covered = visible.segment[rows] >= 0
    row, column = np.nonzero(covered)
    image = visible.image[rows][covered]
    x, y = plan.places(column + image[:, 0] * plan.width, row + first + image[:, 1] * plan.height)
    segment = visible.segment[rows][covered]
    coefficients, radius = tubes.coefficients[segment], tubes.radius[segment]
    start = visible.parameter[rows][covered].astype(np.float64)
    centre, along = _highest(coefficients, start, x, y, radius, 1.0 / tubes.pieces)
    aside = np.stack([x, y], axis=1) - centre[:, :2]
    up = np.sqrt(np.maximum(radius**2 - (aside**2).sum(axis=1), 0.0))
    ball = np.concatenate([aside, up[:, None]], axis=1)
    values = {
        "yarn": tubes.yarn[segment],
        "height": centre[:, 2] + up,
        "normal": ball / np.linalg.norm(ball, axis=1)[:, None],
        "direction": along / np.linalg.norm(along, axis=1)[:, None],
    }
    return PixelSurface(covered, **{name: _expand(covered, value) for name, value in values.items()})


def _highest(
    coefficients: FloatArray, start: FloatArray, x: FloatArray, y: FloatArray, radius: FloatArray, farthest: float
) -> tuple[FloatArray, FloatArray]:
    """Return the centre of the highest ball above each point and the tangent of the curve there, shapes (n, 3)."""
    s, highest = start, np.full(len(start), -np.inf)
    trial = start
    # Two Newton steps follow the first turn. From a straight piece of the curve, they leave an error below 1e-4 in the
    # normal, a hundredth of a step of eight bits.
    for turn in range(3):
        c, c1, c2 = _curve(coefficients, trial)
        dx, dy = x - c[:, 0], y - c[:, 1]
        square = radius**2 - dx**2 - dy**2
        w = np.sqrt(np.maximum(square, 1e-12 * radius**2))
        top = np.where(square > 0.0, c[:, 2] + w, -np.inf)
        rises = (top > highest) | (turn == 0)
        s, highest = np.where(rises, trial, s), np.where(rises, top, highest)
        g = dx * c1[:, 0] + dy * c1[:, 1]
        slope = c1[:, 2] + g / w
        level = c1[:, 0] ** 2 + c1[:, 1] ** 2
        bend = c2[:, 2] + (dx * c2[:, 0] + dy * c2[:, 1] - level) / w - g**2 / w**3
        step = np.where(rises & (bend < 0.0), -slope / np.minimum(bend, -1e-300), 0.0)
        trial = np.clip(s + step, start - farthest, start + farthest)
    centre, along, _ = _curve(coefficients, s)
    return centre, along


def _curve(coefficients: FloatArray, s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the points of the curves, and their first two derivatives by the parameter, shapes (n, 3)."""
    t = s[:, None]
    a, b, c, d = (coefficients[:, power] for power in range(4))
    return a + t * (b + t * (c + t * d)), b + t * (2 * c + 3 * t * d), 2 * c + 6 * t * d


def _expand(covered: NDArray[np.bool_], values: NDArray) -> NDArray:
    """Return an array of all pixels from the values of the covered pixels, 0 elsewhere."""
    expanded = np.zeros((*covered.shape, *values.shape[1:]), dtype=values.dtype)
    expanded[covered] = values
    return expanded


SAMPLES = 2
"""Samples along each side of a pixel."""
LARGEST = 8192
"""Maximum number of pixels along a side of a map."""


@dataclass(frozen=True, eq=False, kw_only=True)
class TextureMaps:
    """Texture maps of one period, with the top row first."""

    lattice: Lattice
    """Periods that a map covers [cm]."""
    depth: float
    """Height difference between the lowest and the highest point of the yarns [cm]."""
    colour: FloatArray
    """sRGB from 0 to 1, shape (h, w, 3); holes have the mean colour, so that no other colour shows at their edges."""
    height: FloatArray
    """Height above the lowest point of the yarns [cm], shape (h, w); 0 in holes."""
    normal: FloatArray
    """Unit normals, shape (h, w, 3); (0, 0, 1) in holes."""
    opacity: FloatArray
    """Fraction of each pixel that yarn covers, shape (h, w)."""
    tangent: FloatArray
    """Directions of the uppermost yarn, shape (h, w, 3): a unit vector (x, y) in the plane of the fabric, and the sine
    of the angle between the yarn and this plane; 0 in holes."""

    def __repr__(self) -> str:
        """Return one line: the size of the maps."""
        return f"TextureMaps({self.height.shape[1]} x {self.height.shape[0]} pixels, depth {self.depth:.3g} cm)"


def texture_maps(
    yarns: YarnSet, *, width: int, height: int | None = None, tiles: tuple[int, int] = (1, 1)
) -> TextureMaps:
    """Compute the colour, height, normal, opacity and direction maps of a fabric that repeats.

    Args:
        yarns: yarns on a lattice.
        width: number of pixels along the courses.
        height: number of pixels along the wales; by default the number that makes the pixels nearly square.
        tiles: numbers of periods along the courses and along the wales in a map.

    Raises:
        ParameterError: a size or a number of tiles is not a positive whole number, or a size is above 8192.
        YarnError: the yarns have no lattice.
    """
    check_kind("texture_maps", yarns, YarnSet)
    cell = yarns if tiles == (1, 1) else tile_yarns(yarns, *tiles, periodic=True)
    if cell.lattice is None:
        raise YarnError("textures: the yarns do not repeat; expected a cell on a lattice, such as a periodic swatch")
    size = np.linalg.norm(cell.lattice.periods, axis=1)
    _check_size("width", width)
    height = max(1, round(float(width * size[1] / size[0]))) if height is None else height
    _check_size("height", height)
    check_texture_memory(width, height)
    fine = PixelGrid(cell.lattice, SAMPLES * width, SAMPLES * height)
    tubes = tubes_above(cell, fine)
    maps = _mean_maps(tubes, fine, linear_colour(colours_of(cell.colour, cell.palette) / 255))
    low, high = tubes.depth
    covered = maps["opacity"] > 0.0
    relief = np.where(covered, maps["height"] - low, 0.0)
    light = _light(relief, PixelGrid(cell.lattice, width, height), float(cell.drawn_radius.mean()))
    return TextureMaps(
        lattice=cell.lattice,
        depth=high - low,
        colour=_srgb(maps["colour"], light, covered)[::-1],
        height=relief[::-1],
        normal=np.where(covered[:, :, None], maps["normal"], [0.0, 0.0, 1.0])[::-1],
        opacity=maps["opacity"][::-1],
        tangent=maps["tangent"][::-1],
    )


def check_texture_memory(width: int, height: int) -> None:
    """Refuse texture maps that do not fit into the memory; width and height in pixels.

    Raises:
        ParameterError: the maps need more memory than there is (``check_memory``).
    """
    check_memory(
        f"a texture of {width} x {height} pixels",
        BASE_MEMORY + BYTES_PER_TEXTURE_SAMPLE * SAMPLES**2 * width * height, "fewer pixels",
    )  # fmt: skip


def _check_size(name: str, pixels: int) -> None:
    if not isinstance(pixels, int | np.integer) or not 1 <= pixels <= LARGEST:
        raise ParameterError(f"textures: got a {name} of {pixels} pixels; expected a whole number from 1 to {LARGEST}")


def _mean_maps(tubes: Tubes, fine: PixelGrid, yarn_colours: FloatArray) -> dict[str, FloatArray]:
    """Return the mean of the covered samples of each pixel, bottom row first."""
    visible = visible_pieces(tubes, fine)
    # Rows of pixels that are processed together; this limits the memory.
    step = SAMPLES * 32
    bands = []
    for first in range(0, fine.height, step):
        surface = surface_at(tubes, fine, visible, first, min(first + step, fine.height))
        bands.append(_means(surface, yarn_colours))
    return {name: np.concatenate([band[name] for band in bands]) for name in bands[0]}


def _means(surface: PixelSurface, yarn_colours: FloatArray) -> dict[str, FloatArray]:
    covered = surface.covered.astype(np.float64)
    opacity = _blocks(covered).mean(axis=2)
    count = np.maximum(_blocks(covered).sum(axis=2), 1.0)
    normal = _blocks(surface.normal).sum(axis=2)
    colour = np.where(surface.covered[:, :, None], yarn_colours[surface.yarn], 0.0)
    return {
        "opacity": opacity,
        "height": _blocks(surface.height).sum(axis=2) / count,
        "normal": normal / np.maximum(np.linalg.norm(normal, axis=2), 1e-12)[:, :, None],
        "colour": _blocks(colour).sum(axis=2) / count[:, :, None],
        "tangent": _tangents(surface),
    }


def _tangents(surface: PixelSurface) -> FloatArray:
    """Return the direction of the highest sample of each pixel, as yarns of opposite direction have no mean."""
    height = np.where(surface.covered, surface.height, -np.inf)
    highest = _blocks(height).argmax(axis=2)
    direction = _blocks(surface.direction)
    chosen = np.take_along_axis(direction, highest[:, :, None, None], axis=2)[:, :, 0]
    level = np.maximum(np.hypot(chosen[:, :, 0], chosen[:, :, 1]), 1e-12)
    return np.concatenate([chosen[:, :, :2] / level[:, :, None], chosen[:, :, 2:]], axis=2)


def _blocks(values: FloatArray) -> FloatArray:
    """Group the samples of each pixel: shape (rows * 2, columns * 2, ...) to (rows, columns, 4, ...)."""
    rows, columns = values.shape[0] // SAMPLES, values.shape[1] // SAMPLES
    split = values.reshape(rows, SAMPLES, columns, SAMPLES, *values.shape[2:])
    return split.swapaxes(1, 2).reshape(rows, columns, SAMPLES**2, *values.shape[2:])


def _light(relief: FloatArray, plan: PixelGrid, radius: float) -> FloatArray:
    """Return the fraction of light that reaches each point, from the depth of the point below its surroundings."""
    light = np.ones_like(relief)
    # Widths of the surroundings of a point in yarn radii, and the strength with which each one blocks light
    for width, strength in ((0.25, 2.0), (0.75, 1.0), (2.0, 0.5)):
        hollow = np.maximum(_smooth(relief, plan, width * radius) - relief, 0.0) / radius
        light /= 1.0 + strength * hollow
    return light


def _smooth(values: FloatArray, plan: PixelGrid, width: float) -> FloatArray:
    """Convolve a periodic map with a Gaussian of a standard deviation [cm], as a product of Fourier series."""
    wave = np.linalg.inv(plan.periods).T * 2 * np.pi
    row, column = np.fft.fftfreq(plan.height) * plan.height, np.fft.rfftfreq(plan.width) * plan.width
    x = column * wave[0, 0] + row[:, None] * wave[1, 0]
    y = column * wave[0, 1] + row[:, None] * wave[1, 1]
    gaussian = np.exp(-0.5 * width**2 * (x**2 + y**2))
    return np.fft.irfft2(np.fft.rfft2(values) * gaussian, s=values.shape)


def _srgb(linear: FloatArray, light: FloatArray, covered: NDArray[np.bool_]) -> FloatArray:
    """Return the sRGB of linear colours times the fraction of light, and their mean where there is no yarn."""
    lit = linear * light[:, :, None]
    mean = lit[covered].mean(axis=0) if covered.any() else np.zeros(3)
    return srgb_colour(np.where(covered[:, :, None], lit, mean))
