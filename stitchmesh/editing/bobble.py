# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A bobble: one stitch widened to three, a row back over them, and the three taken together again.

The three short rows lie within one face. The first starts from the left neighbour, the last leads on to the right one,
and the yarn turns between them at two slits, each a border of two row ends.
"""

from __future__ import annotations

from collections.abc import Hashable

import numpy as np

from stitchmesh.editing.sides import check_face
from stitchmesh.editing.sketch import Loop, Sketch, like
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray, StitchMesh
from stitchmesh.mesh.change import Change
from stitchmesh.mesh.stitch import Stitch

LOOPS = 3
"""Loops that a bobble is wide."""
LOWER_LINE = ((-0.64, -0.15, 1.48), (0.44, -0.08, 1.19), (1.7, -0.25, 0.33))
"""Points below the purls: shares of the face's width and height, and out of the fabric in widths."""
UPPER_LINE = ((-0.71, 0.78, 0.31), (0.82, 1.18, 1.04), (1.28, 1.19, 1.99))
"""Points above the purls. Both lines were moved in small steps until yarns started 0.4 radii apart."""


def bobble(fabric: StitchMesh, face: int) -> list[Change]:
    """Make a bobble of a stitch: ``kyk``, three purls back, ``d213k``.

    Args:
        fabric: stitch faces.
        face: a face of one loop on one loop.

    Raises:
        ParameterError: there is no such face, or it does not work one loop of a row below, or touches a border.
    """
    check_face(fabric, face)
    sketch = Sketch(fabric)
    foot = sketch.face(face)
    if (len(foot.below), len(foot.above)) != (1, 1) or foot.stitch == Stitch.CAST_ON:
        raise ParameterError(f"{foot.name}: does not work one loop to one loop; expected such a stitch for a bobble")
    for vertex in (foot.high[0], foot.low[1]):
        if sketch.corners.is_on_border(vertex):
            raise ParameterError(f"{foot.name}: touches the border in vertex {vertex}; a bobble needs fabric around it")
    low, high = _lines(sketch, foot.low, foot.high)
    first: list[Hashable] = [("first", place) for place in range(LOOPS)]
    last: list[Hashable] = [("last", place) for place in range(LOOPS)]
    wales: list[Hashable] = ["left slit", *(("purl", place) for place in range(1, LOOPS)), "right slit"]
    for place in range(LOOPS):
        sketch.add(
            like(
                foot, low=low[place : place + 2], high=high[place : place + 2], below=[first[place]],
                above=[last[place]], left=wales[place], right=wales[place + 1], stitch=Stitch.PURL,
            )
        )  # fmt: skip
    head = like(foot, low=high, below=last, left="upper left slit", stitch=Stitch.D213K)
    head.loops = foot.loops
    sketch.add(head)
    foot.high, foot.above, foot.right, foot.stitch = low, first, "lower right slit", Stitch.KYK
    foot.loops = [Loop() for _ in first]
    return [sketch.patch()]


def _lines(sketch: Sketch, low: list[int], high: list[int]) -> tuple[list[int], list[int]]:
    """Vertices below and above the purls, from the upper left corner to the lower right one, which they end in."""
    corners = np.array([sketch.position(vertex) for vertex in (*low, *high)])
    area = np.cross(corners[3] - corners[0], corners[2] - corners[1])
    out = np.linalg.norm(corners[1] - corners[0]) * area / np.linalg.norm(area)
    lower, upper = ([sketch.vertex(_placed(corners, out, *point)) for point in line]
                    for line in (LOWER_LINE, UPPER_LINE))  # fmt: skip
    return [high[0], *lower], [*upper, low[1]]


def _placed(corners: FloatArray, out: FloatArray, u: float, v: float, height: float) -> FloatArray:
    """A point by its shares of the face's width and height and of the way out of the fabric [cm], shape (3,)."""
    low, high = corners[0] * (1 - u) + corners[1] * u, corners[2] * (1 - u) + corners[3] * u
    point: FloatArray = low * (1 - v) + high * v + height * out
    return point
