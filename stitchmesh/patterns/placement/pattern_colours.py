# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The colours of a pattern on a fabric, and the colour of the ground, which the stitches left over have.

A pattern without colours only numbers its yarns, and the fabric has the same numbers. A pattern with colours, such as a
chart from an image, keeps them. A fabric of one yarn without a palette takes the ground of the pattern as its yarn 0.
On any other fabric the yarns of the pattern take the numbers of the equal colours there, and the other colours are
added to the fabric.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.change import PaletteChange
from stitchmesh.mesh.palette import colour_text, filled_palette, parse_colour
from stitchmesh.patterns.pattern import Pattern


def ground_of(pattern: Pattern, named: str | None) -> int:
    """Return the number of the yarn of the ground of a pattern.

    Args:
        pattern: the pattern.
        named: a colour of the pattern (``parse_colour``), or the number of one of its yarns; for None, the yarn of most
            stitches (``Pattern.ground``).

    Raises:
        ParameterError: the text is no colour, or the pattern has no such colour or yarn.
    """
    if named is None:
        return pattern.ground
    yarns = sorted({cell.yarn for row in pattern.rows for cell in row.cells})
    colours = [colour_text(colour) for colour in pattern.palette]
    wanted = int(named) if named.isdecimal() else None
    if wanted is None and (colour := colour_text(parse_colour(named))) in colours:
        wanted = colours.index(colour)
    if wanted not in yarns:
        known = ", ".join(colours[yarn] if yarn < len(colours) else str(yarn) for yarn in yarns)
        raise ParameterError(f"ground {named!r}: is no yarn of pattern {pattern.name!r}; expected one of {known}")
    return wanted


def colour_on_fabric(pattern: Pattern, fabric: StitchMesh, ground: int) -> tuple[Pattern, int, list[PaletteChange]]:
    """Bring the colours of a pattern onto a fabric.

    Args:
        pattern: the pattern.
        fabric: the fabric.
        ground: the pattern's number of the yarn of its ground.

    Returns:
        The pattern in the yarn numbers of the fabric, the number of its ground there, and the change of the palette of
        the fabric, if there is one.
    """
    if not pattern.palette:
        return pattern, ground, []
    if len(fabric.palette) or fabric.yarn.any():
        colours = [tuple(colour) for colour in filled_palette(fabric.palette, int(fabric.yarn.max()) + 1).tolist()]
    else:
        colours = [pattern.palette[ground]]
    colours += [colour for colour in dict.fromkeys(pattern.palette) if colour not in colours]
    number = {yarn: colours.index(colour) for yarn, colour in enumerate(pattern.palette)}
    rows = tuple(
        replace(row, cells=tuple(replace(cell, yarn=number.get(cell.yarn, cell.yarn)) for cell in row.cells))
        for row in pattern.rows
    )
    changes = [PaletteChange(np.array(colours, dtype=np.uint8))] if len(colours) > len(fabric.palette) else []
    return replace(pattern, rows=rows, palette=()), number.get(ground, ground), changes
