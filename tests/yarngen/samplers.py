# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Flat pieces of knitting from rows of stitches, in which every stitch can be beside or above every other.

A row is a list of stitches from left to right. Its faces lie above the lower course line, one bottom side after the
other, and form the upper course line. Course lines are shifted and their stitches widened so that they fit the lines
below and above them: the sum of squares of how much stitches lean and of how much their widths differ from one is
smallest.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.linalg import spsolve

from stitchmesh.mesh import FloatArray, StitchMesh
from stitchmesh.mesh.connectivity import find_twins
from stitchmesh.mesh.stitch import SIDE_COUNTS, Stitch
from stitchmesh.yarngen.templates.template import STITCH_HEIGHT

Row = Sequence[Stitch]
FACE_ARRAYS = ("n_bottom", "n_top", "stitch", "row", "twist")
APART = 3.0
"""Distance between separate pieces [stitch widths]. Tails extend a quarter of a stitch width beyond the borders."""
EVEN = 1.0
"""Weight of equal widths, over the weight of wale sides that lean as in the templates."""


def sides_of(stitch: Stitch) -> tuple[int, int]:
    """Numbers of bottom and top sides of a stitch; one and one for a cast-on stitch."""
    return (1, 1) if stitch == Stitch.CAST_ON else SIDE_COUNTS[stitch]


def bottoms(row: Row) -> int:
    """Number of loops on which a row is worked."""
    return sum(sides_of(stitch)[0] for stitch in row)


def tops(row: Row) -> int:
    """Number of loops that a row makes."""
    return sum(sides_of(stitch)[1] for stitch in row)


def sampler(rows: Sequence[Row]) -> StitchMesh:
    """A flat piece of these rows above a cast-on.

    Each row must be worked on as many loops as the row below makes.
    """
    whole = [[Stitch.CAST_ON] * bottoms(rows[0]), *rows]
    counts = [bottoms(whole[0]), *(tops(row) for row in whole)]
    for number, row in enumerate(rows):
        assert bottoms(row) == counts[number + 1], f"row {number}: works {bottoms(row)} of {counts[number + 1]} loops"
    first = np.concatenate([[0], np.cumsum([count + 1 for count in counts])])
    faces = [face for level, row in enumerate(whole) for face in _faces_of(row, first[level], first[level + 1])]
    stitches = np.array([stitch for row in whole for stitch in row], dtype=np.int64)
    face_start = np.concatenate([[0], np.cumsum([len(face) for face in faces])])
    face_vertex = np.concatenate(faces)
    return StitchMesh(
        vertices=_places(whole, counts),
        face_start=face_start,
        face_vertex=face_vertex,
        twin=find_twins(face_start, face_vertex, int(first[-1])),
        n_bottom=np.array([sides_of(Stitch(s))[0] for s in stitches]),
        n_top=np.array([sides_of(Stitch(s))[1] for s in stitches]),
        stitch=stitches,
        row=np.repeat(np.arange(len(whole)), [len(row) for row in whole]),
    )


def _faces_of(row: Row, lower: int, upper: int) -> list[np.ndarray]:
    """Vertices of the faces of a row, from the first vertices of the course lines below and above the row."""
    faces = []
    for stitch in row:
        below, above = sides_of(stitch)
        low, high = np.arange(lower, lower + below + 1), np.arange(upper, upper + above + 1)
        faces.append(np.concatenate([low, high[::-1]]))
        lower, upper = lower + below, upper + above
    return faces


def _places(rows: Sequence[Row], counts: Sequence[int]) -> FloatArray:
    """Vertices of all course lines, shape (V, 3)."""
    first = np.concatenate([[0], np.cumsum([count + 1 for count in counts])])
    equations, targets, weights = [], [], []
    for level, count in enumerate(counts):
        for k in range(count):
            equations.append((first[level] + k, first[level] + k + 1))
            targets.append(1.0)
            weights.append(EVEN)
    for level, row in enumerate(rows):
        lower, upper = first[level], first[level + 1]
        for stitch in row:
            below, above = sides_of(stitch)
            wider = (above - below) / 2
            for low, high, lean in ((lower, upper, -wider), (lower + below, upper + above, wider)):
                equations.append((low, high))
                targets.append(lean)
                weights.append(1.0)
            lower, upper = lower + below, upper + above
    start, end = np.array(equations).T
    weight, each = np.array(weights), np.arange(len(weights))
    entries = np.concatenate([-weight, weight]), (np.tile(each, 2), np.concatenate([start, end]))
    matrix = csr_array(entries, shape=(len(each), first[-1]))
    # the equations do not determine the position of the piece, so one vertex is held
    held = csr_array(([1.0], ([0], [0])), shape=(first[-1],) * 2)
    x = spsolve((matrix.T @ matrix + held).tocsc(), matrix.T @ (weight * np.array(targets)))
    y = np.repeat(np.arange(len(counts)) * STITCH_HEIGHT, [count + 1 for count in counts])
    return np.stack([x, y, 0 * x], axis=1)


Block = list[list[Stitch]]
"""Parts of rows above each other, from below. Each is worked on the loops that the part below makes."""


def beside(left: Stitch, right: Stitch) -> Block:
    """Two stitches side by side between knit stitches."""
    return [[Stitch.KNIT, left, right, Stitch.KNIT]]


def above(lower: Stitch, upper: Stitch, place: int = 0) -> Block:
    """One stitch above another one, among knit stitches.

    Args:
        lower: a stitch that makes at least one loop.
        upper: a stitch that is worked on at least one loop.
        place: the loop of the lower stitch below the first bottom side of the upper stitch. If it is negative, the
            first loop of the lower stitch is below bottom side ``-place`` of the upper stitch.
    """
    knit = Stitch.KNIT
    first, second = [knit] * (1 - min(place, 0)) + [lower], [knit] * (1 + max(place, 0)) + [upper]
    missing = tops(first) - bottoms(second)
    return [[*first, *[knit] * (1 - min(missing, 0))], [*second, *[knit] * (1 + max(missing, 0))]]


def placements(lower: Stitch, upper: Stitch) -> range:
    """All places at which one stitch can be above another one (``above``)."""
    return range(1 - sides_of(upper)[0], sides_of(lower)[1])


def side_by_side(pieces: Sequence[StitchMesh]) -> StitchMesh:
    """Separate pieces as one stitch mesh, arranged in an approximate square."""
    sizes = np.array([np.ptp(piece.vertices, axis=0)[:2] for piece in pieces]) + APART
    columns = int(np.ceil(np.sqrt(len(pieces))))
    each = np.arange(len(pieces))
    place = np.stack([each % columns, each // columns, 0 * each], axis=1)
    corner = np.cumsum([0, *(len(piece.vertices) for piece in pieces)])
    side = np.cumsum([0, *(piece.side_count for piece in pieces)])
    shift = place * [*sizes.max(axis=0), 0.0]
    vertices = [piece.vertices - piece.vertices.min(axis=0) + move for piece, move in zip(pieces, shift, strict=True)]
    twins = [np.where(piece.twin < 0, -1, piece.twin + first) for piece, first in zip(pieces, side, strict=False)]
    joined = {name: np.concatenate([getattr(piece, name) for piece in pieces]) for name in FACE_ARRAYS}
    return StitchMesh(
        vertices=np.concatenate(vertices),
        face_start=np.concatenate([[0], *(p.face_start[1:] + first for p, first in zip(pieces, side, strict=False))]),
        face_vertex=np.concatenate([p.face_vertex + first for p, first in zip(pieces, corner, strict=False)]),
        twin=np.concatenate(twins),
        **joined,
    )
