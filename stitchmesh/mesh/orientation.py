# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The test whether a mesh is inside out, and the mesh with all faces reversed.

The winding number of a surface at a point is the solid angle of the surface as seen from the point, divided by the
whole sphere. Averaged over the surface itself it is 1/2 for a closed surface with outward normals, -1/2 for a closed
surface that is inside out, and 0 for a flat piece. Openings reduce the absolute value: it is 1/4 for half a long tube.
The measure needs no closed surface, and folds and thin parts do not disturb it. Source of the winding number of open
surfaces: Jacobson, Kavan and Sorkine-Hornung, *Robust inside-outside segmentation using generalized winding numbers*
(2013).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stitchmesh.mesh.polygon_mesh import BORDER, FloatArray, IntArray, Mesh

SAMPLES = 64
"""Number of points of the surface at which the winding number is evaluated."""
INSIDE_OUT = -0.15
"""Mean winding number below which a mesh is inside out. A part of a tube reaches it if it goes round by 108 degrees."""


def mean_winding_number(mesh: Mesh) -> float:
    """Return the mean winding number of a surface over the surface, from -1/2 to 1/2.

    The mean is taken over the centres of faces at equal steps of area. The solid angle of a near face is exact; a
    distant face is replaced by a dipole at its centre.

    Args:
        mesh: the mesh; a periodic mesh has no inside, and its number is 0.

    Source of the solid angle of a triangle: van Oosterom and Strackee 1983, equation 8.
    """
    if mesh.lattice is not None:
        return 0.0
    corner, area, start = mesh.corner_position, mesh.face_vector_area, mesh.face_start[:-1]
    centre = np.add.reduceat(corner, start, axis=0) / np.diff(mesh.face_start)[:, None]
    # A face is near up to four times the distance from its centre to its farthest corner.
    reach = 4.0 * np.sqrt(np.maximum.reduceat(np.sum((corner - centre[mesh.side_face]) ** 2, axis=1), start))
    covered = np.cumsum(np.linalg.norm(area, axis=1))
    steps = (np.arange(SAMPLES) + 0.5) / SAMPLES * covered[-1]
    total = 0.0
    for face in np.minimum(np.searchsorted(covered, steps), mesh.face_count - 1):
        offset = centre - centre[face]
        distance = np.sqrt(np.einsum("fi,fi->f", offset, offset))
        near = distance < reach
        distance[near] = np.inf
        total += float(np.sum(np.einsum("fi,fi->f", offset, area) / distance**3))
        near[face] = False  # From its own centre, half of the directions meet either side of a face.
        total += _solid_angle(mesh, np.flatnonzero(near), centre, centre[face])
    return total / (4.0 * np.pi * SAMPLES)


def _solid_angle(mesh: Mesh, faces: IntArray, centre: FloatArray, point: FloatArray) -> float:
    """Solid angle of some faces as seen from a point, positive from inside.

    Args:
        mesh: the mesh.
        faces: numbers of the faces, each of which is divided into triangles around its centre.
        centre: centre of each face of the mesh [cm], shape (F, 3).
        point: the point [cm], shape (3,).
    """
    sides = mesh.sides_of(faces)
    corners = (centre[mesh.side_face[sides]], mesh.corner_position[sides], mesh.corner_position[mesh.side_next[sides]])
    a, b, c = (corner - point for corner in corners)
    la, lb, lc = (np.sqrt(np.einsum("si,si->s", v, v)) for v in (a, b, c))
    volume = np.einsum("si,si->s", a, np.cross(b, c))
    ab, bc, ca = (np.einsum("si,si->s", v, w) for v, w in ((a, b), (b, c), (c, a)))
    return float(np.sum(2.0 * np.arctan2(volume, la * lb * lc + ab * lc + bc * la + ca * lb)))


def is_inside_out(mesh: Mesh) -> bool:
    """Return whether the faces of a mesh point to its inside, so that its purl side would be outside.

    Flat and slightly curved pieces have no inside, and the result is False.
    """
    return mean_winding_number(mesh) < INSIDE_OUT


def turn_inside_out(mesh: Mesh) -> Mesh:
    """Return the mesh with every face reversed, so that its other side is outside.

    Vertices, faces and edges keep their positions, and vertices and faces keep their numbers. The first corner of each
    face stays its first corner.

    Args:
        mesh: the mesh.
    """
    size = np.diff(mesh.face_start)[mesh.side_face]
    start = mesh.face_start[:-1][mesh.side_face]
    place = np.arange(mesh.side_count) - start
    corner = start + (size - place) % size  # The corner that is at each place of the reversed face.
    side = start + (size - 1 - place)  # The side that is at each place of the reversed face.
    twin = mesh.twin[side]
    return replace(
        mesh,
        face_vertex=mesh.face_vertex[corner],
        twin=np.where(twin == BORDER, BORDER, side[np.where(twin == BORDER, 0, twin)]),
        corner_image=None if mesh.corner_image is None else mesh.corner_image[corner],
    )
