# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Other colours on yarns that exist already.

Colours do not change the topology. Yarns, relaxed or not, stay where they are if the colours of their palette change.
They also stay if the numbers of the yarns change but each yarn takes the same way. The numbers decide the ways in three
places: the yarns of a row lie in the order of their numbers (``floats_and_tails``), a row end is joined to a row end of
the same number (``row_ends``), and a yarn is cut where rows of different numbers meet side by side.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stitchmesh.mesh import BORDER, StitchMesh
from stitchmesh.mesh.change import Change, Marks, PaletteChange
from stitchmesh.mesh.courses import find_courses
from stitchmesh.yarn import YarnSet


def changes_colours_only(changes: Sequence[Change]) -> bool:
    """Return whether changes of a stitch mesh concern its palette and the numbers of its yarns only."""
    return all(
        isinstance(change, PaletteChange) or (isinstance(change, Marks) and change.name == "yarn") for change in changes
    )


def keeps_yarn_routes(before: StitchMesh, after: StitchMesh) -> bool:
    """Return whether the yarns of two fabrics, which differ in the numbers of their yarns only, take the same ways.

    The answer may be False although the yarns take the same ways, but it is never True if they do not.
    """
    if np.array_equal(before.yarn, after.yarn):
        return True
    at_row_ends = np.zeros(before.face_count, dtype=bool)
    for course in find_courses(before, climbing=True):
        faces = list(course.faces)
        rank, rank_after = (np.unique(fabric.yarn[faces], return_inverse=True)[1] for fabric in (before, after))
        if not np.array_equal(rank, rank_after):
            return False
        at_row_ends[faces] = not course.closed
    pairs = np.unique(np.stack([before.yarn[at_row_ends], after.yarn[at_row_ends]]), axis=1)
    if any(len(np.unique(numbers)) < pairs.shape[1] for numbers in pairs):
        return False
    sides = np.flatnonzero(before.is_wale & before.mismatched & (before.twin != BORDER))
    here, across = before.side_face[sides], before.side_face[before.twin[sides]]
    return np.array_equal(before.yarn[here] == before.yarn[across], after.yarn[here] == after.yarn[across])


def recoloured_yarns(yarns: YarnSet, before: StitchMesh, after: StitchMesh) -> YarnSet:
    """Return yarns of a fabric with the numbers and the palette of another fabric with the same yarn routes.

    Args:
        yarns: the yarns, generated or relaxed.
        before: their fabric.
        after: the fabric with other colours, for which ``keeps_yarn_routes`` is true.
    """
    number = yarns.colour.copy()
    for yarn, (first, end) in enumerate(zip(yarns.start[:-1], yarns.start[1:], strict=True)):
        faces = yarns.face[first:end]
        own = (faces >= 0) & (before.yarn[faces] == yarns.colour[yarn])
        feet = own & (before.row[faces] == yarns.row[first:end])  # The head of a loop lies on a face of the next row.
        if own.any():
            number[yarn] = after.yarn[faces[int(np.argmax(feet if feet.any() else own))]]
    return replace(yarns, colour=number, palette=after.palette)
