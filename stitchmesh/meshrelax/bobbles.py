# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Bobbles in mesh relaxation: they stand off the surface, and each counts as one stitch.

A bobble has five faces or more in the place of one stitch. The lower face makes several loops, a short row is worked
back over them, and the upper face takes them together. Only the bottom and top sides of the short row are joined to
these two faces. Beside each end of the short row there is a slit, a border of two wale sides that matches no border of
the surface. The surface has no room for these stitches. Therefore the relaxation leaves out the vertices of the short
row, and forces act on the four corners of the bobble as if it were a plain stitch. Afterwards the vertices follow the
corners. Each vertex keeps its place in the width, the height and the normal direction of the bobble, in widths.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.courses import bottom_sides, course_through, top_sides
from stitchmesh.mesh.turns import SLIT_SIDES


@dataclass(frozen=True, eq=False)
class Bobbles:
    """The bobbles of a fabric."""

    faces: IntArray
    """All faces of all bobbles, shape (n,)."""
    corners: IntArray
    """Lower left, lower right, upper right and upper left vertex of each bobble, shape (B, 4)."""
    raised: IntArray
    """Vertices that stand off the surface, shape (m,)."""
    owner: IntArray
    """Bobble of each raised vertex, shape (m,)."""

    @property
    def count(self) -> int:
        """Number of bobbles."""
        return len(self.corners)

    def is_raised(self, vertex_count: int) -> NDArray[np.bool_]:
        """Return whether each vertex of the fabric stands off the surface, shape (V,)."""
        return np.isin(np.arange(vertex_count), self.raised)


NO_BOBBLES = Bobbles(np.zeros(0, int), np.zeros((0, 4), int), np.zeros(0, int), np.zeros(0, int))


def find_bobbles(fabric: StitchMesh) -> Bobbles:
    """Find the bobbles of a fabric by their slits."""
    faces: list[int] = []
    corners: list[list[int]] = []
    raised: list[int] = []
    owner: list[int] = []
    slits = {int(side): loop for loop in fabric.boundary_loops if len(loop) == SLIT_SIDES for side in loop}
    for side, slit in slits.items():
        short_row = fabric.side_face[side]
        upper = int(fabric.side_face[slit[slit != side][0]]) if fabric.left_wale[short_row] == side else -1
        found = _bobble(fabric, int(short_row), upper, slits) if upper >= 0 else None
        if found is not None:
            own_faces, own_corners = found
            inner = np.unique(fabric.face_vertex[fabric.sides_of(np.array(own_faces[2:]))])
            own_raised = inner[~np.isin(inner, own_corners)]
            owner += [len(corners)] * len(own_raised)
            faces, raised = faces + own_faces, raised + own_raised.tolist()
            corners.append(own_corners)
    numbers = (np.array(part, dtype=np.int64) for part in (faces, corners, raised, owner))
    all_faces, all_corners, all_raised, all_owners = numbers
    return Bobbles(all_faces, all_corners.reshape(-1, 4), all_raised, all_owners)


def _bobble(
    fabric: StitchMesh, first: int, upper: int, slits: dict[int, IntArray]
) -> tuple[list[int], list[int]] | None:
    """Return the faces and the corners of the bobble whose short row starts with a face, or None if it is no bobble.

    Args:
        fabric: stitch mesh.
        first: the leftmost face of the short row.
        upper: the face at the other side of the left slit.
        slits: the slit of each border side, as the sides of its border.
    """
    course = course_through(fabric, first)
    end = int(fabric.right_wale[course.faces[-1]])
    if course.closed or end not in slits:
        return None
    lower = int(fabric.side_face[slits[end][slits[end] != end][0]])
    below = fabric.side_face[fabric.twin[bottom_sides(fabric, course.faces)]]
    above = fabric.side_face[fabric.twin[top_sides(fabric, course.faces)]]
    if not ((below == lower).all() and (above == upper).all()):
        return None
    corner = fabric.face_vertex
    left, right = fabric.left_wale, fabric.right_wale
    lower_left, lower_right = corner[fabric.face_start[lower]], corner[right[lower]]
    upper_right, upper_left = corner[right[upper] + 1], corner[left[upper]]
    return [lower, upper, *course.faces], [int(v) for v in (lower_left, lower_right, upper_right, upper_left)]


def carried(bobbles: Bobbles, before: FloatArray, after: FloatArray) -> FloatArray:
    """Return the positions of the raised vertices after the corners of their bobbles have moved [cm], shape (m, 3).

    Args:
        bobbles: the bobbles.
        before: positions of all vertices before the relaxation [cm], shape (V, 3).
        after: positions of all vertices after it [cm], shape (V, 3); the positions of raised vertices are not read.
    """
    if bobbles.count == 0:
        return np.zeros((0, 3))
    (old_centre, old_axes), (new_centre, new_axes) = _frames(before[bobbles.corners]), _frames(after[bobbles.corners])
    own = bobbles.owner
    place = np.linalg.solve(old_axes[own], (before[bobbles.raised] - old_centre[own])[:, :, None])
    moved: FloatArray = new_centre[own] + (new_axes[own] @ place)[:, :, 0]
    return moved


def _frames(corners: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the centre [cm], shape (B, 3), and the axes of each bobble as columns, shape (B, 3, 3).

    The axes are its width, its height, and its normal with the length of the width.

    Args:
        corners: lower left, lower right, upper right and upper left corners [cm], shape (B, 4, 3).
    """
    width = 0.5 * (corners[:, 1] - corners[:, 0] + corners[:, 2] - corners[:, 3])
    height = 0.5 * (corners[:, 3] - corners[:, 0] + corners[:, 2] - corners[:, 1])
    normal = np.cross(width, height)
    scale = np.linalg.norm(width, axis=1, keepdims=True) / np.linalg.norm(normal, axis=1, keepdims=True)
    return corners.mean(axis=1), np.stack([width, height, normal * scale], axis=2)
