# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Short rows where a surface asks for them: at a heel, on the outer side of a bend, where limbs meet.

Rows on level lines are higher where the lines are farther apart. The excess height of each stitch is carried from row
to row along the wales. Where neighbouring stitches have gathered more than one row (``ASKED``), the yarn turns back and
comes again, and two rows are taken off the sum. The sum is spread along the row first, so that runs are not shorter
than a knitter would work.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stitchmesh.editing.short_rows import short_rows
from stitchmesh.errors import MeshError, ParameterError
from stitchmesh.mesh import BORDER, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.arrays import runs_of
from stitchmesh.mesh.change import apply_change
from stitchmesh.mesh.courses import Course, find_courses
from stitchmesh.selection.parts import face_centres
from stitchmesh.shaping.plain_places import PlainPlaces

ASKED = 1.3
"""Missing rows from which the yarn turns back."""
FREE_AROUND = 3
"""Stitches beside a turn, and rows above and below it, without another turn, increase or decrease."""
SPREAD = 0.25
"""Part of its missing height that each stitch shares with its two neighbours, for each row."""
MOST_CARRIED = 6.0
"""Largest number of rows that a place may miss; the stretch of the stitches fills the rest of a wider gap."""


@dataclass(frozen=True)
class Wedge:
    """A run of stitches above which short rows are worked."""

    faces: tuple[int, ...]
    """The stitches from left to right."""


def with_short_rows(
    fabric: StitchMesh, height: float, plain: PlainPlaces, leaning: NDArray[np.bool_]
) -> StitchMesh:
    """Add short rows where the rows of a fabric are too high.

    Args:
        fabric: stitches on a surface, before mesh relaxation.
        height: height of a stitch [cm].
        plain: places in which the yarn does not turn.
        leaning: whether the wales of each stitch lean because of shaping at seams, shape (F,).
    """
    for wedge in list(wedges(fabric, height, plain, leaning)):
        try:
            for change in short_rows(fabric, wedge.faces):
                fabric = apply_change(fabric, change)
        except (ParameterError, MeshError):
            # The run ends at a slit or beside other turns; its neighbours carry the load.
            continue
    return fabric


def wedges(
    fabric: StitchMesh, height: float, plain: PlainPlaces, leaning: NDArray[np.bool_]
) -> Iterator[Wedge]:
    """Find the runs of stitches above which short rows are missing, from the first row to the last one."""
    # Part by which a stitch may be too high before the excess counts. Where rows are only a little too high, short
    # rows cost more stretch at their turns than they save.
    excess = np.maximum(np.where(leaning, height_across(fabric), face_height(fabric)) / height - 1.0 - 0.15, 0.0)
    below = _faces_below(fabric)
    missing = np.zeros(fabric.face_count)
    crowded = _near_shaping(fabric) | plain.hold(face_centres(fabric, np.arange(fabric.face_count)))
    for course in sorted(find_courses(fabric), key=lambda course: int(fabric.row[course.faces[0]])):
        faces = np.array(course.faces)
        carried = np.array([missing[below[face]].mean() if len(below[face]) else 0.0 for face in course.faces])
        missing[faces] = np.clip(_spread(carried, course.closed) + excess[faces], -MOST_CARRIED, MOST_CARRIED)
        for run in _runs(missing[faces] >= ASKED, course):
            chosen = _with_free_ends(faces[run], crowded)
            # Stitches in the shortest run; in shorter ones the loops at the two turns are crowded.
            if 8 <= len(chosen) < len(faces) - 2:
                # Additional rows that the yarn works where it turns back and comes again.
                missing[chosen] -= 2.0
                for turn in chosen[[0, -1]]:
                    crowded[_around(fabric, int(turn))] = True
                yield Wedge(tuple(chosen.tolist()))


def face_height(fabric: StitchMesh) -> FloatArray:
    """Return the mean length of the two wale sides of each face [cm], shape (F,)."""
    return 0.5 * (fabric.side_length[fabric.left_wale] + fabric.side_length[fabric.right_wale])


def height_across(fabric: StitchMesh) -> FloatArray:
    """Return the mean height of the two wale sides of each face above its course [cm], shape (F,).

    Wales beside a seam lean, and are longer than the row is high.
    """
    point = fabric.corner_position
    bottom_right = fabric.face_start[:-1] + fabric.n_bottom
    along = point[bottom_right] - point[fabric.face_start[:-1]]
    along = along / np.linalg.norm(along, axis=1)[:, None]
    up = np.stack([point[fabric.side_next[fabric.right_wale]] - point[fabric.right_wale],
                   point[fabric.left_wale] - point[fabric.side_next[fabric.left_wale]]])  # fmt: skip
    across = up - np.einsum("sfi,fi->sf", up, along)[:, :, None] * along
    height: FloatArray = np.linalg.norm(across, axis=2).mean(axis=0)
    return height


def _faces_below(fabric: StitchMesh) -> list[IntArray]:
    """The faces below each face: those whose top sides meet its bottom sides."""
    found = []
    for face in range(fabric.face_count):
        start = int(fabric.face_start[face])
        across = fabric.twin[start : start + int(fabric.n_bottom[face])]
        across = across[across != BORDER]
        matched = across[~fabric.mismatched[across]]
        found.append(fabric.side_face[matched])
    return found


def _spread(values: FloatArray, closed: bool) -> FloatArray:
    """Share values with neighbours along a row, shape (n,)."""
    if len(values) < 3:
        return values
    left, right = np.roll(values, 1), np.roll(values, -1)
    if not closed:
        left[0], right[-1] = values[0], values[-1]
    return (1.0 - SPREAD) * values + 0.5 * SPREAD * (left + right)


def _runs(inside: np.ndarray, course: Course) -> list[IntArray]:
    """Places of each run of chosen stitches of a course, across the start of a ring too."""
    if inside.all():
        return []
    places = np.arange(len(inside))
    if course.closed:
        places = np.roll(places, -int(np.argmin(inside)))
    return [places[first:beyond] for first, beyond in runs_of(inside[places])]


def _near_shaping(fabric: StitchMesh) -> NDArray[np.bool_]:
    """Whether each stitch is near a cast-on, a border, a graft, an increase or a decrease, shape (F,)."""
    side = (fabric.twin == BORDER) | fabric.mismatched
    near = (fabric.n_bottom != fabric.n_top) | (fabric.n_bottom != 1)
    near[fabric.side_face[side]] = True
    for _ in range(FREE_AROUND - 1):
        spread = near[fabric.side_face[np.where(fabric.twin == BORDER, 0, fabric.twin)]] & (fabric.twin != BORDER)
        near[fabric.side_face[spread]] = True
    return near


def _around(fabric: StitchMesh, face: int) -> IntArray:
    """The stitches up to ``FREE_AROUND`` stitches or rows from a stitch."""
    found = np.array([face])
    for _ in range(FREE_AROUND):
        across = fabric.twin[fabric.sides_of(found)]
        found = np.union1d(found, fabric.side_face[across[across != BORDER]])
    return found


def _with_free_ends(run: IntArray, crowded: NDArray[np.bool_]) -> IntArray:
    """The part of a run between its first and its last stitch that are not crowded."""
    free = np.flatnonzero(~crowded[run])
    return run[free[0] : free[-1] + 1] if len(free) else run[:0]
