# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The division of a labeled mesh into stitches, as a value that JSON can hold."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from stitchmesh.errors import ParameterError
from stitchmesh.io.checked import check_table
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.shaping_stitches import DEFAULT_INCREASE, Increase
from stitchmesh.tessellate import STITCH_WIDTH, tessellate
from stitchmesh.tessellate.counts import edge_named, edges_with_one_count
from stitchmesh.tessellate.edge_file import EdgeSettings, VertexPair, parse_edge_counts


@dataclass(frozen=True, kw_only=True)
class Division:
    """The sizes and counts with which a labeled mesh is divided into stitches."""

    stitch_width: float = STITCH_WIDTH
    """Wale spacing [cm]."""
    stitch_height: float | None = None
    """Course spacing [cm]; None for 0.77 times the stitch width."""
    counts: Mapping[VertexPair, int] = field(default_factory=dict)
    """Number of stitches along single edges, each named by its two vertices."""
    marked: tuple[VertexPair, ...] = ()
    """Wale edges beside which all increases and decreases of their faces stand, each named by its two vertices."""
    increase: Increase = DEFAULT_INCREASE
    """How increases are made: ``m1``, ``kfb``, ``lifted`` or ``yo``."""

    def divide(self, labeled: StitchMesh) -> StitchMesh:
        """Divide a labeled mesh into stitches.

        Raises:
            StitchMeshError: an error of ``tessellate``.
        """
        return tessellate(
            labeled, stitch_width=self.stitch_width, stitch_height=self.stitch_height, counts=dict(self.counts),
            marked=self.marked, increase=self.increase,
        )  # fmt: skip


def with_known_edges(division: Division, labeled: StitchMesh) -> Division:
    """Return the division without the counts and marks of edges that a labeled mesh lacks.

    A mark on an edge that is not a wale edge is left out too.
    """
    counts = {edge: count for edge, count in division.counts.items() if _known(labeled, edge)}
    marked = tuple(edge for edge in division.marked if _known(labeled, edge, wale=True))
    return replace(division, counts=counts, marked=marked)


def with_count(division: Division, labeled: StitchMesh, edge: VertexPair, count: int | None) -> Division:
    """Return the division with another number of stitches on an edge; None lets the length decide.

    On a wale edge, the number replaces the numbers of the other wale edges of its row.
    """
    same = edges_with_one_count(labeled, edge_named(labeled, edge)).tolist()
    counts = {one: given for one, given in division.counts.items() if edge_named(labeled, one) not in same}
    return replace(division, counts=counts if count is None else {**counts, edge: count})


def with_mark(division: Division, edge: VertexPair, marked: bool) -> Division:
    """Return the division with an edge marked, or without its mark."""
    others = tuple(one for one in division.marked if set(one) != set(edge))
    return replace(division, marked=(*others, edge) if marked else others)


def with_edges(division: Division, settings: EdgeSettings, labeled: StitchMesh) -> Division:
    """Return the division with the numbers and marks of some settings instead of its own.

    Raises:
        ParameterError: an edge does not exist.
    """
    counts = {edge: count for edge, count in settings.counts.items() if isinstance(edge, tuple)}
    for edge in (*counts, *settings.marked):
        edge_named(labeled, edge)
    return replace(division, counts=counts, marked=settings.marked)


def _known(labeled: StitchMesh, edge: VertexPair, *, wale: bool = False) -> bool:
    try:
        found = edge_named(labeled, edge)
    except ParameterError:
        return False
    return not wale or bool(labeled.is_wale[labeled.edge_side[found]])


@dataclass(frozen=True, kw_only=True)
class _Table:
    """The form of a division in JSON."""

    stitch_width: float
    stitch_height: float | None
    counts: tuple[str, ...]
    marked: tuple[tuple[int, int], ...]
    increase: Increase = DEFAULT_INCREASE


def division_table(division: Division) -> dict[str, Any]:
    """Return a division as a table for JSON; a count is written ``V,W=COUNT``."""
    return {
        "stitch_width": division.stitch_width,
        "stitch_height": division.stitch_height,
        "counts": [f"{first},{second}={count}" for (first, second), count in division.counts.items()],
        "marked": [list(edge) for edge in division.marked],
        "increase": division.increase,
    }


def division_of(table: object) -> Division:
    """Return the division from a table of ``division_table``.

    Raises:
        ParameterError: the table has another form.
    """
    found = check_table(table, _Table)
    counts: dict[VertexPair, int] = {}
    for edge, count in parse_edge_counts(found.counts).counts.items():
        if isinstance(edge, int):
            raise ParameterError(f"count of side {edge}: expected an edge, named by its two vertices")
        counts[edge] = count
    return Division(
        stitch_width=found.stitch_width, stitch_height=found.stitch_height, counts=counts, marked=found.marked,
        increase=found.increase,
    )  # fmt: skip
