# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Tension at the edges of a fabric: a knitter works first and last rows, and ribs at edges, with shorter loops.

Backward loops and the loops of a chain are drawn as high as plain stitches, and nothing pulls them together. If they
had the drawn lengths at rest, they would hang loosely. A rib at an edge is worked on a needle that is two sizes
smaller, such as 4.0 mm in the place of 4.5 mm, which shortens its loops by a tenth. A rib that covers the whole fabric
keeps the size of its loops.

Where a first or last row is drawn out, as at its ends beside a corner of the fabric, its loops are drawn longer than
others. A knitter does not work them so: no loop is drawn more than ``LONGEST`` times the median of its row.

In decreases and increases too, a knitter works the same length of yarn into every loop. A decrease holds two or three
loops of the row below in the place of one stitch, and its face is wider than that of a plain stitch. Its drawing
therefore contains more yarn than a knitter works into it: the heads of the loops that it holds and the feet and legs of
its own loop are up to half longer than those of plain stitches. If it had these lengths at rest, a decrease would stand
out as a lump.

Each head in a decrease or an increase, and the feet and legs of a decrease, therefore get another rest length: the mean
drawn length of the same parts in the plain stitches of the row, or of the whole fabric if the row has few, times
``HELD``. It is never longer than the drawn length.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import BORDER, BOTTOM, TOP, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.arrays import distinct_rows
from stitchmesh.mesh.connectivity import linked_groups
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.yarngen.embedding import PlacedParts
from stitchmesh.yarngen.templates.edge_templates import Edge

CAST_ON, CHAIN, RIB = 0.7, 0.9, 0.9
"""Rest length over drawn length of the yarn in backward loops of a first row, in a chain, and in a rib at an edge."""
LONGEST = 1.1
"""Longest loop of a first or last row over the median of its row; longer ones are shortened to it."""
PLAIN = (Stitch.KNIT, Stitch.PURL)
EDGES = (Stitch.CAST_ON, Stitch.BIND_OFF)
"""Stitches of first and last rows."""
HELD = 1.05
"""Length of the yarn in a decrease, divided by the length in a plain stitch, because it lies around several loops."""
SHORTEST_RATIO = 0.6
"""Smallest rest length divided by drawn length; the relaxation starts from a strain of at most two thirds."""


def edge_tension(fabric: StitchMesh, edge: IntArray, parts: PlacedParts) -> FloatArray:
    """Return the rest length of the yarn in each face over its length without tension, shape (F,).

    Args:
        fabric: the stitch mesh with its bind-off row.
        edge: template of each face of a first or last row (``Edge``), shape (F,).
        parts: the yarn parts of the fabric.
    """
    tension = np.ones(fabric.face_count)
    if not np.isin(fabric.stitch, EDGES).any():
        return tension
    tension[_edge_rib_rows(fabric)[fabric.row]] = RIB
    cast_on = (fabric.stitch == Stitch.CAST_ON) & (edge == Edge.BY_STITCH)
    for faces, value in ((cast_on, CAST_ON), (edge >= Edge.CHAIN, CHAIN)):
        tension[faces] = value * _share_of_long_loops(fabric, np.flatnonzero(faces), parts)
    return tension


def _share_of_long_loops(fabric: StitchMesh, faces: IntArray, parts: PlacedParts) -> FloatArray:
    """Return the share of its yarn that each face keeps, so that no loop is too long for its row, shape (n,)."""
    drawn: FloatArray = np.bincount(parts.face, parts.lengths, fabric.face_count)[faces] / np.maximum(
        fabric.n_bottom[faces], fabric.n_top[faces]
    )
    share = np.ones(len(faces))
    for row in np.unique(fabric.row[faces]):
        own = fabric.row[faces] == row
        share[own] = np.clip(LONGEST * np.median(drawn[own]) / drawn[own], SHORTEST_RATIO, 1.0)
    return share


