# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Colours of the faces of a fabric: by stitch, by yarn or by row. Odd rows are darker, so that rows can be counted."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from stitchmesh.app.scene.drawing import LARGEST_PALETTE, Colours
from stitchmesh.mesh import IntArray, StitchMesh
from stitchmesh.mesh.palette import colours_of
from stitchmesh.render.palette import ODD_ROW, stitch_colours
from stitchmesh.yarn.colours import row_colours

ColourBy = Literal["stitch", "yarn", "row"]
"""The choices of what decides the colour of a face."""
_ALL_STITCHES = np.arange(LARGEST_PALETTE // 2)


def colours_of_faces(fabric: StitchMesh, by: ColourBy) -> Colours:
    """Return the colour of each face of a fabric, shape (F,)."""
    if by == "stitch":
        return Colours(_with_parity(fabric.stitch, fabric), _stitch_palette())
    if by == "yarn":
        return _by_yarn(fabric)
    return Colours.of(row_colours(fabric.row))


def _with_parity(number: IntArray, fabric: StitchMesh) -> NDArray[np.uint8]:
    """Return twice the number of each face, and one more in odd rows."""
    return (2 * number + fabric.row % 2).astype(np.uint8)


def _stitch_palette() -> NDArray[np.uint8]:
    """Return the colours of all stitches, each in even and in odd rows."""
    even, odd = (stitch_colours(_ALL_STITCHES, np.full(len(_ALL_STITCHES), row)) for row in (0, 1))
    return np.stack([even, odd], axis=1).reshape(-1, 3)


def _by_yarn(fabric: StitchMesh) -> Colours:
    """Return the colours of the yarns; yarns beyond the size of a palette repeat its colours."""
    numbers, rank = np.unique(fabric.yarn, return_inverse=True)
    even = colours_of(numbers[: LARGEST_PALETTE // 2], fabric.palette)
    odd = np.round(ODD_ROW * even).astype(np.uint8)
    return Colours(_with_parity(rank % len(even), fabric), np.stack([even, odd], axis=1).reshape(-1, 3))
