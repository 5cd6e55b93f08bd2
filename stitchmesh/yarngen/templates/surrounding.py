# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""One stitch surrounded by plain stitches: a small flat fabric on which a drawing of the stitch is tested.

The fabric has three rows: a row of plain stitches, the stitch with one plain stitch on either side, and another row of
plain stitches. All faces have the proportions of their templates, so that the embedding does not deform the yarn.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.connectivity import find_twins
from stitchmesh.mesh.own_stitch import FIRST_OWN, OwnStitch, StitchType
from stitchmesh.mesh.stitch import VOCABULARY, Stitch
from stitchmesh.yarngen.templates.template import STITCH_HEIGHT


def surround_stitch(
    stitch: StitchType, twists: tuple[int, ...] = (), plain: Stitch = Stitch.KNIT
) -> tuple[StitchMesh, int]:
    """A flat fabric of three rows around one stitch, and the number of the face of the stitch. Stitches are 1 cm wide.

    Args:
        stitch: a stitch of the vocabulary, or one of the user's own.
        twists: half turns of the loops on its top sides, from left to right.
        plain: type of the other stitches.
    """
    definition = stitch.making if isinstance(stitch, OwnStitch) else VOCABULARY[stitch]
    low, high = definition.n_bottom, definition.n_top
    lines = [_course(count, max(low, high)) for count in (low, low, high, high)]
    heights = STITCH_HEIGHT * np.arange(-1, 3)
    vertices = [(x, y, 0.0) for line, y in zip(lines, heights, strict=True) for x in line]
    first = np.cumsum([0, *(len(line) for line in lines)])
    faces = _quads(first[0], first[1], low + 2)
    centre = len(faces) + 1
    faces += _row_of(first[1], first[2], low, high)
    faces += _quads(first[2], first[3], high + 2)
    return _knitted(vertices, faces, centre, (low, high), stitch, plain, twists), centre


def _course(count: int, widest: int) -> np.ndarray:
    """The x of each vertex of a course line with ``count`` stitches and one more on either side, shape (count + 3,)."""
    return (widest - count) / 2 + np.arange(-1.0, count + 2)


def _quads(lower: int, upper: int, count: int) -> list[list[int]]:
    """Vertices of ``count`` neighbouring quads between two course lines, from their first vertices."""
    return [[lower + k, lower + k + 1, upper + k + 1, upper + k] for k in range(count)]


def _row_of(lower: int, upper: int, low: int, high: int) -> list[list[int]]:
    """Vertices of a row: a quad, a face with ``low`` bottom and ``high`` top sides, and a quad."""
    middle = [lower + 1 + k for k in range(low + 1)] + [upper + 1 + k for k in reversed(range(high + 1))]
    return [*_quads(lower, upper, 1), middle, *_quads(lower + low + 1, upper + high + 1, 1)]


def _knitted(
    vertices: list, faces: list[list[int]], centre: int, sides: tuple[int, int], stitch: StitchType, plain: Stitch,
    twists: tuple[int, ...],
) -> StitchMesh:  # fmt: skip
    """The stitch mesh of these faces."""
    face_start = np.concatenate([[0], np.cumsum([len(face) for face in faces])])
    face_vertex = np.concatenate(faces)
    kind, bottom, top, row = (np.full(len(faces), value) for value in (plain, 1, 1, 0))
    own = (stitch,) if isinstance(stitch, OwnStitch) else ()
    kind[centre], (bottom[centre], top[centre]) = FIRST_OWN if own else stitch, sides
    row[centre - 1 :], row[centre + 2 :] = 1, 2
    twist = np.zeros(len(face_vertex), dtype=np.int64)
    twist[face_start[centre] + sum(sides) - np.arange(len(twists))] = twists
    return StitchMesh(
        vertices=np.array(vertices), face_start=face_start, face_vertex=face_vertex,
        twin=find_twins(face_start, face_vertex, len(vertices)), n_bottom=bottom, n_top=top, stitch=kind, row=row,
        twist=twist, own_stitches=own,
    )  # fmt: skip
