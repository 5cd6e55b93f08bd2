# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Tubes, caps and closed surfaces of simple shape, of the size of garments."""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import FloatArray, Mesh

from .level_surface import Cloth, Opening
from .solids import Oval, along, ball, column, joined, ring, round_cone

UP, DOWN, RIGHT, LEFT = (0.0, 1.0, 0.0), (0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)


def cylinder(edge: float = 1.0) -> Mesh:
    """An upright tube of radius 6 and height 20, open at both ends."""
    solid = round_cone((0.0, -20.0, 0.0), (0.0, 40.0, 0.0), 6.0, 6.0)
    ends = [Opening((0.0, 20.0, 0.0), UP), Opening((0.0, 0.0, 0.0), DOWN)]
    return Cloth(solid, (-8.0, -2.0, -8.0), (8.0, 22.0, 8.0), ends).triangles(edge)


def frustum(edge: float = 1.0) -> Mesh:
    """A cone from radius 12 at the lower end to radius 3 at the upper one, 20 high, open at both ends."""
    solid = column([Oval(-5.0, 14.25, 14.25), Oval(25.0, 0.75, 0.75)])
    ends = [Opening((0.0, 20.0, 0.0), UP), Opening((0.0, 0.0, 0.0), DOWN)]
    return Cloth(solid, (-14.0, -2.0, -14.0), (14.0, 22.0, 14.0), ends).triangles(edge)


def closed_cone(edge: float = 1.0) -> Mesh:
    """A cone of radius 10.5 and height 24 with a rounded tip, open at the bottom."""

    def value(points: FloatArray) -> FloatArray:
        x, y, z = np.moveaxis(points, -1, 0)
        return (2.5 * np.sqrt(x**2 + z**2 + 1.0) + y - 26.5) / 2.7

    return Cloth(value, (-12.0, -2.0, -12.0), (12.0, 26.0, 12.0), [Opening((0.0, 0.0, 0.0), DOWN)]).triangles(edge)


def dome(edge: float = 1.0) -> Mesh:
    """A half of an upright ellipsoid of radius 9 and height 15, open at the bottom."""
    return Cloth(
        lambda points: 9.0 * (np.linalg.norm(points / np.array([9.0, 15.0, 9.0]), axis=-1) - 1.0),
        (-11.0, -2.0, -11.0), (11.0, 17.0, 11.0), [Opening((0.0, 0.0, 0.0), DOWN)],
    ).triangles(edge)  # fmt: skip


def sphere(edge: float = 1.0) -> Mesh:
    """A sphere of radius 8."""
    return Cloth(ball((0.0, 0.0, 0.0), 8.0), (-10.0, -10.0, -10.0), (10.0, 10.0, 10.0)).triangles(edge)


def torus(edge: float = 1.0) -> Mesh:
    """A torus that lies flat, with radii 12 and 4."""
    return Cloth(ring((0.0, 0.0, 0.0), 12.0, 4.0), (-18.0, -6.0, -18.0), (18.0, 6.0, 18.0)).triangles(edge)


def genus_2(edge: float = 1.0) -> Mesh:
    """A closed surface with two holes: two tori side by side that flow into one another."""
    solid = joined([ring((-11.0, 0.0, 0.0), 9.0, 3.5), ring((11.0, 0.0, 0.0), 9.0, 3.5)], 5.0)
    return Cloth(solid, (-25.0, -6.0, -15.0), (25.0, 6.0, 15.0)).triangles(edge)


def capsule(edge: float = 1.0) -> Mesh:
    """An upright tube of radius 6 with round ends, 32 high."""
    solid = round_cone((0.0, 6.0, 0.0), (0.0, 26.0, 0.0), 6.0, 6.0)
    return Cloth(solid, (-8.0, -2.0, -8.0), (8.0, 34.0, 8.0)).triangles(edge)


