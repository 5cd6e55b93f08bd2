# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Check for loops that every row of a repeat slips: such a loop never begins, and no yarn can be generated for it."""

from __future__ import annotations

import numpy as np

from stitchmesh.errors import PatternError
from stitchmesh.mesh import BORDER, IntArray, StitchMesh
from stitchmesh.mesh.stitch import VOCABULARY


def check_loops_begin(fabric: StitchMesh) -> None:
    """Check that each slipped loop is made by a stitch in some row below.

    Raises:
        PatternError: a loop is slipped in every row; the message gives the row and the stitch.
    """
    below = _slipped_from(fabric)
    side = np.flatnonzero(below != BORDER)
    for _ in range(len(side) + 1):
        if not len(side):
            return
        across = fabric.twin[below[side]]
        side = np.unique(across[(across != BORDER) & (below[across] != BORDER)])
    face = int(fabric.side_face[side].min())
    place = np.flatnonzero(np.flatnonzero(fabric.row == fabric.row[face]) == face)[0]
    where = f"row {fabric.row[face] + 1}, stitch {place + 1} from the left"
    raise PatternError(f"{where}: slips a loop that every row slips; knit or purl it in one of them")


def _slipped_from(fabric: StitchMesh) -> IntArray:
    """Return the bottom side from which the slipped loop at each top side comes, else ``BORDER``, shape (C,)."""
    result = np.full(fabric.side_count, BORDER)
    for stitch, making in VOCABULARY.items():
        first = fabric.face_start[:-1][fabric.stitch == stitch]
        for loop in (place for place, made in enumerate(making.made) if made == "s"):
            result[first + making.n_bottom + making.n_top - loop] = first  # top sides run from right to left
    return result
