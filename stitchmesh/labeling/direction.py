# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The wale direction of each row.

Two neighbouring rows match at a common edge if the edge is a top side of one row and a bottom side of the other. For
each pair of rows the common course length counts as positive where the rows match and as negative where they do not.
Pairs are joined to a spanning forest in descending order of the absolute value, and each join fixes the relative
direction of two rows. Mismatches therefore remain at the shortest seams. Seeded rows keep the direction in which they
grew.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from stitchmesh.labeling.growth import COURSE, EdgeLabels
from stitchmesh.mesh import BORDER, IntArray, Mesh, StitchMesh
from stitchmesh.mesh.connectivity import ParityForest
from stitchmesh.mesh.stitch import Stitch

ROOT = -1
"""Additional node of the forest, to which all seeded rows are joined."""
DIGITS = 9
"""Decimal digits to which lengths [cm] are rounded before comparison; equally long seams may differ by rounding."""


def turned_rows(mesh: Mesh, labels: EdgeLabels, seeded: Iterable[int]) -> NDArray[np.bool_]:
    """Return whether the direction of each row must be reversed, shape (rows,).

    Args:
        mesh: the surface.
        labels: rows and edge labels of the surface, with the directions in which the rows grew.
        seeded: rows that keep their direction.
    """
    forest = ParityForest(labels.row_count + 1)
    for row in seeded:
        forest.join(ROOT, row, 0)
    for first, second, differ in _neighbours(mesh, labels):
        forest.join(first, second, differ)
    seed, seed_parity = forest.find(ROOT)
    found = [forest.find(row) for row in range(labels.row_count)]
    return np.array([parity ^ (seed_parity if root == seed else 0) for root, parity in found], dtype=bool)


def _neighbours(mesh: Mesh, labels: EdgeLabels) -> list[tuple[int, int, int]]:
    """Pairs of rows, and whether one of them must be reversed to match, in descending order of the matched length."""
    sides = seam_sides(mesh, labels)
    across = mesh.twin[sides]
    top, top_across = (is_top(mesh, some, labels.left_wale, labels.right_wale) for some in (sides, across))
    rows = np.sort([labels.row[mesh.side_face[sides]], labels.row[mesh.side_face[across]]], axis=0)
    pair, place = np.unique(rows[0] * labels.row_count + rows[1], return_inverse=True)
    sign = np.where(top == top_across, -1.0, 1.0)
    gain = np.round(np.bincount(place, sign * mesh.side_length[sides], minlength=len(pair)), DIGITS)
    order = np.lexsort((pair, -np.abs(gain)))
    first, second = np.divmod(pair[order], max(labels.row_count, 1))
    return list(zip(first.tolist(), second.tolist(), (gain[order] < 0).astype(int).tolist(), strict=True))


def seam_sides(mesh: Mesh, labels: EdgeLabels) -> IntArray:
    """Return one side of each course edge that joins faces of two different rows."""
    sides = mesh.edge_side[labels.edge_label == COURSE]
    sides = sides[mesh.twin[sides] != BORDER]
    first, second = labels.row[mesh.side_face[sides]], labels.row[mesh.side_face[mesh.twin[sides]]]
    return sides[(first != second) & (first >= 0) & (second >= 0)]


def is_top(mesh: Mesh, sides: IntArray, left: IntArray, right: IntArray) -> NDArray[np.bool_]:
    """Return whether course sides of labeled faces are top sides: they come after the right wale side, shape (n,).

    Args:
        mesh: the surface.
        sides: the sides, shape (n,).
        left: left wale side of each face, shape (F,).
        right: right wale side of each face, shape (F,).
    """
    faces = mesh.side_face[sides]
    size, first = mesh.face_start[faces + 1] - mesh.face_start[faces], left[faces]
    return (sides - first) % size > (right[faces] - first) % size


def in_knitting_frame(mesh: Mesh, left_wale: IntArray, right_wale: IntArray, row: IntArray) -> StitchMesh:
    """Return a stitch mesh of panels whose corners are rotated to start at the lower left.

    Args:
        mesh: the surface.
        left_wale: left wale side of each face, shape (F,).
        right_wale: right wale side of each face, shape (F,).
        row: row of each face, shape (F,).
    """
    sizes = np.diff(mesh.face_start)
    first = mesh.side_next[left_wale] - mesh.face_start[:-1]
    place = np.arange(mesh.side_count) - mesh.face_start[:-1][mesh.side_face]
    old = mesh.face_start[:-1][mesh.side_face] + (place + first[mesh.side_face]) % sizes[mesh.side_face]
    new = np.empty_like(old)
    new[old] = np.arange(mesh.side_count)
    twin = mesh.twin[old]
    n_bottom = (right_wale - mesh.side_next[left_wale]) % sizes
    return StitchMesh(
        vertices=mesh.vertices,
        face_start=mesh.face_start,
        face_vertex=mesh.face_vertex[old],
        twin=np.where(twin == BORDER, BORDER, new[twin]),
        lattice=mesh.lattice,
        corner_image=None if mesh.corner_image is None else mesh.corner_image[old],
        n_bottom=n_bottom,
        n_top=sizes - 2 - n_bottom,
        stitch=np.full(mesh.face_count, Stitch.PANEL),
        row=row,
    )
