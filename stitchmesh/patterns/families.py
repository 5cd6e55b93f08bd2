# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Families of patterns, by which lists of patterns are ordered."""

from __future__ import annotations

from stitchmesh.patterns.pattern import Pattern

FAMILIES = ("Knit and purl", "Cables", "Lace", "Slipped and tucked", "Colours")
"""Names of the families, in the order of a list."""


def family_of(pattern: Pattern) -> str:
    """Return the family of a pattern: the last one of ``FAMILIES`` whose stitches it has."""
    if pattern.yarn_count > 1:
        return "Colours"
    makings = [cell.making for row in pattern.rows for cell in row.cells]
    if any("s" in making.made for making in makings):
        return "Slipped and tucked"
    if any((making.n_bottom, making.n_top) != (1, 1) for making in makings):
        return "Lace"
    return "Cables" if any(loop.shift for row in pattern.rows for loop in row.loops) else "Knit and purl"
