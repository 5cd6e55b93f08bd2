# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Knitting patterns: rows of stitches, the text language and the charts that describe them, and a library."""

from stitchmesh.patterns.charts.colour_chart import chart_palette, read_colour_chart, write_colour_chart
from stitchmesh.patterns.charts.leaf_chart import read_leaf_chart, write_leaf_chart
from stitchmesh.patterns.language.leaf_codes import leaf_codes, parse_leaf_codes
from stitchmesh.patterns.language.parse import parse_pattern
from stitchmesh.patterns.language.writing import format_pattern
from stitchmesh.patterns.library import pattern_names, read_pattern
from stitchmesh.patterns.pattern import SECTIONS, Cell, Loop, Pattern, Row, check_closes
from stitchmesh.patterns.placement.apply import apply_pattern, pattern_changes
from stitchmesh.patterns.swatch_mesh import pattern_mesh

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
