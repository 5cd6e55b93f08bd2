# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Where a pattern comes to lie: the pattern's row and column of each face of a stitch mesh."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.mesh import BORDER, BOTTOM, TOP, IntArray, StitchMesh
from stitchmesh.mesh.courses import faces_across, sides_across
from stitchmesh.mesh.stitch import VOCABULARY, Stitch
from stitchmesh.patterns.placement.columns import OUTSIDE

_WORKED = np.isin(np.arange(max(Stitch) + 1), list(VOCABULARY))
"""Whether a stitch is worked as a knitter does, by type code; cast-on and drawing through are not."""


@dataclass(frozen=True, eq=False)
class Placement:
    """The pattern's row and column of each face."""

    column: IntArray
    """Column as in ``columns.py``, ``OUTSIDE`` where the face stays as it is, shape (F,)."""
    row: IntArray
    """Row of the pattern, counted from its first; of no meaning outside, shape (F,)."""

    @classmethod
    def nowhere(cls, fabric: StitchMesh) -> Placement:
        """No face takes the pattern; columns and rows may be written."""
        return cls(np.full(fabric.face_count, OUTSIDE), np.zeros(fabric.face_count, dtype=np.int64))


def is_worked(fabric: StitchMesh) -> np.ndarray:
    """Whether each face is a stitch that a pattern may change, shape (F,)."""
    return _WORKED[fabric.stitch]


def is_plain(fabric: StitchMesh) -> np.ndarray:
    """Whether each face is a stitch on one loop that leaves one, shape (F,)."""
    return is_worked(fabric) & (fabric.n_bottom == 1) & (fabric.n_top == 1)


def plain_above(fabric: StitchMesh) -> IntArray:
    """The plain face above each plain face, else ``BORDER``, shape (F,)."""
    plain = is_plain(fabric)
    above = faces_across(fabric, np.where(plain, fabric.face_start[:-1] + 2, 0), BOTTOM)
    return np.where(plain & (above != BORDER) & plain[above], above, BORDER)


def side_below(fabric: StitchMesh, faces: IntArray) -> IntArray:
    """The top side under the first bottom side of each of some faces, ``BORDER`` where there is none."""
    return sides_across(fabric, fabric.face_start[:-1][faces], TOP)
