# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Lean of the rows that are added beyond a border where wales converge, for example at a crown or a fingertip.

A row beyond the border starts from each border vertex by a step s along the wale. Where wales converge, the new row is
narrower than the border, and the generated yarns of neighbouring loops would be too close to one another. Where a
stitch would narrow by more than ``NARROWING``, the step is therefore turned towards the normal n of the fabric without
a change of its length:

    s' = |s| (s + l |s| n) / |s + l |s| n|,   l = ``LEAN_RATE`` (narrowing - ``NARROWING``),

where the narrowing is 1 - width of the new row along the border stitch / width of the border stitch.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh.polygon_mesh import FloatArray, IntArray

NARROWING = 0.2
"""If a stitch beyond the border narrows by more than this, its row leans out of the fabric."""
LEAN_RATE = 6.0
"""Increase of the lean l with the narrowing above ``NARROWING``."""


def border_lean(base: FloatArray, step: FloatArray, sides: IntArray) -> FloatArray:
    """Compute the lean l at each border vertex, shape (n,); it is 0 where the row continues in the plane of the fabric.

    Args:
        base: positions of the border vertices [cm], shape (n, 3).
        step: step from each border vertex to the other end of its wale edge [cm], shape (n, 3).
        sides: the two ends of each border side, as indices into ``base``, shape (2, s).
    """
    along, after = (ends[sides[1]] - ends[sides[0]] for ends in (base, base + step))
    left = np.einsum("ni,ni->n", after, along) / np.einsum("ni,ni->n", along, along)
    leaning = LEAN_RATE * np.clip(1.0 - left - NARROWING, 0.0, None)
    result = np.zeros(len(base))
    np.maximum.at(result, sides, np.broadcast_to(leaning, sides.shape))
    return result


def vertex_step(step: FloatArray, leaning: FloatArray, normal: FloatArray) -> FloatArray:
    """Turn steps out of the fabric by their lean without a change of their length; returns s' [cm], shape (n, 3).

    Args:
        step: steps s along the wales [cm], shape (n, 3).
        leaning: lean l of each step (``border_lean``), shape (n,).
        normal: unit normal n of the fabric at each step, shape (n, 3).
    """
    length = np.linalg.norm(step, axis=1, keepdims=True)
    raised = step + leaning[:, None] * length * normal
    leaned: FloatArray = raised * length / np.linalg.norm(raised, axis=1, keepdims=True)
    return leaned
