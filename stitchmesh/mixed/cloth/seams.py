# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Sewing panels together along their borders.

The vertices of two borders that are sewn together become shared vertices, at the mean of their places in space. The
borders need the same number of edges, not the same length: where the lengths differ, the longer border puckers. Both
panels have their front on the same side, so the borders run in opposite directions: the start of one meets the end of
the other.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.cloth.panels import Panel, PanelTriangles, checked_edge_length, triangulate


@dataclass(frozen=True, kw_only=True)
class PanelBorder:
    """A part of the border of a panel."""

    panel: str
    """Name of the panel."""
    start: int
    """Corner of the outline at which the part begins; it runs anticlockwise."""
    end: int
    """Corner at which the part ends. If it is the corner at which the part begins, the part is the whole border."""

    def __str__(self) -> str:
        """Return the name in messages."""
        return f"panel {self.panel!r}, corners {self.start} to {self.end}"


@dataclass(frozen=True, kw_only=True)
class PanelSeam:
    """Two borders that are sewn together: the start of the first border meets the end of the second one.

    Raises:
        ParameterError: the angle is not a finite number, or the number of edges is below 1.
    """

    first: PanelBorder
    second: PanelBorder
    angle: float = 0.0
    """Angle of the seam at rest [degrees], positive on a ridge seen from outside."""
    edges: int | None = None
    """Number of edges along the seam; None if the longer border and the edge length decide."""

    def __post_init__(self) -> None:
        if not math.isfinite(self.angle):
            raise ParameterError(f"seam: angle: got {self.angle}; expected a finite number of degrees")
        if self.edges is not None and self.edges < 1:
            raise ParameterError(f"seam: edges: got {self.edges}; expected a number of at least 1")


def cloth_from_panels(panels: Sequence[Panel], seams: Sequence[PanelSeam], *, edge_length: float) -> Cloth:
    """Divide panels into triangles and sew them together.

    Args:
        panels: the panels.
        seams: the seams; the two borders of each get the same number of edges.
        edge_length: wanted length of the triangle edges [cm].

    Raises:
        ParameterError: a name is unknown or used twice, a border takes part in two seams, the given numbers of edges
            of two borders differ, or a panel cannot be divided (``triangulate``).
        MeshError: the panels sewn together are not a manifold surface.
    """
    counts = seam_counts(panels, seams, edge_length)
    return sew(panels, [triangulate(panel, edge_length, counts[panel.name]) for panel in panels], seams)


def seam_counts(panels: Sequence[Panel], seams: Sequence[PanelSeam], edge_length: float) -> dict[str, IntArray]:
    """Return the number of edges of each side of each panel, so that the two borders of each seam have equally many.

    A number that the panel or the seam gives is kept. A seam without a given number gets the number that fits its
    longer border; it is divided among the sides of a border in proportion to their lengths.

    Raises:
        ParameterError: as ``cloth_from_panels`` raises it.
    """
    named = _by_name(panels)
    checked_edge_length(edge_length)
    counts = {panel.name: np.array(panel.side_edges or panel.even_side_edges(edge_length)) for panel in panels}
    owner: dict[tuple[str, int], int] = {}
    for number, seam in enumerate(seams):
        borders = [_panel_and_sides(named, number, border) for border in (seam.first, seam.second)]
        for border, (panel, sides) in zip((seam.first, seam.second), borders, strict=True):
            _claim(owner, number, border, panel, sides)
        edges = _edges_of(number, seam, borders, counts)
        for panel, sides in borders:
            if not panel.side_edges:
                counts[panel.name][sides] = _shared_out(edges, panel.side_lengths[sides])
    return counts


def sew(panels: Sequence[Panel], triangles: Sequence[PanelTriangles], seams: Sequence[PanelSeam]) -> Cloth:
    """Sew panels that are divided into triangles.

    Args:
        panels: the panels.
        triangles: the triangles of each panel.
        seams: the seams.

    Raises:
        ParameterError: the two borders of a seam have different numbers of edges, or a seam joins two corners of one
            triangle.
        MeshError: as ``cloth_from_panels`` raises it.
    """
    offset = np.concatenate([[0], np.cumsum([len(part.points) for part in triangles])])
    place = {panel.name: number for number, panel in enumerate(panels)}
    chains = []
    for number, seam in enumerate(seams):
        first, second = (
            offset[place[border.panel]] + triangles[place[border.panel]].border_from(border.start, border.end)
            for border in (seam.first, seam.second)
        )
        if len(first) != len(second):
            raise ParameterError(
                f"seam {number} ({seam.first}; {seam.second}): got {len(first) - 1} and {len(second) - 1} edges; "
                "expected the same number; give both borders the same number of edges"
            )
        chains.append(np.stack([first, second[::-1]], axis=1))
    merged = _merged(int(offset[-1]), chains)
    return _sewn_cloth(panels, triangles, seams, offset, merged, chains)