def arc(centre: tuple[float, float], radius: float, start: float, end: float) -> FloatArray:
    """Close points of a circle in the x-y plane between two angles [degrees], shape (n, 3)."""
    angle = np.radians(np.linspace(start, end, 400))
    x, y = centre[0] + radius * np.cos(angle), centre[1] + radius * np.sin(angle)
    return np.column_stack([x, y, np.zeros(len(angle))])


def straight(start: tuple[float, float], end: tuple[float, float]) -> FloatArray:
    """Close points of a line in the x-y plane, shape (n, 3)."""
    return np.linspace((*start, 0.0), (*end, 0.0), 400)


def bent_tube(edge: float = 1.0) -> Mesh:
    """A tube of radius 4 that turns by 90 degrees about a radius of 10, with straight ends of 8, open at both ends."""
    path = np.concatenate([
        straight((0.0, -6.0), (0.0, 8.0)), arc((10.0, 8.0), 10.0, 180.0, 90.0), straight((10.0, 18.0), (24.0, 18.0)),
    ])  # fmt: skip
    ends = [Opening((0.0, 0.0, 0.0), DOWN, 12.0), Opening((18.0, 18.0, 0.0), RIGHT, 12.0)]
    return Cloth(along(path, 4.0), (-6.0, -2.0, -6.0), (20.0, 24.0, 6.0), ends).triangles(edge)


def s_tube(edge: float = 1.0) -> Mesh:
    """A tube of radius 4 that turns by 90 degrees to the right and back, open at both ends."""
    path = np.concatenate([
        straight((0.0, -6.0), (0.0, 6.0)), arc((9.0, 6.0), 9.0, 180.0, 90.0),
        arc((9.0, 24.0), 9.0, -90.0, 0.0), straight((18.0, 24.0), (18.0, 36.0)),
    ])  # fmt: skip
    ends = [Opening((0.0, 0.0, 0.0), DOWN, 12.0), Opening((18.0, 30.0, 0.0), UP, 12.0)]
    return Cloth(along(path, 4.0), (-6.0, -2.0, -6.0), (24.0, 32.0, 6.0), ends).triangles(edge)


def t_junction(edge: float = 1.0) -> Mesh:
    """An upright tube of radius 4.5 that ends in the middle of a level one of radius 4; three open ends."""
    level = round_cone((-30.0, 22.0, 0.0), (30.0, 22.0, 0.0), 4.0, 4.0)
    upright = round_cone((0.0, -8.0, 0.0), (0.0, 17.0, 0.0), 4.6, 4.2)
    ends = [Opening((-18.0, 22.0, 0.0), LEFT), Opening((18.0, 22.0, 0.0), RIGHT), Opening((0.0, 0.0, 0.0), DOWN)]
    return Cloth(joined([level, upright], 5.0), (-20.0, -2.0, -8.0), (20.0, 30.0, 8.0), ends).triangles(edge)


def y_junction(edge: float = 1.0) -> Mesh:
    """An upright tube of radius 6 that divides into two of radius 4; three open ends."""
    stem = round_cone((0.0, -8.0, 0.0), (0.0, 16.0, 0.0), 6.0, 5.5)
    branches = [round_cone((0.0, 15.0, 0.0), (side * 18.0, 40.0, 0.0), 4.5, 4.0) for side in (-1.0, 1.0)]
    ends = [Opening((side * 12.96, 33.0, 0.0), (side * 18.0, 25.0, 0.0), 18.0) for side in (-1.0, 1.0)]
    ends.append(Opening((0.0, 0.0, 0.0), DOWN))
    return Cloth(joined([*branches, stem], 5.0), (-24.0, -2.0, -8.0), (24.0, 42.0, 8.0), ends).triangles(edge)


SIMPLE = (
    cylinder, frustum, closed_cone, dome, sphere, torus, bent_tube, s_tube, t_junction, y_junction, genus_2, capsule,
)  # fmt: skip
