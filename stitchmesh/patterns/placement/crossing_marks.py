# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Cable marks that a pattern takes away and puts in, always whole crossings.

A crossing is made only where all its loops lie side by side on one course line and plain stitches side by side work
them. Where it does not fit, its stitches are worked without it.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import BORDER, LEFT, RIGHT, TOP, IntArray, StitchMesh
from stitchmesh.mesh.cable_groups import cable_groups
from stitchmesh.mesh.courses import right_neighbours, sides_across
from stitchmesh.patterns.pattern import Loop, Row, crossings
from stitchmesh.patterns.placement.placement import side_below


class CrossingMarks:
    """Cable marks of all sides while they change."""

    def __init__(self, fabric: StitchMesh) -> None:
        """Start with the marks of a fabric."""
        self.shift, self.layer = fabric.cable_shift.copy(), fabric.cable_layer.copy()
        self._fabric = fabric
        self._right = right_neighbours(fabric)

    def clear(self, sides: IntArray) -> None:
        """Take away the marks of some sides, and all crossings that have a loop there.

        Raises:
            LabelError: the crossings of the fabric are malformed.
        """
        gone = np.zeros(len(self.shift), dtype=bool)
        gone[sides] = True
        for group in cable_groups(self._fabric):
            gone[group.sides] |= gone[group.sides].any()
        self.shift[gone] = self.layer[gone] = 0

    def runs(self, first: IntArray, count: int) -> IntArray:
        """Each of some faces and those on its right in its row, ``BORDER`` beyond its end, shape (n, count)."""
        faces = [first]
        for _ in range(count - 1):
            faces.append(np.where(faces[-1] == BORDER, BORDER, self._right[faces[-1]]))
        return np.stack(faces, axis=1)

    def cross(self, faces: IntArray, loops: tuple[Loop, ...]) -> None:
        """Mark a crossing below each of some runs of faces, shape (n, loops), where its loops lie side by side."""
        sides = side_below(self._fabric, faces)
        fits = ((faces != BORDER) & (sides != BORDER)).all(axis=1)
        fits &= (self._beside(sides[:, :-1]) == sides[:, 1:]).all(axis=1)
        for place, loop in enumerate(loops):
            self.shift[sides[fits, place]], self.layer[sides[fits, place]] = loop.shift, loop.layer

    def _beside(self, sides: IntArray) -> IntArray:
        """The top side to the right of each top side on its course line, over one wale at most."""
        fabric = self._fabric
        within = sides - 1
        across = sides_across(fabric, within, LEFT)
        joined = (across != BORDER) & (fabric.side_role[across - 1] == TOP)
        joined &= fabric.row[fabric.side_face[across]] == fabric.row[fabric.side_face[sides]]
        return np.where(fabric.side_role[within] == RIGHT, np.where(joined, across - 1, BORDER), within)


def crossings_of(row: Row) -> list[tuple[int, range]]:
    """The crossings of a row: number of the section, and its loops counted from the section's first."""
    return [(section, cable) for section, loops in enumerate(row.loop_sections) for cable in crossings(loops)]