def _sewn_cloth(
    panels: Sequence[Panel], triangles: Sequence[PanelTriangles], seams: Sequence[PanelSeam], offset: IntArray,
    merged: IntArray, chains: Sequence[IntArray],
) -> Cloth:  # fmt: skip
    """The cloth of triangles whose vertices are merged; ``sew`` explains the arguments."""
    placed = [panel.position.place(part.points) for panel, part in zip(panels, triangles, strict=True)]
    faces = merged[np.concatenate([part.triangles + first for part, first in zip(triangles, offset[:-1], strict=True)])]
    panel = np.repeat(np.arange(len(panels)), [len(part.triangles) for part in triangles])
    doubled = np.flatnonzero((faces == np.roll(faces, 1, axis=1)).any(axis=1))
    if len(doubled):
        raise ParameterError(
            f"panel {panels[panel[doubled[0]]].name!r}: a seam joins two corners of one triangle; expected different "
            "triangles on both sides; take a smaller edge length"
        )
    along = [merged[chain[:, 0]] for chain in chains]
    return Cloth(
        vertices=_means(np.concatenate(placed), merged),
        triangles=faces,
        rest=np.concatenate([part.points[part.triangles] for part in triangles]),
        panel=panel,
        panel_names=tuple(panel.name for panel in panels),
        seam_edges=np.concatenate([np.zeros((0, 2)), *(np.stack([line[:-1], line[1:]], axis=1) for line in along)]),
        seam_start=np.concatenate([[0], np.cumsum([len(line) - 1 for line in along])]),
        seam_angle=np.radians([seam.angle for seam in seams]),
    )


def _by_name(panels: Sequence[Panel]) -> dict[str, Panel]:
    if not panels:
        raise ParameterError("panels: got none; expected at least one")
    named: dict[str, Panel] = {}
    for panel in panels:
        if panel.name in named:
            raise ParameterError(f"panel {panel.name!r}: occurs twice; expected different names")
        named[panel.name] = panel
    return named


def _panel_and_sides(named: dict[str, Panel], number: int, border: PanelBorder) -> tuple[Panel, IntArray]:
    """The panel of a border, and its sides in order."""
    if border.panel not in named:
        raise ParameterError(f"seam {number}: there is no panel {border.panel!r}; the panels are {', '.join(named)}")
    count = len(named[border.panel].corners)
    for name in ("start", "end"):
        if not 0 <= getattr(border, name) < count:
            found = f"got {name} {getattr(border, name)}"
            raise ParameterError(f"seam {number}: {border}: {found}; expected a corner from 0 to {count - 1}")
    return named[border.panel], (border.start + np.arange((border.end - border.start - 1) % count + 1)) % count


def _claim(owner: dict[tuple[str, int], int], number: int, border: PanelBorder, panel: Panel, sides: IntArray) -> None:
    """Note that the sides belong to a seam."""
    for side in sides.tolist():
        if (panel.name, side) in owner:
            raise ParameterError(
                f"seam {number}: {border}: side {side} is in seam {owner[panel.name, side]} too; expected each side in "
                "one seam"
            )
        owner[panel.name, side] = number


def _edges_of(
    number: int, seam: PanelSeam, borders: Sequence[tuple[Panel, IntArray]], counts: dict[str, IntArray]
) -> int:
    """The number of edges along a seam."""
    found = [int(counts[panel.name][sides].sum()) for panel, sides in borders]
    given = [count for count, (panel, _) in zip(found, borders, strict=True) if panel.side_edges]
    if seam.edges is not None:
        given.append(seam.edges)
    if len(set(given)) > 1:
        raise ParameterError(
            f"seam {number} ({seam.first}; {seam.second}): got {' and '.join(map(str, given))} edges; expected the "
            "same number; give both borders the same number of edges"
        )
    edges = given[0] if given else max(found)
    fewest = max(len(sides) for _, sides in borders)
    if edges < fewest:
        raise ParameterError(f"seam {number}: got {edges} edges; expected at least {fewest}, one for each side")
    return edges


def _shared_out(total: int, lengths: FloatArray) -> IntArray:
    """Divide a number of edges among sides in proportion to their lengths, at least one each (largest remainder)."""
    wanted = (total - len(lengths)) * lengths / lengths.sum()
    counts = np.floor(wanted).astype(np.int64)
    order = np.argsort(counts - wanted, kind="stable")
    counts[order[: total - len(lengths) - int(counts.sum())]] += 1
    return counts + 1


def _merged(count: int, chains: Sequence[IntArray]) -> IntArray:
    """The new number of each vertex after sewing merged vertices, in order of first occurrence."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    one, other = np.concatenate([np.zeros((0, 2), dtype=np.int64), *chains]).T
    group = connected_components(coo_array((np.ones(len(one)), (one, other)), shape=(count, count)), directed=False)[1]
    _, first, place = np.unique(group, return_index=True, return_inverse=True)
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.argsort(first, kind="stable")] = np.arange(len(first))
    return rank[place]


def _means(points: FloatArray, group: IntArray) -> FloatArray:
    """Mean of the points of each group, shape (n, 3) to (groups, 3)."""
    sums = np.stack([np.bincount(group, weights=points[:, axis]) for axis in range(3)], axis=1)
    return sums / np.bincount(group)[:, None]
