# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The position of a pattern on a stitch mesh: the row and the column of the pattern for each face.

The module also finds a region of a fabric: a set of faces, and its pieces of courses.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError, first_few
from stitchmesh.mesh import BORDER, BOTTOM, TOP, IntArray, StitchMesh
from stitchmesh.mesh.courses import Course, faces_across, sides_across
from stitchmesh.mesh.stitch import VOCABULARY, Stitch
from stitchmesh.patterns.placement.columns import OUTSIDE

THROUGH_BACK = -1
"""Half turn that a knit or purl stitch through the back leg gives to its loop."""
_WORKED = np.isin(np.arange(max(Stitch) + 1), list(VOCABULARY))
"""Whether a pattern may replace a stitch, by type code; it may not replace cast-on and drawn-through loops."""


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
    """Return whether each face is a stitch that a pattern may change, shape (F,)."""
    return _WORKED[fabric.built_in]


def is_plain(fabric: StitchMesh) -> np.ndarray:
    """Return whether each face has one loop below and one above, and a pattern may change it, shape (F,)."""
    return is_worked(fabric) & (fabric.n_bottom == 1) & (fabric.n_top == 1)


def plain_above(fabric: StitchMesh) -> IntArray:
    """Return the plain face above each plain face, ``BORDER`` where there is none, shape (F,)."""
    plain = is_plain(fabric)
    above = faces_across(fabric, np.where(plain, fabric.face_start[:-1] + 2, 0), BOTTOM)
    return np.where(plain & (above != BORDER) & plain[above], above, BORDER)


def side_below(fabric: StitchMesh, faces: IntArray) -> IntArray:
    """Return the top side below the first bottom side of each given face, ``BORDER`` where there is none."""
    return sides_across(fabric, fabric.face_start[:-1][faces], TOP)


def held_twist(fabric: StitchMesh) -> IntArray:
    """Return the half turn that the stitch above gives to the loop of each top side, shape (C,).

    A half turn belongs to the stitch that works the loop if that stitch is knit or purled through the back leg, and
    otherwise to the stitch that makes the loop.
    """
    held = np.zeros(fabric.side_count, dtype=np.int64)
    turned = np.flatnonzero(fabric.twist == THROUGH_BACK)
    below, above = fabric.side_face[turned], faces_across(fabric, turned, BOTTOM)
    through = (above != BORDER) & np.isin(fabric.built_in[above], [Stitch.KNIT, Stitch.PURL])
    through &= (fabric.cable_shift[turned] == 0) & (fabric.built_in[below] != Stitch.YARN_OVER)
    held[turned[through]] = THROUGH_BACK
    return held


def region_of(fabric: StitchMesh, faces: Iterable[int] | None) -> NDArray[np.bool_]:
    """Return whether each face belongs to a region, shape (F,).

    Args:
        fabric: stitch mesh.
        faces: numbers of the faces of the region in any order; all faces if None.

    Raises:
        ParameterError: the region is empty, a face is not a whole number, or a face does not exist.
    """
    inside = np.full(fabric.face_count, faces is None)
    if faces is None:
        return inside
    numbers = _face_numbers(faces)
    missing = numbers[(numbers < 0) | (numbers >= fabric.face_count)]
    if len(missing):
        last = fabric.face_count - 1
        raise ParameterError(f"faces: {first_few(missing)} do not exist; the mesh has faces 0 to {last}")
    inside[numbers] = True
    return inside


def _face_numbers(faces: Iterable[int]) -> NDArray[np.int64]:
    try:
        numbers = np.atleast_1d(np.asarray(faces if isinstance(faces, np.ndarray) else list(faces)))
    except (TypeError, ValueError) as error:
        raise ParameterError(f"faces: got {faces!r}; expected numbers of faces such as [12, 13]") from error
    if numbers.size == 0:
        raise ParameterError("faces: got an empty region; expected at least one face")
    if numbers.ndim != 1 or not np.issubdtype(numbers.dtype, np.integer):
        found = f"{numbers.dtype} of shape {numbers.shape}"
        raise ParameterError(f"faces: got {found}; expected numbers of faces (np.flatnonzero of a mask)")
    return numbers.astype(np.int64)


def find_runs(fabric: StitchMesh, inside: NDArray[np.bool_]) -> list[Course]:
    """Find the runs of a region: the pieces of its courses whose faces all lie in the region.

    A run is closed if its course is a ring and all faces of the ring lie in the region; then it starts with the face of
    the lowest number.
    """
    own = np.flatnonzero(inside)
    across = fabric.twin[fabric.right_wale[own]]
    right = fabric.side_face[across]
    joined = (across != BORDER) & inside[right] & (fabric.row[right] == fabric.row[own])
    joined &= fabric.left_wale[right] == across
    step, has_left = np.full(fabric.face_count, BORDER), np.zeros(fabric.face_count, dtype=bool)
    step[own[joined]] = right[joined]
    has_left[right[joined]] = True
    following, used = step.tolist(), bytearray(fabric.face_count)
    runs = []
    for start in [*own[~has_left[own]].tolist(), *own.tolist()]:
        if used[start]:
            continue
        faces, face = [], start
        while face != BORDER and not used[face]:
            used[face] = True
            faces.append(face)
            face = following[face]
        runs.append(Course(tuple(faces), closed=face != BORDER))
    return runs
