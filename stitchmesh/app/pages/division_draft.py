# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The division that a user prepares on the page Divide: sizes, numbers and marks of edges, with undo."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from stitchmesh.app.pages.draft import Draft
from stitchmesh.app.pages.gauge_panel import drawn_height
from stitchmesh.app.project.division import Division, division_of, division_table
from stitchmesh.mesh import StitchMesh
from stitchmesh.tessellate.counts import edge_named, edges_with_one_count
from stitchmesh.tessellate.edge_file import EdgeSettings, VertexPair


class DivisionDraft(Draft[Division]):
    """A division that changes, and its earlier values."""

    def __init__(self, division: Division) -> None:
        """Start with a division."""
        super().__init__(division, "the division")

    @classmethod
    def of_settings(cls, settings: dict[str, Any], otherwise: Division) -> DivisionDraft:
        """Return the draft that a project has kept, or one that starts with another division if it has kept none."""
        return cls(division_of(settings["draft"]) if "draft" in settings else otherwise)

    @property
    def division(self) -> Division:
        """The division."""
        return self.value

    @property
    def table(self) -> dict[str, Any]:
        """The division as a project can keep it."""
        return division_table(self.division)

    @property
    def height(self) -> float:
        """Course spacing [cm]."""
        return drawn_height(self.division.stitch_width, self.division.stitch_height)


def with_count(division: Division, labeled: StitchMesh, edge: VertexPair, count: int | None) -> Division:
    """Return the division with another number of stitches on an edge; None for the number that follows from its length.

    On a wale edge, the number replaces those of the other wale edges of its row.
    """
    same = edges_with_one_count(labeled, edge_named(labeled, edge)).tolist()
    counts = {one: given for one, given in division.counts.items() if edge_named(labeled, one) not in same}
    return replace(division, counts=counts if count is None else {**counts, edge: count})


def with_mark(division: Division, edge: VertexPair, marked: bool) -> Division:
    """Return the division with an edge marked, or without its mark."""
    others = tuple(one for one in division.marked if set(one) != set(edge))
    return replace(division, marked=(*others, edge) if marked else others)


def with_edges(division: Division, settings: EdgeSettings, labeled: StitchMesh) -> Division:
    """Return the division with the numbers and marks of some settings in the place of its own.

    Raises:
        ParameterError: an edge does not exist.
    """
    counts = {edge: count for edge, count in settings.counts.items() if isinstance(edge, tuple)}
    for edge in (*counts, *settings.marked):
        edge_named(labeled, edge)
    return replace(division, counts=counts, marked=settings.marked)
