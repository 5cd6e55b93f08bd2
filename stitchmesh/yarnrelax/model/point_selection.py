# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Control points that a caller selects by their numbers or by their stitch faces."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError, first_few
from stitchmesh.yarn import YarnSet

Numbers = Sequence[int] | NDArray[np.integer[Any]]


def select_points(what: str, yarns: YarnSet, points: Numbers, faces: Numbers) -> NDArray[np.int64]:
    """Return the numbers of the selected control points, ascending, shape (n,).

    Args:
        what: the purpose of the selection, for messages.
        yarns: the yarns.
        points: numbers of control points.
        faces: stitch faces, all of whose control points are selected (``YarnSet.face``).

    Raises:
        ParameterError: a control point or a stitch face does not exist, or nothing is selected.
    """
    points, faces = _numbers(what, "points", points), _numbers(what, "faces", faces)
    bad = points[(points < 0) | (points >= len(yarns.points))]
    if len(bad):
        raise ParameterError(f"{what}: got control point {first_few(bad)}; expected 0 to {len(yarns.points) - 1}")
    bad = faces[~np.isin(faces, yarns.face[yarns.face >= 0])]
    if len(bad):
        raise ParameterError(f"{what}: got stitch face {first_few(bad)}; no control point came from it")
    selected = np.union1d(points, np.flatnonzero(np.isin(yarns.face, faces)))
    if len(selected) == 0:
        raise ParameterError(f"{what}: got neither control points nor stitch faces; expected at least one")
    return selected


def _numbers(what: str, name: str, values: Numbers) -> NDArray[np.int64]:
    array = np.asarray(values)
    if array.size and not np.issubdtype(array.dtype, np.integer):
        raise ParameterError(f"{what}: got {name} of type {array.dtype}; expected whole numbers")
    return array.ravel().astype(np.int64)
