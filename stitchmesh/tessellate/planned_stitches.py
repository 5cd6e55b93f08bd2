# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The stitches into which a labeled mesh would be divided, counted without dividing it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stitchmesh.mesh import BORDER, BOTTOM, TOP, IntArray, StitchMesh
from stitchmesh.tessellate.counts import EdgeName, counts_and_doubt
from stitchmesh.tessellate.courses import loops_per_course
from stitchmesh.tessellate.tessellate import COURSE_OVER_WALE_SPACING, marked_sides


@dataclass(frozen=True, eq=False, kw_only=True)
class PlannedStitches:
    """The numbers of stitches of a labeled mesh for a size of the stitches."""

    along: IntArray
    """Number of stitches along each edge, shape (E,)."""
    in_panel: IntArray
    """Number of stitches in each face, shape (F,)."""
    courses: IntArray
    """Number of courses in each face, shape (F,)."""
    cast_on: int
    """Number of loops along bottom sides on borders, where the fabric is cast on."""
    bind_off: int
    """Number of loops along top sides on borders, where the fabric is bound off."""
    shaped: int
    """Number of loops by which increases and decreases change the courses."""
    rows: int
    """Number of rows of stitches."""
    doubt: str
    """Why the size may be wrong, in one line; no text if the size is met."""

    @property
    def total(self) -> int:
        """Number of stitches of the fabric."""
        return int(self.in_panel.sum())


def planned_stitches(
    labeled: StitchMesh, *, stitch_width: float, stitch_height: float | None = None,
    counts: Mapping[EdgeName, int] | None = None, marked: Sequence[EdgeName] = (),
) -> PlannedStitches:  # fmt: skip
    """Count the stitches that ``tessellate`` would make with the same arguments.

    Raises:
        ParameterError: as for ``tessellate``.
        TessellationError: as for ``tessellate``.
    """
    height = COURSE_OVER_WALE_SPACING * stitch_width if stitch_height is None else stitch_height
    marked_sides(labeled, marked)  # The check comes here, because the numbers do not depend on marks.
    along, doubt = counts_and_doubt(labeled, stitch_width, height, counts or {})
    loops = along[labeled.side_edge]
    border = labeled.twin == BORDER
    role = labeled.side_role
    first = labeled.face_start[:-1]
    bottom, top = (np.add.reduceat(np.where(role == some, loops, 0), first) for some in (BOTTOM, TOP))
    courses = loops[labeled.left_wale]
    in_panel, shaped = _stitches_in_panels(bottom, top, courses)
    return PlannedStitches(
        along=along,
        in_panel=in_panel,
        courses=courses,
        cast_on=int(loops[border & (role == BOTTOM)].sum()),
        bind_off=int(loops[border & (role == TOP)].sum()),
        shaped=shaped,
        rows=int(courses[np.unique(labeled.row, return_index=True)[1]].sum()),
        doubt=doubt,
    )


def _stitches_in_panels(bottom: IntArray, top: IntArray, courses: IntArray) -> tuple[IntArray, int]:
    """Number of stitches in each panel, shape (F,), and the number of shaped loops; equal panels are counted once."""
    kinds, first, kind, panels = np.unique(
        np.stack([bottom, top, courses], 1), axis=0, return_index=True, return_inverse=True, return_counts=True
    )
    counted = np.array(
        [_stitches(b, t, c, face) for (b, t, c), face in zip(kinds.tolist(), first.tolist(), strict=True)]
    )
    return counted[kind.reshape(-1), 0], int(counted[:, 1] @ panels)


def _stitches(bottom: int, top: int, courses: int, face: int) -> tuple[int, int]:
    """Number of stitches in a panel, one for each loop on the narrow side of a course, and number of shaped loops."""
    loops = loops_per_course(bottom, top, courses, face)
    narrow, wide = np.minimum(loops[1:], loops[:-1]), np.maximum(loops[1:], loops[:-1])
    return int(np.where(narrow > 0, narrow, wide).sum()), int((wide - narrow).sum())
