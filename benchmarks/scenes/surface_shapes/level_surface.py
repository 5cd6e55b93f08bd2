# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The surface of a solid as triangles of about one size, with openings that are cut by planes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pyvista

from stitchmesh.mesh import FloatArray, IntArray, Mesh

from .even_triangles import Surface, evened
from .solids import Point, Shape

SHEAR = np.array([0.23, 0.0, 0.14])
"""Rise of the level planes of a lattice along its other axes."""
WAVE, WAVE_LENGTH = 2.5, 7.0
"""Height and length of the waves of the upright planes of a lattice, in cells; the length is that of one radian."""
STEP = 1e-4
"""Step of differences [cm]."""
TETRAHEDRON = np.array([[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]])
"""Directions of the corners of a tetrahedron."""


@dataclass(frozen=True)
class Opening:
    """A plane that cuts a limb off."""

    centre: Point
    """Middle of the opening [cm]."""
    outwards: Point
    """Normal of the plane; what is on this side is cut off."""
    reach: float = 1e4
    """Nothing is cut off at a greater distance from the centre [cm]."""

    def kept(self, points: FloatArray) -> FloatArray:
        """A function that is positive at what is not cut off, shape (..., 3) to (...)."""
        away = points - np.array(self.centre)
        behind = -away @ (np.array(self.outwards) / np.linalg.norm(self.outwards))
        return np.maximum(behind, np.linalg.norm(away, axis=-1) - self.reach)


@dataclass(frozen=True)
class Gap:
    """The opening between the two fronts of a garment, from its hem to its neck."""

    width: float
    """Distance between the fronts [cm]."""

    def kept(self, points: FloatArray) -> FloatArray:
        """A function that is positive at what is not cut off, shape (..., 3) to (...)."""
        return np.maximum(np.abs(points[..., 0]) - 0.5 * self.width, -points[..., 2])


@dataclass(frozen=True)
class Wedge:
    """A V-neck: the opening in front between two slanting lines that meet in a foot."""

    foot: float
    """Height of the foot [cm]."""
    slope: float
    """Half of the width over the height above the foot."""

    def kept(self, points: FloatArray) -> FloatArray:
        """A function that is positive at what is not cut off, shape (..., 3) to (...)."""
        above = points[..., 1] - self.foot
        return np.maximum(np.abs(points[..., 0]) - self.slope * above, -points[..., 2])


@dataclass(frozen=True)
class Straps:
    """The opening above a level, between and beside two straps over the shoulders."""

    height: float
    """Height of the upper border between the straps [cm]."""
    middle: float
    """Distance of the middle of a strap from the plane x = 0 [cm]."""
    width: float
    """Width of a strap [cm]."""

    def kept(self, points: FloatArray) -> FloatArray:
        """A function that is positive at what is not cut off, shape (..., 3) to (...)."""
        beside = np.abs(np.abs(points[..., 0]) - self.middle)
        return np.maximum(self.height - points[..., 1], 0.5 * self.width - beside)


@dataclass(frozen=True)
class LegOpenings:
    """The two openings below slanting lines, with a crotch between them."""

    height: float
    """Height of the lines beside the crotch [cm]."""
    crotch: float
    """Width of the crotch [cm]."""
    slope: float
    """Height over width of the lines."""

    def kept(self, points: FloatArray) -> FloatArray:
        """A function that is positive at what is not cut off, shape (..., 3) to (...)."""
        beside = np.maximum(np.abs(points[..., 0]) - 0.5 * self.crotch, 0.0)
        return points[..., 1] - self.height - self.slope * beside


@dataclass(frozen=True)
class Cloth:
    """The surface of a solid in a box, less what openings cut off."""

    solid: Shape
    low: Point
    """Lower corner of the box [cm]."""
    high: Point
    """Upper corner of the box [cm]."""
    openings: Sequence[Opening | Gap | Wedge | Straps | LegOpenings] = ()
    cell: float = 1.15
    """Side of the cells of the lattice, in parts of an edge; narrow gaps need a smaller one."""

    def triangles(self, edge: float) -> Mesh:
        """Return a mesh of triangles with edges of about this length [cm]."""
        surface = _contour(self, edge)
        for opening in self.openings:
            surface["kept"] = opening.kept(np.asarray(surface.points))
            surface = surface.clip_scalar(scalars="kept", invert=False, value=0.0).triangulate()
        points, corners = np.asarray(surface.points, dtype=np.float64), surface.faces.reshape(-1, 4)[:, 1:]
        onto = Surface(self._normals, self._onto, self._onto_border)
        return triangle_mesh(*evened(points, _outwards(points, corners, onto), edge, onto))

    def _normals(self, points: FloatArray) -> FloatArray:
        slope = _slope(self.solid, points)[1]
        return slope / np.linalg.norm(slope, axis=1, keepdims=True)

    def _onto(self, points: FloatArray) -> FloatArray:
        return _newton(self.solid, points)

    def _onto_border(self, points: FloatArray) -> FloatArray:
        if not len(points):
            return points
        nearest = np.argmin([np.abs(opening.kept(points)) for opening in self.openings], axis=0)
        for _ in range(3):
            points = self._onto(points)
            for number, opening in enumerate(self.openings):
                points[nearest == number] = _newton(opening.kept, points[nearest == number])
        return points


def triangle_mesh(points: FloatArray, corners: IntArray) -> Mesh:
    """Return a mesh of triangles, shape (m, 3)."""
    return Mesh.from_polygons(points, corners.tolist())


def _contour(cloth: Cloth, edge: float) -> pyvista.PolyData:
    """Return the surface of the solid, cut out of a bent lattice."""
    cell, wave = cloth.cell * edge, np.array([WAVE, 0.0, WAVE])
    low, high = np.array(cloth.low) / cell - wave, np.array(cloth.high) / cell + wave
    low[1] -= SHEAR @ (high - low)
    lattice = pyvista.ImageData(dimensions=np.ceil(high - low).astype(int) + 1)
    lattice["value"] = cloth.solid(cell * (low + bent(np.asarray(lattice.points))))
    surface = lattice.contour([0.0], scalars="value")
    surface.points = cell * (low + bent(np.asarray(surface.points, dtype=np.float64)))
    return surface


def bent(points: FloatArray) -> FloatArray:
    """Points of a lattice moved so that its planes follow neither levels nor walls, in cells, shape (n, 3)."""
    x, y, z = points.T
    turn = y / WAVE_LENGTH
    return np.column_stack([x + WAVE * np.sin(turn), y + points @ SHEAR, z + WAVE * np.cos(turn)])


def _outwards(points: FloatArray, corners: IntArray, onto: Surface) -> IntArray:
    """Return triangles turned so that most of them face outwards."""
    a, b, c = (points[column] for column in corners.T)
    facing = (np.cross(b - a, c - a) * onto.normals((a + b + c) / 3.0)).sum()
    return corners if facing > 0.0 else corners[:, ::-1]


def _slope(function: Shape, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the values of a function at points and its slopes, from the corners of small tetrahedra around them."""
    values = np.stack([function(points + STEP * corner) for corner in TETRAHEDRON], axis=-1)
    return values.mean(axis=-1), values @ TETRAHEDRON / (4.0 * STEP)


def _newton(function: Shape, points: FloatArray) -> FloatArray:
    """Move points to the zero of a function along its slope by one step."""
    value, slope = _slope(function, points)
    return points - (value / np.maximum((slope**2).sum(axis=1), 1e-9))[:, None] * slope
