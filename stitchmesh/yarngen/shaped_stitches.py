# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Rest lengths of the yarn in decreases and increases: a knitter works the same length of yarn into every loop.

A decrease holds two or three loops of the row below in the place of one stitch, and its face is wider than that of a
plain stitch. Its drawing therefore contains more yarn than a knitter works into it: the heads of the loops that it
holds and the feet and legs of its own loop are up to half longer than those of plain stitches. With these lengths at
rest a decrease stands out as a lump.

The rest length of each head in a decrease or an increase, and that of the feet and legs of a decrease, is therefore the
mean drawn length of the same parts in the plain stitches of its row, or of the whole fabric if the row has few, times
``HELD``. It is never longer than drawn.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import BOTTOM, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.yarngen.embedding import PlacedParts

PLAIN = (Stitch.KNIT, Stitch.PURL)
FEWEST_PLAIN = 4
"""Smallest number of plain stitches of a row that give the lengths for its other stitches."""
HELD = 1.05
"""Length of the yarn in a decrease, divided by that in a plain stitch: it lies around several loops."""
SHORTEST_RATIO = 0.6
"""Smallest rest length divided by drawn length; the relaxation starts from a strain of at most two thirds."""


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
    mean = np.where(count >= FEWEST_PLAIN, total / np.maximum(count, 1), drawn[plain].mean())[fabric.row]
    shorter = np.clip(HELD * mean / np.where(drawn > 0.0, drawn, 1.0), SHORTEST_RATIO, 1.0)
    return np.where(shaped & (drawn > 0.0), shorter, 1.0)[face]
