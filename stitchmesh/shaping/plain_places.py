# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Places from which increases and decreases are kept away: around the marks whose role is ``plain``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import FloatArray
from stitchmesh.shaping.marks import TimeMark, vertices_of
from stitchmesh.shaping.triangle_surface import TriangleSurface

if TYPE_CHECKING:
    from scipy.spatial import cKDTree


@dataclass(frozen=True, eq=False)
class _Place:
    """The surroundings of one mark."""

    points: cKDTree
    """Points along the mark."""
    radius: float
    """Distance up to which the surface is plain [cm]."""
    near: NDArray[np.bool_]
    """Whether each vertex of the surface can be reached from the mark by a short path over the surface, shape (V,)."""


@dataclass(frozen=True, eq=False)
class PlainPlaces:
    """All plain places of a connected surface."""

    vertices: cKDTree
    """Vertices of the surface."""
    places: tuple[_Place, ...]

    def hold(self, points: FloatArray) -> NDArray[np.bool_]:
        """Return whether each point on the surface is in a plain place, shape (n,)."""
        held = np.zeros(len(points), dtype=bool)
        if self.places:
            nearest = self.vertices.query(points)[1]
            for place in self.places:
                held |= (place.points.query(points)[0] <= place.radius) & place.near[nearest]
        return held


def plain_places(surface: TriangleSurface, marks: Sequence[TimeMark], width: float) -> PlainPlaces:
    """Return the places around the marks whose role is ``plain``.

    Args:
        surface: a connected surface.
        marks: the marks on it, of all roles.
        width: width of a stitch [cm].

    Raises:
        ParameterError: a mark is off the surface.
    """
    from scipy.spatial import cKDTree

    plain = [mark for mark in marks if mark.role == "plain"]
    return PlainPlaces(cKDTree(surface.vertices), tuple(_place(surface, mark, width) for mark in plain))


def _place(surface: TriangleSurface, mark: TimeMark, width: float) -> _Place:
    """Find the surroundings of a mark."""
    from scipy.sparse.csgraph import dijkstra
    from scipy.spatial import cKDTree

    # Radius of a plain place that has none, in stitch widths.
    radius = 3.0 * width if mark.radius is None else mark.radius
    vertices = vertices_of(surface, mark)
    longest = float(surface.edge_length.max())
    # Longest path over the edges of triangles, over the distance in space; a longer path leads around a limb.
    reach = dijkstra(
        surface.edge_graph, directed=False, indices=vertices, min_only=True, limit=1.5 * (radius + longest)
    )
    line = surface.vertices[np.append(vertices, vertices[0])] if mark.kind == "border" else np.asarray(mark.points)
    # Points along a mark for each radius.
    return _Place(cKDTree(_sampled(line, radius / 8.0)), radius, np.isfinite(reach))


def _sampled(line: FloatArray, spacing: float) -> FloatArray:
    """Return points along a line that are at most ``spacing`` apart [cm], shape (n, 3)."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    place = np.linspace(0.0, along[-1], int(along[-1] / spacing) + 2)
    return np.stack([np.interp(place, along, line[:, k]) for k in range(3)], axis=1)
