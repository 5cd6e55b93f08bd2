# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Cells that launches leave out, because they are at rest or do not take part.

For a cell that is left out, the output of a launch keeps its last value.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from stitchmesh.yarnrelax.model.constants import Model


@contextmanager
def only_in(model: Model, cells: NDArray[np.bool_] | None) -> Iterator[None]:
    """In this block, leave out all but ``cells``, shape (C,), and cells that launches mark; None changes nothing."""
    if cells is None:
        yield
        return
    if not cells.all():
        model.resting.assign(~cells)
    try:
        yield
    finally:
        model.resting.zero_()
