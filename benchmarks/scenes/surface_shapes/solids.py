# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Solids as functions of space, negative inside: those of the body of the project, and some more."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.spatial import cKDTree

from benchmarks.places import MESHES
from stitchmesh.mesh import FloatArray

sys.path.append(str(MESHES))
smooth_shapes = import_module("smooth_shapes")
Shape, Point = smooth_shapes.Shape, smooth_shapes.Point
round_cone, joined = smooth_shapes.round_cone, smooth_shapes.joined

FINE = 400
"""Entries of the tables in which smooth curves are looked up."""


def ball(centre: Point, radius: float) -> Shape:
    """A ball."""
    return lambda points: np.linalg.norm(points - np.array(centre), axis=-1) - radius


def ring(centre: Point, radius: float, thickness: float) -> Shape:
    """A solid torus that lies flat: radius of its middle line, and radius of its section."""

    def value(points: FloatArray) -> FloatArray:
        x, y, z = np.moveaxis(points - np.array(centre), -1, 0)
        return np.hypot(np.hypot(x, z) - radius, y) - thickness

    return value


def along(path: FloatArray, radius: float) -> Shape:
    """A round tube along a smooth line of close points, shape (n, 3)."""
    tree = cKDTree(path)
    return lambda points: tree.query(points)[0] - radius


@dataclass(frozen=True)
class Oval:
    """A level section of a column [cm]."""

    height: float
    width: float
    """Half of the width in x."""
    depth: float
    """Half of the depth in z."""
    z: float = 0.0
    """Middle in z."""
    x: float = 0.0
    """Middle in x."""


def column(ovals: Sequence[Oval], rounding: float = 0.0) -> Shape:
    """A stack of ovals, from the bottom up, along smooth curves; the lower end is rounded within a length [cm]."""
    height, *sizes = np.array([(oval.height, oval.width, oval.depth, oval.x, oval.z) for oval in ovals]).T
    table = np.linspace(height[0], height[-1], FINE)
    curves = [PchipInterpolator(height, size)(table) for size in sizes]

    def value(points: FloatArray) -> FloatArray:
        x, y, z = np.moveaxis(points, -1, 0)
        a, b, middle_x, middle_z = (np.interp(y, table, curve) for curve in curves)
        across = np.minimum(a, b) * (np.hypot((x - middle_x) / a, (z - middle_z) / b) - 1.0)
        return np.maximum(rounded_both(across, height[0] - y, rounding), y - height[-1])

    return value


def rounded_both(one: FloatArray, other: FloatArray, rounding: float) -> FloatArray:
    """What two shapes have in common, with an edge that is rounded within a length."""
    if rounding == 0.0:
        return np.maximum(one, other)
    near = np.maximum(rounding - np.abs(one - other), 0.0) / rounding
    return np.maximum(one, other) + 0.25 * rounding * near**2


def flattened(shape: Shape, factor: float) -> Shape:
    """A shape whose depth in z is divided by a factor."""
    return lambda points: shape(points * np.array([1.0, 1.0, factor]))


def reflected(shape: Shape) -> Shape:
    """The mirror image in x of a shape."""
    return lambda points: shape(points * np.array([-1.0, 1.0, 1.0]))


def both_sides(*shapes: Shape) -> list[Shape]:
    """Some shapes and their mirror images."""
    return [*shapes, *(reflected(shape) for shape in shapes)]
