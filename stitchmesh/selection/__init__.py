# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Selections: faces of a fabric by rows, wales, borders, stitches and parts of a garment."""

from stitchmesh.selection.borders import Border, borders
from stitchmesh.selection.parse import parse_selection
from stitchmesh.selection.selected_faces import select
from stitchmesh.selection.selection import Selection

__all__ = ["Border", "Selection", "borders", "parse_selection", "select"]
