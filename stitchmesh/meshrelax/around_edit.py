# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Mesh relaxation of the stitches around an edit, while all others stay exactly where they are.

The stitches that do not move keep their relaxed yarns, from which the yarns of the edited fabric can be relaxed.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from stitchmesh.mesh import BORDER, FloatArray, IntArray, Mesh, StitchMesh
from stitchmesh.meshrelax.relax import RelaxedMesh, relax_mesh

RINGS = 6
"""Rings of stitches around the changed ones that also move. An inserted row then takes its height from 14 rows."""


def relax_mesh_around_edit(
    before: StitchMesh, after: StitchMesh, *, surface: Mesh | None = None, device: str | None = "cpu"
) -> RelaxedMesh:
    """Relax the stitches that an edit has changed, and those around them; all other vertices stay where they are.

    Args:
        before: relaxed stitch mesh before the edit.
        after: the stitch mesh after the edit.
        surface: the mesh of the garment; the surface of ``before`` if None.
        device: Warp's name of the device that finds closest points; None for the preferred device.

    Raises:
        MeshError: ``relax_mesh`` refuses the fabric or the surface.
        SolverError: ``relax_mesh`` cannot continue.
    """
    moving = vertices_around(after, changed_faces(before, after), RINGS)
    return relax_mesh(after, surface=before if surface is None else surface, moving=moving, device=device)


def changed_faces(before: StitchMesh, after: StitchMesh) -> IntArray:
    """Return the faces after an edit that are new or differ in their sides or their border sides, ascending."""
    tree = cKDTree(_centres(before))
    # Distance of coinciding points, divided by the size of the fabric.
    within = 1e-9 * float(np.ptp(before.vertices, axis=0).max())
    distance, same = tree.query(_centres(after), distance_upper_bound=within)
    found = np.isfinite(distance)
    sides = np.diff(after.face_start)
    found[found] &= np.diff(before.face_start)[same[found]] == sides[found]
    found[found] &= _border_sides(before)[same[found]] == _border_sides(after)[found]
    return np.flatnonzero(~found)


def vertices_around(fabric: StitchMesh, faces: IntArray, rings: int) -> NDArray[np.bool_]:
    """Return whether each vertex belongs to ``faces`` or to the ``rings`` rings of faces around them, shape (V,)."""
    chosen = np.zeros(len(fabric.vertices), dtype=bool)
    chosen[fabric.face_vertex[fabric.sides_of(faces)]] = True
    for _ in range(rings):
        touched = np.zeros(fabric.face_count, dtype=bool)
        touched[fabric.side_face[chosen[fabric.face_vertex]]] = True
        chosen[fabric.face_vertex[touched[fabric.side_face]]] = True
    return chosen


def _centres(fabric: StitchMesh) -> FloatArray:
    """Mean of the corners of each face [cm], shape (F, 3)."""
    total = np.add.reduceat(fabric.corner_position, fabric.face_start[:-1], axis=0)
    centres: FloatArray = total / np.diff(fabric.face_start)[:, None]
    return centres


def _border_sides(fabric: StitchMesh) -> IntArray:
    """Number of sides of each face that lie on a border, shape (F,)."""
    return np.bincount(fabric.side_face[fabric.twin == BORDER], minlength=fabric.face_count)
