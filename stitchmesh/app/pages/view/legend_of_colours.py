# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The legend of colours: names with their colours, or a bar for numbers."""

from __future__ import annotations

from stitchmesh.app.controls.html_pieces import colour_bar, legend
from stitchmesh.render.colouring import Coloured


def legend_of(coloured: Coloured) -> str:
    """Return the legend as HTML; an empty text where the colours need none."""
    if coloured.scale is None:
        return legend(coloured.key) if coloured.key else ""
    numbers, units = zip(*(text.split(" ", 1) for text, _ in reversed(coloured.key)), strict=True)
    return colour_bar(coloured.scale.table(9), numbers, units[0])
