# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A bobble: one stitch is increased to three loops, purled back over, and decreased to one loop.

The three short rows lie within one face of the original mesh. The first short row continues from the left neighbour,
and the last short row continues into the right neighbour. The yarn turns between the rows at two slits; the border of
each slit consists of two row ends.
"""

from __future__ import annotations

from collections.abc import Hashable

import numpy as np

from stitchmesh.editing.sides import check_face
from stitchmesh.editing.sketch import Sketch, SketchedLoop, face_like
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray, StitchMesh
from stitchmesh.mesh.change import Change
from stitchmesh.mesh.stitch import Stitch

LOOPS = 3
"""Number of loops in the short rows of a bobble."""
LOWER_LINE = ((-0.8, 0.22, 1.47), (0.09, 0.01, 1.17), (1.71, -0.52, 0.62))
"""Vertices below the purls: fractions of the face's width and height, and the height above the fabric in widths."""
UPPER_LINE = ((-0.71, 1.06, 0.24), (0.59, 1.15, 0.9), (1.27, 1.43, 2.36))
"""Vertices above the purls, in the same units as ``LOWER_LINE``. Small random steps adjusted both lines until the
generated yarns were 0.39 yarn radii apart at the qualities ``draft`` and ``standard``."""


def bobble(fabric: StitchMesh, face: int) -> list[Change]:
    """Replace a stitch by a bobble: ``kyk``, three purls back, ``d213k``.

    Args:
        fabric: a mesh of stitches.
        face: a face with one loop below and one above.

    Raises:
        ParameterError: the face does not exist, does not work one loop of the row below to one loop, or touches a
            border.
    """
    check_face(fabric, face)
    sketch = Sketch(fabric)
    base = sketch.face(face)
    if (len(base.below), len(base.above)) != (1, 1) or base.stitch == Stitch.CAST_ON:
        raise ParameterError(f"{base.name}: does not work one loop to one loop; expected such a stitch for a bobble")
    for vertex in (base.high[0], base.low[1]):
        if sketch.corners.is_on_border(vertex):
            raise ParameterError(f"{base.name}: touches the border in vertex {vertex}; a bobble needs fabric around it")
    low, high = _lines(sketch, base.low, base.high)
    first: list[Hashable] = [("first", place) for place in range(LOOPS)]
    last: list[Hashable] = [("last", place) for place in range(LOOPS)]
    wales: list[Hashable] = ["left slit", *(("purl", place) for place in range(1, LOOPS)), "right slit"]
    for place in range(LOOPS):
        sketch.add(
            face_like(
                base, low=low[place : place + 2], high=high[place : place + 2], below=[first[place]],
                above=[last[place]], left=wales[place], right=wales[place + 1], stitch=Stitch.PURL,
            )
        )  # fmt: skip
    top = face_like(base, low=high, below=last, left="upper left slit", stitch=Stitch.D213K)
    top.loops = base.loops
    sketch.add(top)
    base.high, base.above, base.right, base.stitch = low, first, "lower right slit", Stitch.KYK
    base.loops = [SketchedLoop() for _ in first]
    return [sketch.patch()]


def _lines(sketch: Sketch, low: list[int], high: list[int]) -> tuple[list[int], list[int]]:
    """Add the vertices below and above the purls; return both lines, from the upper left to the lower right corner."""
    corners = np.array([sketch.position(vertex) for vertex in (*low, *high)])
    area = np.cross(corners[3] - corners[0], corners[2] - corners[1])
    width = np.linalg.norm(corners[1] - corners[0])
    outward = width * area / np.linalg.norm(area)
    # Height over width of the face for which ``LOWER_LINE`` and ``UPPER_LINE`` were drawn. A taller face does not
    # make them larger.
    tall = min(1.0, float(0.72 * width / np.linalg.norm(corners[2] - corners[0])))
    lower, upper = ([sketch.vertex(_point_at(corners, outward, u, 0.5 + (v - 0.5) * tall, height))
                     for u, v, height in line]
                    for line in (LOWER_LINE, UPPER_LINE))  # fmt: skip
    return [high[0], *lower], [*upper, low[1]]


def _point_at(corners: FloatArray, outward: FloatArray, u: float, v: float, height: float) -> FloatArray:
    """Return a point [cm], shape (3,).

    Args:
        corners: the lower left, lower right, upper left and upper right corners of the face [cm], shape (4, 3).
        outward: a vector normal to the face whose length is the width of the face [cm], shape (3,).
        u: fraction of the width.
        v: fraction of the height.
        height: height above the face, in widths.
    """
    low, high = corners[0] * (1 - u) + corners[1] * u, corners[2] * (1 - u) + corners[3] * u
    point: FloatArray = low * (1 - v) + high * v + height * outward
    return point
