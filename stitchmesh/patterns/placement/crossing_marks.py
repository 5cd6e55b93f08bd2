# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Cable marks that a pattern removes and adds; a crossing is always removed or added as a whole.

A crossing is added only if all its loops lie side by side on one course line and adjacent plain stitches work them.
Otherwise the stitches are worked without the crossing.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import BORDER, LEFT, RIGHT, TOP, IntArray, StitchMesh
from stitchmesh.mesh.cable_groups import cable_groups
from stitchmesh.mesh.courses import right_neighbours, sides_across
from stitchmesh.patterns.pattern import Loop, Row, crossings
from stitchmesh.patterns.placement.placement import side_below


class CrossingMarks:
    """Cable marks of all sides of a fabric, to be changed."""

    def __init__(self, fabric: StitchMesh) -> None:
        """Start with the marks of a fabric."""
        self.shift, self.layer = fabric.cable_shift.copy(), fabric.cable_layer.copy()
        self._fabric = fabric
        self._right = right_neighbours(fabric)

    def clear(self, sides: IntArray) -> None:
        """Remove the marks of some sides, together with every crossing that has a loop at one of these sides.

        Raises:
            LabelError: the crossings of the fabric are malformed.
        """
        cleared = np.zeros(len(self.shift), dtype=bool)
        cleared[sides] = True
        for group in cable_groups(self._fabric):
            cleared[group.sides] |= cleared[group.sides].any()
        self.shift[cleared] = self.layer[cleared] = 0

    def runs(self, first: IntArray, count: int) -> IntArray:
        """Return each face and the faces to its right in its row; ``BORDER`` beyond the end, shape (n, count)."""
        faces = [first]
        for _ in range(count - 1):
            faces.append(np.where(faces[-1] == BORDER, BORDER, self._right[faces[-1]]))
        return np.stack(faces, axis=1)

    def cross(self, faces: IntArray, loops: tuple[Loop, ...]) -> NDArray[np.bool_]:
        """Add a crossing below each run of faces, shape (n, loops), if the loops below the run lie side by side.

        Returns:
            Whether the crossing is added below each run, shape (n,).
        """
        sides = side_below(self._fabric, faces)
        fits: NDArray[np.bool_] = ((faces != BORDER) & (sides != BORDER)).all(axis=1)
        fits &= (self._next_top_sides(sides[:, :-1]) == sides[:, 1:]).all(axis=1)
        for place, loop in enumerate(loops):
            self.shift[sides[fits, place]], self.layer[sides[fits, place]] = loop.shift, loop.layer
        return fits

    def _next_top_sides(self, sides: IntArray) -> IntArray:
        """Return the top side to the right of each top side on its course line, across one wale edge at most."""
        fabric = self._fabric
        within = sides - 1
        across = sides_across(fabric, within, LEFT)
        joined = (across != BORDER) & (fabric.side_role[across - 1] == TOP)
        joined &= fabric.row[fabric.side_face[across]] == fabric.row[fabric.side_face[sides]]
        return np.where(fabric.side_role[within] == RIGHT, np.where(joined, across - 1, BORDER), within)


def crossings_of(row: Row) -> list[tuple[int, range]]:
    """Return the crossings of a row: the index of the section, and the loops counted from its first loop."""
    return [(section, cable) for section, loops in enumerate(row.loop_sections) for cable in crossings(loops)]
