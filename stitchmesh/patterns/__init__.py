# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Knitting patterns: rows of stitches, the text language and the colour charts they are written in, a library.

Names are loaded when first used, so that the command line starts without the languages of patterns.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

# the one function that shares its name with its module: bound now, before any import can bind the module
from stitchmesh.patterns.leaf_codes import leaf_codes

if TYPE_CHECKING:
    from stitchmesh.patterns.apply import apply_pattern, pattern_changes
    from stitchmesh.patterns.colour_chart import chart_palette, read_colour_chart, write_colour_chart
    from stitchmesh.patterns.leaf_chart import read_leaf_chart, write_leaf_chart
    from stitchmesh.patterns.leaf_codes import parse_leaf_codes
    from stitchmesh.patterns.library import pattern_names, read_pattern
    from stitchmesh.patterns.parse import parse_pattern
    from stitchmesh.patterns.pattern import SECTIONS, Cell, Loop, Pattern, Row, check_closes
    from stitchmesh.patterns.swatch_mesh import pattern_mesh
    from stitchmesh.patterns.writing import format_pattern

_HOME = {
    "apply_pattern": "apply",
    "pattern_changes": "apply",
    "chart_palette": "colour_chart",
    "read_colour_chart": "colour_chart",
    "write_colour_chart": "colour_chart",
    "read_leaf_chart": "leaf_chart",
    "write_leaf_chart": "leaf_chart",
    "parse_leaf_codes": "leaf_codes",
    "pattern_names": "library",
    "read_pattern": "library",
    "parse_pattern": "parse",
    "SECTIONS": "pattern",
    "Cell": "pattern",
    "Loop": "pattern",
    "Pattern": "pattern",
    "Row": "pattern",
    "check_closes": "pattern",
    "pattern_mesh": "swatch_mesh",
    "format_pattern": "writing",
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
