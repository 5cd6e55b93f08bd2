# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Rows beyond a border that stand up along the normal where wales run together, round a crown or a fingertip.

A vertex takes the step s along its wale. Where a stitch beside it would narrow by more than ``NARROWING`` the step
leans out and keeps its length,

    s' = |s| (s + l |s| n) / |s + l |s| n|,   l = ``STAND_UP`` (share by which the stitch narrows - ``NARROWING``),

with n the normal of the fabric: yarns of loops that run together would start too near to one another.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh.polygon_mesh import FloatArray, IntArray

NARROWING = 0.2
"""Part by which a stitch may narrow beyond the border before its row stands up."""
STAND_UP = 6.0
"""How fast it stands up with what is beyond that."""


def border_lean(base: FloatArray, step: FloatArray, sides: IntArray) -> FloatArray:
    """How far the row beyond each vertex of a border leans out of the fabric, 0 where it goes on in it, shape (n,).

    Args:
        base: border vertices [cm], shape (n, 3).
        step: from each to the other end of its wale [cm], shape (n, 3).
        sides: both ends of each border side, by their places in ``base``, shape (2, s).
    """
    width, after = (np.linalg.norm(ends[sides[1]] - ends[sides[0]], axis=1) for ends in (base, base + step))
    leaning = STAND_UP * np.clip(1.0 - after / width - NARROWING, 0.0, None)
    result = np.zeros(len(base))
    np.maximum.at(result, sides, np.broadcast_to(leaning, sides.shape))
    return result


def vertex_step(step: FloatArray, leaning: FloatArray, normal: FloatArray) -> FloatArray:
    """Steps [cm] that lean out of the fabric and are as long as before, shape (n, 3).

    Args:
        step: along the wales [cm], shape (n, 3).
        leaning: as ``border_lean`` has it, shape (n,).
        normal: unit normal of the fabric, shape (n, 3).
    """
    height = np.linalg.norm(step, axis=1, keepdims=True)
    raised = step + leaning[:, None] * height * normal
    stood: FloatArray = raised * height / np.linalg.norm(raised, axis=1, keepdims=True)
    return stood
