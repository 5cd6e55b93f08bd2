# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Whether a mesh is inside out, and the same mesh turned.

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

from stitchmesh.mesh.polygon_mesh import BORDER, FloatArray, Mesh

SAMPLES = 64
"""Number of points of the surface at which the winding number is evaluated."""
INSIDE_OUT = -0.15
"""Mean winding number below which a mesh is inside out. A part of a tube reaches it if it goes round by 108 degrees."""


def mean_winding_number(mesh: Mesh) -> float:
    """Return the mean winding number of a surface over the surface, from -1/2 to 1/2.

    The mean is taken over the centres of faces at equal steps of area. Each face is replaced by a dipole at its centre,
    which is exact for distant faces; the faces around a centre lie close to its plane and contribute little.

    Args:
        mesh: the mesh; a periodic mesh has no inside, and its number is 0.
    """
    if mesh.lattice is not None:
        return 0.0
    area = mesh.face_vector_area
    centre = np.add.reduceat(mesh.corner_position, mesh.face_start[:-1], axis=0) / np.diff(mesh.face_start)[:, None]
    covered = np.cumsum(np.linalg.norm(area, axis=1))
    steps = (np.arange(SAMPLES) + 0.5) / SAMPLES * covered[-1]
    chosen = np.minimum(np.searchsorted(covered, steps), mesh.face_count - 1)
    return float(np.mean([_winding_number(centre - centre[face], area) for face in chosen]))


def _winding_number(offset: FloatArray, area: FloatArray) -> float:
    """Winding number of dipoles [cm^2], shape (F, 3), at offsets from a point [cm], shape (F, 3)."""
    distance = np.sqrt(np.einsum("fi,fi->f", offset, offset))
    distance[distance == 0.0] = np.inf
    return float(np.sum(np.einsum("fi,fi->f", offset, area) / distance**3)) / (4.0 * np.pi)


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
