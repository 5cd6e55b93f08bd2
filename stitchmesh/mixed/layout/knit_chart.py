# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The chart of a knitting pattern for ``lay_knit``: which stitches of its tile are knitted and which are purled."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError, check_kind
from stitchmesh.hand_knitting.words import stitch_name
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.patterns.pattern import Cell, Loop, Pattern


def knit_chart(pattern: Pattern) -> NDArray[np.bool_]:
    """Return whether each stitch of the tile of a pattern is a knit stitch, the first row last, shape (rows, columns).

    Args:
        pattern: a pattern of knit and purl stitches; its borders are left out.

    Raises:
        ParameterError: the tile has other stitches, twisted loops or cables, whose yarns need a stitch mesh.
    """
    check_kind("knit_chart", pattern, Pattern)
    rows = []
    for number, row in enumerate(pattern.rows, start=1):
        cells = row.sections[1]
        for column, cell in enumerate(cells, start=1):
            _check_plain(f"pattern {pattern.name!r}, row {number}, stitch {column} of the tile", cell)
        if any(loop != Loop() for loop in row.loop_sections[1]):
            raise ParameterError(
                f"pattern {pattern.name!r}, row {number}: got twisted or crossed loops; expected plain ones; lay the "
                "pattern on a stitch mesh instead"
            )
        rows.append([cell.stitch == Stitch.KNIT for cell in cells])
    return np.array(rows[::-1], dtype=np.bool_)


def _check_plain(place: str, cell: Cell) -> None:
    if cell.stitch not in (Stitch.KNIT, Stitch.PURL) or any(cell.twist):
        found = stitch_name(cell.stitch) + ("" if not any(cell.twist) else " with a twist")
        raise ParameterError(
            f"{place}: got {found}; expected knit or purl without a twist; lay the pattern on a stitch mesh instead"
        )
