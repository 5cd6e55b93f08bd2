# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Knitting patterns: rows of stitches, the text language and the charts that describe them, and a library.

Names are loaded when first used, so that the command line starts without the languages of patterns.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stitchmesh.patterns.charts.colour_chart import chart_palette, read_colour_chart, write_colour_chart
    from stitchmesh.patterns.charts.leaf_chart import read_leaf_chart, write_leaf_chart
    from stitchmesh.patterns.language.leaf_codes import leaf_codes, parse_leaf_codes
    from stitchmesh.patterns.language.parse import parse_pattern
    from stitchmesh.patterns.language.writing import format_pattern
    from stitchmesh.patterns.library import pattern_names, read_pattern
    from stitchmesh.patterns.pattern import SECTIONS, Cell, Loop, Pattern, Row, check_closes
    from stitchmesh.patterns.placement.apply import apply_pattern, pattern_changes
    from stitchmesh.patterns.swatch_mesh import pattern_mesh

_HOME = {
    "apply_pattern": "placement.apply",
    "pattern_changes": "placement.apply",
    "chart_palette": "charts.colour_chart",
    "read_colour_chart": "charts.colour_chart",
    "write_colour_chart": "charts.colour_chart",
    "read_leaf_chart": "charts.leaf_chart",
    "write_leaf_chart": "charts.leaf_chart",
    "leaf_codes": "language.leaf_codes",
    "parse_leaf_codes": "language.leaf_codes",
    "pattern_names": "library",
    "read_pattern": "library",
    "parse_pattern": "language.parse",
    "SECTIONS": "pattern",
    "Cell": "pattern",
    "Loop": "pattern",
    "Pattern": "pattern",
    "Row": "pattern",
    "check_closes": "pattern",
    "pattern_mesh": "swatch_mesh",
    "format_pattern": "language.writing",
}
"""Module of each public name."""

__all__ = [
    "SECTIONS",
    "Cell",
    "Loop",
    "Pattern",
    "Row",
    "apply_pattern",
    "chart_palette",
    "check_closes",
    "format_pattern",
    "leaf_codes",
    "parse_leaf_codes",
    "parse_pattern",
    "pattern_changes",
    "pattern_mesh",
    "pattern_names",
    "read_colour_chart",
    "read_leaf_chart",
    "read_pattern",
    "write_colour_chart",
    "write_leaf_chart",
]


def __getattr__(name: str) -> object:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
