# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Checks that a repeat can be knitted.

A loop that every row slips never begins, and no yarn can be generated for it. A float behind many stitches can be
generated, but a knitter does not make it.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.errors import PatternError
from stitchmesh.mesh import BORDER, IntArray, StitchMesh
from stitchmesh.mesh.courses import find_courses


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
    where = _place(fabric, int(fabric.side_face[side].min()))
    raise PatternError(f"{where}: slips a loop that every row slips; knit or purl it in one of them")


def check_floats(fabric: StitchMesh, longest: int) -> None:
    """Check that no yarn floats behind more than ``longest`` stitches of other yarns.

    Raises:
        PatternError: a float is too long; the message names the longest one.
    """
    length, face = max(_floats(fabric), default=(0, 0))
    if length > longest:
        centimetres = length * float(fabric.side_length[~fabric.is_wale].mean())
        found = f"yarn {fabric.yarn[face]} floats behind {length} stitches ({centimetres:.2g} cm)"
        advice = f"at most {longest} are allowed; work a stitch of this yarn among them, or raise longest_float"
        raise PatternError(f"{_place(fabric, face)}: {found}; {advice} (--longest-float)")


def _floats(fabric: StitchMesh) -> list[tuple[int, int]]:
    """Return the length of each float in stitches, and the face to the left of the float."""
    found = []
    for course in find_courses(fabric):
        faces = np.array(course.faces)
        for yarn in np.unique(fabric.yarn[faces]):
            place = np.flatnonzero(fabric.yarn[faces] == yarn)
            length = np.diff(place, append=place[0] + len(faces)) - 1
            found += list(zip(length.tolist(), faces[place].tolist(), strict=True))
    return found


def _place(fabric: StitchMesh, face: int) -> str:
    """Return the words for the place of a face in its repeat."""
    number = np.flatnonzero(np.flatnonzero(fabric.row == fabric.row[face]) == face)[0]
    return f"row {fabric.row[face] + 1}, stitch {number + 1} from the left"


def _slipped_from(fabric: StitchMesh) -> IntArray:
    """Return the bottom side from which the slipped loop at each top side comes, shape (C,); ``BORDER`` for no slip."""
    result = np.full(fabric.side_count, BORDER)
    for stitch, making in fabric.makings.items():
        first = fabric.face_start[:-1][fabric.stitch == stitch]
        for loop in (place for place, made in enumerate(making.made) if made == "s"):
            result[first + making.n_bottom + making.n_top - loop] = first  # top sides run from right to left
    return result
