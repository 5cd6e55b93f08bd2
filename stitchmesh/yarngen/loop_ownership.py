# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Tells the yarn of a stitch from the yarn of the loop below, through which the stitch is worked.

Row and yarn numbers distinguish the two, except in a periodic fabric of one row, where a stitch is worked through its
own image.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import StitchMesh
from stitchmesh.yarn import FLOATING, YarnSet
from stitchmesh.yarngen.templates.table import template


def belongs_to_loop_below(yarns: YarnSet, fabric: StitchMesh) -> NDArray[np.bool_]:
    """Whether each control point belongs to a loop below its stitch (``TemplatePart.is_head``), shape (N,).

    Args:
        yarns: the yarns generated from the fabric.
        fabric: a stitch mesh without borders.
    """
    kinds = np.stack([fabric.stitch, fabric.n_bottom, fabric.n_top], axis=1)
    unique, kind = np.unique(kinds, axis=0, return_inverse=True)
    shapes = [template(fabric.stitch_type(stitch), *sides).parts for stitch, *sides in unique.tolist()]
    heads = np.zeros((len(shapes), max(map(len, shapes))), dtype=bool)
    for number, parts in enumerate(shapes):
        heads[number, : len(parts)] = [part.is_head for part in parts]
    found: NDArray[np.bool_] = heads[kind[yarns.face], yarns.part] & (yarns.part != FLOATING)
    return found
