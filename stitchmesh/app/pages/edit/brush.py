# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Brushes: which faces a click or a drag over a fabric covers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, get_args

import numpy as np

from stitchmesh.mesh import IntArray, StitchMesh
from stitchmesh.selection import select
from stitchmesh.selection.selection import RectangleBetween, Ring, Wale

Brush = Literal["Stitch", "Row", "Wale", "Rectangle"]
BRUSHES: tuple[Brush, ...] = get_args(Brush)


def covered_faces(fabric: StitchMesh, brush: Brush, path: Sequence[int]) -> IntArray:
    """Return the faces that a brush covers, ascending.

    Args:
        fabric: the fabric.
        brush: ``Stitch``, or ``Row`` or ``Wale`` through each stitch, or ``Rectangle`` from the first stitch to the
            last one.
        path: faces under the pointer, at least one.

    Raises:
        ParameterError: no rectangle has the first and the last face as its corners.
    """
    if brush == "Rectangle":
        return select(fabric, RectangleBetween(path[0], path[-1]))
    if brush == "Stitch":
        return np.unique(np.asarray(path, dtype=np.int64))
    faces: set[int] = set()
    for face in path:
        if face not in faces:
            faces.update(select(fabric, Ring(face) if brush == "Row" else Wale(face)).tolist())
    return np.array(sorted(faces), dtype=np.int64)
