# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Rest width and height of each stitch of a free fabric, from the knit and purl stitches around it.

If every stitch had the rest size of plain knit, as on the surface of a garment, rib would be as wide as stockinette and
garter stitch as high. Yarns make them different. Where knit and purl change from one wale to the next, the fabric folds
and draws in; where they change from one course to the next, it draws together in height. Let f be 1 for a stitch whose
loops are knit and -1 for one whose loops are purled. Let R and C be the means of f over the stitches that are at most
``REACH`` away in the course and in the wale. Then

    stockinette R C = 1, rib (1 - R) C = 1, garter stitch R (1 - C) = 1, seed stitch (1 - R) (1 - C) = 1

with R^2 and C^2 in the place of R and C, and every other fabric of knit and purl stitches lies between these four. A
slipped stitch has no row of its own, so that fabrics with slips are lower. The logarithms of width and height, relative
to plain knit, are taken as linear in the last three products and in the share of slips in the course.
``python benchmarks/run.py stitch-sizes`` relaxes swatches of the library and fits the factors ``WIDTH`` and ``HEIGHT``
to the sizes of the pure fabrics. Yarn-overs and decreases have the rest size of their neighbours, because they shape a
fabric by their places.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import BORDER, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.stitch import VOCABULARY, Stitch

REACH = 2
"""Number of stitches to each side that decide the size of a stitch; 2 x 2 and 3 x 3 rib then draw in like 1 x 1 rib."""
WIDTH = np.array([-0.567, 0.117, -0.028, 0.212])
"""Change of the logarithm of the width of a stitch per share of rib, garter stitch, seed stitch and slips."""
HEIGHT = np.array([0.052, -0.299, -0.288, -0.506])
"""The same for the logarithm of the height."""


@dataclass(frozen=True, eq=False)
class StitchSizes:
    """Rest sizes of the stitches of a fabric."""

    width: FloatArray
    """Rest length of the course sides of each stitch [cm], shape (F,)."""
    height: FloatArray
    """Rest length of the wale sides of each stitch [cm], shape (F,)."""


def stitch_sizes(fabric: StitchMesh, *, width: float, height: float) -> StitchSizes:
    """Return the rest sizes of the stitches of a fabric.

    Args:
        fabric: stitch mesh.
        width: rest width of plain knit [cm].
        height: rest height of plain knit [cm].
    """
    shares = fabric_shares(fabric)
    return StitchSizes(width * np.exp(shares @ WIDTH), height * np.exp(shares @ HEIGHT))


def fabric_shares(fabric: StitchMesh) -> FloatArray:
    """Return the shares of rib, garter stitch, seed stitch and slips around each stitch, shape (F, 4).

    The shares of rib, garter stitch and seed stitch are at most 1 together; the rest belongs to stockinette.
    """
    left, right, below, above = _neighbours(fabric)
    sign, known = _signs(fabric)
    cast_on = (fabric.stitch == Stitch.CAST_ON) & (above != BORDER)
    sign[cast_on], known[cast_on] = sign[above[cast_on]], known[above[cast_on]]
    course = _mean_around(sign, known, left, right) ** 2
    wale = _mean_around(sign, known, below, above) ** 2
    everywhere = np.ones(fabric.face_count, dtype=bool)
    slipped = _mean_around(_is_slipped(fabric).astype(float), everywhere, left, right)
    products = [(1.0 - course) * wale, course * (1.0 - wale), (1.0 - course) * (1.0 - wale)]
    return np.stack([*products, slipped], axis=1)


def _signs(fabric: StitchMesh) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return the mean over the loops of each stitch, knit 1 and purled -1, and whether it has such loops."""
    knit, purled = (_loops(fabric, kind) for kind in "kp")
    known = knit + purled > 0
    return (knit - purled) / np.maximum(knit + purled, 1), known


def _loops(fabric: StitchMesh, kind: str) -> IntArray:
    """Return the number of loops of a kind that each stitch makes, shape (F,)."""
    count = np.zeros(max(Stitch) + 1, dtype=np.int64)
    for stitch, making in VOCABULARY.items():
        count[stitch] = making.made.count(kind)
    return count[fabric.built_in]


def _is_slipped(fabric: StitchMesh) -> NDArray[np.bool_]:
    return np.isin(fabric.stitch, [Stitch.SLIP_BACK, Stitch.SLIP_FRONT, Stitch.WRAP])


def _neighbours(fabric: StitchMesh) -> tuple[IntArray, IntArray, IntArray, IntArray]:
    """Return the stitch to the left, to the right, below and above each stitch; ``BORDER`` if there is none."""
    first = fabric.face_start[:-1]
    below = _across(fabric, first + fabric.n_bottom // 2)
    above = _across(fabric, fabric.right_wale + np.minimum(1 + fabric.n_top // 2, fabric.n_top))
    return (
        _across(fabric, fabric.left_wale),
        _across(fabric, fabric.right_wale),
        np.where(fabric.n_bottom > 0, below, BORDER),
        np.where(fabric.n_top > 0, above, BORDER),
    )


def _across(fabric: StitchMesh, sides: IntArray) -> IntArray:
    """Return the face across one side of each face; ``BORDER`` at a border."""
    twin = fabric.twin[sides]
    return np.where(twin == BORDER, BORDER, fabric.side_face[twin])


def _mean_around(values: FloatArray, known: NDArray[np.bool_], back: IntArray, ahead: IntArray) -> FloatArray:
    """Return the mean of the known values of each stitch and of those at most ``REACH`` away, 1 if none is known.

    Args:
        values: value of each stitch, shape (F,).
        known: whether each value is known, shape (F,).
        back: the next stitch in one direction, ``BORDER`` where there is none, shape (F,).
        ahead: the next stitch in the other direction, shape (F,).
    """
    total, count = values * known, known.astype(float)
    for following in (back, ahead):
        stitch = np.arange(len(values))
        for _ in range(REACH):
            stitch = np.where(stitch == BORDER, BORDER, following[stitch])
            counts = (stitch != BORDER) & known[stitch]
            total, count = total + np.where(counts, values[stitch], 0.0), count + counts
    mean: FloatArray = np.where(count > 0.0, total / np.maximum(count, 1.0), 1.0)
    return mean
