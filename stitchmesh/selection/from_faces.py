# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The selection that lists given faces."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from stitchmesh.errors import ParameterError
from stitchmesh.selection.selection import Faces, Span


def selection_of_faces(faces: ArrayLike) -> Faces:
    """Return the selection of some faces by number, with neighbouring numbers as spans: ``faces 3-7, 12``.

    Args:
        faces: numbers of the faces, in any order, shape (n,), with n at least 1.

    Raises:
        ParameterError: there are no faces, or a number is negative.
    """
    numbers = np.unique(np.asarray(faces, dtype=np.int64))
    if not len(numbers):
        raise ParameterError("selection of faces: got none; expected at least one")
    breaks = np.flatnonzero(np.diff(numbers) != 1)
    first = numbers[np.concatenate([[0], breaks + 1])]
    last = numbers[np.concatenate([breaks, [len(numbers) - 1]])]
    return Faces(tuple(Span(one, other) for one, other in zip(first.tolist(), last.tolist(), strict=True)))