def _edge_rib_rows(fabric: StitchMesh) -> NDArray[np.bool_]:
    """Whether each row belongs to a rib between a first or last row and other stitches, shape (rows,)."""
    rows = int(fabric.row.max()) + 1
    knit, purl = (np.bincount(fabric.row[fabric.stitch == stitch], minlength=rows) for stitch in PLAIN)
    # In a row of rib, at least this part of the plain stitches is knit, and at least this part is purl.
    both = np.minimum(knit, purl) >= np.maximum(0.2 * (knit + purl), 1)
    sides = np.flatnonzero((fabric.twin != BORDER) & (fabric.side_role == TOP) & ~fabric.mismatched)
    low, high = fabric.side_face[sides], fabric.side_face[fabric.twin[sides]]
    pairs, pair = distinct_rows(np.stack([fabric.row[low], fabric.row[high]], axis=1))
    same = np.bincount(pair, fabric.stitch[low] == fabric.stitch[high]) / np.bincount(pair)
    below, above = pairs.T
    # In two neighbouring rows of a rib, at least this part of the stitches stands above a stitch of its own kind.
    joined = both[below] & both[above] & (same >= 0.9)
    rib = linked_groups(rows, below[joined], above[joined])
    is_edge = np.ones(rows, dtype=bool)
    is_edge[fabric.row[~np.isin(fabric.stitch, EDGES)]] = False
    begins, ends = (np.zeros(rib.max() + 1, dtype=bool) for _ in range(2))
    for one, other in ((below, above), (above, below)):
        beside = rib[one] != rib[other]
        begins[rib[one[beside & is_edge[other]]]] = True
        ends[rib[one[beside & ~is_edge[other]]]] = True
    found: NDArray[np.bool_] = both & (np.bincount(rib)[rib] > 1) & begins[rib] & ends[rib]
    return found


def rest_length_ratios(fabric: StitchMesh, parts: PlacedParts) -> FloatArray:
    """Return the rest length of each yarn part divided by its drawn length, shape (P,).

    Args:
        fabric: stitch faces.
        parts: the yarn parts of the fabric.
    """
    length = parts.lengths
    is_head = (fabric.side_role[parts.end_side] == BOTTOM).all(axis=1)
    ratio = np.ones(len(length))
    decrease = (fabric.n_bottom > 1) & (fabric.n_top == 1)
    increase = (fabric.n_bottom == 1) & (fabric.n_top > 1)
    face = parts.face
    ratio[is_head] = _ratios_of(fabric, face[is_head], length[is_head], decrease | increase, per_loop=True)
    ratio[~is_head] = _ratios_of(fabric, face[~is_head], length[~is_head], decrease, per_loop=False)
    return ratio


def _ratios_of(
    fabric: StitchMesh, face: IntArray, length: FloatArray, shaped: NDArray[np.bool_], *, per_loop: bool
) -> FloatArray:
    """Return the ratios of heads only, or of feet and legs only.

    Args:
        fabric: stitch faces.
        face: face of each part, shape (n,).
        length: drawn length of each part [cm], shape (n,).
        shaped: whether the parts in each face take the length of plain stitches, shape (F,).
        per_loop: whether a face has a part for each loop below; else all its parts belong to one loop.
    """
    loops = np.maximum(fabric.n_bottom, 1) if per_loop else 1
    drawn: FloatArray = np.bincount(face, length, fabric.face_count) / loops
    plain = np.isin(fabric.stitch, PLAIN) & (fabric.n_bottom == 1) & (fabric.n_top == 1) & (drawn > 0.0)
    if not (plain.any() and shaped.any()):
        return np.ones(len(face))
    rows = fabric.row.max() + 1
    count: FloatArray = np.bincount(fabric.row[plain], minlength=rows).astype(np.float64)
    total = np.bincount(fabric.row[plain], drawn[plain], rows)
    # Smallest number of plain stitches of a row that give the lengths for its other stitches.
    mean = np.where(count >= 4, total / np.maximum(count, 1), drawn[plain].mean())[fabric.row]
    shorter = np.clip(HELD * mean / np.where(drawn > 0.0, drawn, 1.0), SHORTEST_RATIO, 1.0)
    return np.where(shaped & (drawn > 0.0), shorter, 1.0)[face]
