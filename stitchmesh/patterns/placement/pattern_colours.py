# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The colours of a pattern on a fabric.

A pattern without colours numbers its yarns only, and its numbers are those of the fabric. A pattern with colours, such
as a chart from an image, keeps them: on a fabric without a palette the pattern brings its palette, and on a fabric with
one its yarns take the numbers of the equal colours there. Colours that the fabric does not have are added to it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.change import PaletteChange
from stitchmesh.mesh.palette import filled_palette
from stitchmesh.patterns.pattern import Pattern


def colour_on_fabric(pattern: Pattern, fabric: StitchMesh) -> tuple[Pattern, list[PaletteChange]]:
    """Return the pattern in the yarn numbers of a fabric, and the change of its palette, if there is one."""
    if not pattern.palette:
        return pattern, []
    if not len(fabric.palette):
        return pattern, [PaletteChange(np.array(pattern.palette, dtype=np.uint8))]
    colours = [tuple(colour) for colour in filled_palette(fabric.palette, int(fabric.yarn.max()) + 1).tolist()]
    colours += [colour for colour in dict.fromkeys(pattern.palette) if colour not in colours]
    number = {yarn: colours.index(colour) for yarn, colour in enumerate(pattern.palette)}
    rows = tuple(
        replace(row, cells=tuple(replace(cell, yarn=number.get(cell.yarn, cell.yarn)) for cell in row.cells))
        for row in pattern.rows
    )
    changes = [PaletteChange(np.array(colours, dtype=np.uint8))] if len(colours) > len(fabric.palette) else []
    return replace(pattern, rows=rows, palette=()), changes
