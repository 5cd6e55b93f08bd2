# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The position of a pattern on a stitch mesh: the pattern's row and column for each face."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.mesh import BORDER, BOTTOM, TOP, IntArray, StitchMesh
from stitchmesh.mesh.courses import faces_across, sides_across
from stitchmesh.mesh.stitch import VOCABULARY, Stitch
from stitchmesh.patterns.placement.columns import OUTSIDE

_WORKED = np.isin(np.arange(max(Stitch) + 1), list(VOCABULARY))
"""Whether a stitch may be replaced by a pattern, by type code; cast-on and drawn-through loops may not."""


@dataclass(frozen=True, eq=False)
class Placement:
    """The pattern's row and column of each face."""

    column: IntArray
    """Column as in ``columns.py``, ``OUTSIDE`` where the face stays unchanged, shape (F,)."""
    row: IntArray
    """Row of the pattern, counted from its first row; without meaning where the column is ``OUTSIDE``, shape (F,)."""

    @classmethod
    def nowhere(cls, fabric: StitchMesh) -> Placement:
        """Return a placement in which no face takes the pattern; its arrays may be changed."""
        return cls(np.full(fabric.face_count, OUTSIDE), np.zeros(fabric.face_count, dtype=np.int64))


def is_worked(fabric: StitchMesh) -> np.ndarray:
    """Whether each face is a stitch that a pattern may change, shape (F,)."""
    return _WORKED[fabric.built_in]


def is_plain(fabric: StitchMesh) -> np.ndarray:
    """Whether each face is a stitch with one loop below and one above that a pattern may change, shape (F,)."""
    return is_worked(fabric) & (fabric.n_bottom == 1) & (fabric.n_top == 1)


def plain_above(fabric: StitchMesh) -> IntArray:
    """Return the plain face above each plain face, ``BORDER`` where there is none, shape (F,)."""
    plain = is_plain(fabric)
    above = faces_across(fabric, np.where(plain, fabric.face_start[:-1] + 2, 0), BOTTOM)
    return np.where(plain & (above != BORDER) & plain[above], above, BORDER)


def side_below(fabric: StitchMesh, faces: IntArray) -> IntArray:
    """Return the top side below the first bottom side of each given face, ``BORDER`` where there is none."""
    return sides_across(fabric, fabric.face_start[:-1][faces], TOP)
