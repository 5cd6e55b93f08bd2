# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The direction of a mesh that points up, and the mesh turned so that this direction is y.

Everywhere in the program y points up. Modelling programs, CAD and scanners also write files in which z points up. The
openings of a garment show which axis it is: hem, neck, waist and cuffs of a standing wearer lie more or less level, so
that the vector areas of their borders, half the sum of p_i x p_(i+1) over the border, point up or down. A garment also
has a left and a right side that mirror each other, across a plane that contains the vertical. A mesh is therefore
lying, with z up, if its openings face along z far more than along y, and if it mirrors itself across z no better than
across x or y. Flat pieces and meshes without openings show nothing, and neither does the coat of a sheep, which has
openings along both axes.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.mesh.polygon_mesh import FloatArray, Mesh

Direction = tuple[float, float, float]
"""A direction in space."""
Y, Z = (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
"""The direction that points up in the program, and the other usual direction."""
MOST_POINTS = 2000
"""Largest number of vertices whose mirror images are looked for."""


def upright_turn(up: Direction) -> FloatArray:
    """Return the rotation by the shortest way that brings a direction to y; points are columns, shape (3, 3).

    For z it is exactly (x, y, z) -> (x, z, -y), as between the axes of Blender and of glTF. A direction that points
    down is first turned around z by half a turn.

    Args:
        up: the direction, of any length.

    Raises:
        ParameterError: the direction is zero or not finite.

    Source: Moeller and Hughes, *Efficiently building a matrix to rotate one vector to another* (1999), equation 3.
    """
    given = np.asarray(up, dtype=np.float64)
    if given.shape != (3,) or not np.isfinite(given).all() or not given.any():
        raise ParameterError(f"up: got {up}; expected three finite numbers that are not all zero")
    half = np.diag([-1.0, -1.0, 1.0]) if given[1] < 0.0 else np.eye(3)
    x, y, z = half @ given / np.linalg.norm(given)
    v = np.array([-z, 0.0, x])  # The cross product of the direction and y.
    cross = np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
    turn: FloatArray = (np.eye(3) + cross + cross @ cross / (1.0 + y)) @ half
    return turn


def turned_upright(mesh: Mesh, up: Direction) -> Mesh:
    """Return a mesh turned so that one of its directions becomes y; a mesh whose y points up is returned as it is.

    Raises:
        ParameterError: as for ``upright_turn``.
    """
    turn = upright_turn(up)
    return mesh if np.array_equal(turn, np.eye(3)) else replace(mesh, vertices=mesh.vertices @ turn.T)


def up_of_openings(mesh: Mesh) -> Direction | None:
    """Return the direction, y or z, along which the openings of a garment face; y if it has none.

    Args:
        mesh: a mesh without a lattice.

    Returns:
        The direction; None if the openings face more along z than along y, but not clearly.
    """
    loops = [mesh.corner_position[sides] for sides in mesh.boundary_loops]
    faces = mesh.face_vector_area
    # A mesh is a flat or open piece, whose border is no opening, if the length of the sum of all vector areas is
    # at least this multiple of the area. The ratio is 1 for a flat piece, 1/2 for half a sphere and less for a
    # hat.
    if not loops or np.linalg.norm(faces.sum(axis=0)) >= 0.6 * np.linalg.norm(faces, axis=1).sum():
        return Y
    openings = np.abs([0.5 * np.cross(loop, np.roll(loop, -1, axis=0)).sum(axis=0) for loop in loops]).sum(axis=0)
    if openings[1] >= openings[2]:
        return Y
    # z is up if the vector area of openings along z is at least this multiple of the area along y. The ratio is 6
    # for the coat of a sheep that stands, and 12 or more for a sweater, a dress and a skirt that lie.
    if openings[2] < 8.0 * openings[1]:
        return None
    across_x, across_y, across_z = (_distance_to_image(mesh.vertices, axis) for axis in range(3))
    return Z if min(across_x, across_y) <= across_z + mesh.rounding else None


def _distance_to_image(points: FloatArray, axis: int) -> float:
    """Return the mean distance of points from their mirror image across the middle plane of an axis [cm]."""
    from scipy.spatial import cKDTree

    image = points.copy()
    image[:, axis] = points[:, axis].min() + points[:, axis].max() - points[:, axis]
    step = -(-len(points) // MOST_POINTS)
    return float(np.mean(cKDTree(image).query(points[::step])[0]))
