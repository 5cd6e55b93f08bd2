# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Holes of a surface, and the faces that fill them.

A garment has openings, which are borders too, so that only small holes are filled. The outline of a flat piece is no
hole: a closed curve of length p bounds an area of at most p^2 / (4 pi) in a plane, and a component with little more
area lies within its outline.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from stitchmesh.mesh.connectivity import linked_groups
from stitchmesh.mesh.polygon_mesh import FloatArray, IntArray
from stitchmesh.mesh.repair.action import ActionLog
from stitchmesh.mesh.repair.components import component_of_faces
from stitchmesh.mesh.repair.soup import Soup, open_sides
from stitchmesh.mesh.repair.weld import median_edge

CENTRE = -1
"""Place of the centre of a hole in the polygons that fill it."""


@dataclass(frozen=True, eq=False)
class ClosedBorders:
    """The closed borders of a manifold surface; n is their number and m the number of border sides."""

    sides: IntArray
    """Border sides, ascending, shape (m,)."""
    border: IntArray
    """Border of each of these sides, shape (m,)."""
    following: IntArray
    """Place in ``sides`` of the side that follows each of them along the border, shape (m,)."""

    def loop(self, number: int) -> IntArray:
        """Return the sides of a border in their order, from its first side."""
        place = int(np.flatnonzero(self.border == number)[0])
        loop = [place]
        while self.following[loop[-1]] != place:
            loop.append(int(self.following[loop[-1]]))
        return self.sides[loop]


def borders_of(soup: Soup) -> ClosedBorders:
    """Find the borders of an oriented manifold surface."""
    sides = np.flatnonzero(open_sides(soup))
    side_from = np.zeros(len(soup.points), dtype=np.int64)
    side_from[soup.vertex[sides]] = np.arange(len(sides))  # One fan around a vertex has one border side from it.
    following = side_from[soup.head[sides]]
    return ClosedBorders(sides, linked_groups(len(sides), np.arange(len(sides)), following), following)


def fill_holes(soup: Soup, largest_hole: float, log: ActionLog) -> Soup:
    """Fill the holes below a perimeter.

    A hole of three or four sides is filled by one face, a larger one by triangles around its centre. A hole in which
    one of these faces has no area is not filled.

    Args:
        soup: faces that form an oriented manifold surface.
        largest_hole: perimeter below which a hole is filled [cm].
        log: takes the action.
    """
    borders = borders_of(soup)
    if not len(borders.sides):
        return soup
    for number in _small_holes(soup, borders, largest_hole):
        loop = borders.loop(int(number))
        patch = _patch(soup.points[soup.vertex[loop]])
        if patch:
            log.add("filled holes", [int(soup.source[loop].min())])
            soup = _with_patch(soup, soup.vertex[loop], soup.source[loop], patch)
    return soup


def _small_holes(soup: Soup, borders: ClosedBorders, largest_hole: float) -> IntArray:
    """Numbers of the borders that are holes to fill."""
    count = np.bincount(borders.border)
    perimeter = np.bincount(borders.border, soup.side_length[borders.sides])
    # A triangle is missing if three sides are no longer together than four usual edges.
    triangular = (count == 3) & (perimeter < 4.0 * median_edge(soup))
    component = component_of_faces(soup)
    area = np.bincount(component, soup.area)
    first = np.unique(borders.border, return_index=True)[1]
    around = area[component[soup.side_face[borders.sides[first]]]]
    # A border is an outline, no hole, if its component is hardly larger than the largest area that it can bound.
    return np.flatnonzero((triangular | (perimeter < largest_hole)) & (around > 1.5 * perimeter**2 / (4 * np.pi)))


def _patch(points: FloatArray) -> list[list[int]]:
    """Polygons that fill a hole.

    Args:
        points: positions along the border [cm], in the direction of the border sides, shape (n, 3).

    Returns:
        Places along the border of the corners of each polygon, ``CENTRE`` for the centre; an empty list if a polygon
        has no area.
    """
    count = len(points)
    around = [[(place + 1) % count, place, CENTRE] for place in range(count)]
    choices = [[[0, *range(count - 1, 0, -1)]], around] if count <= 4 else [around]
    positions = np.concatenate([points, points.mean(axis=0, keepdims=True)])
    for polygons in choices if count >= 3 else []:
        corners = np.array([place for polygon in polygons for place in polygon]) % (count + 1)
        start = np.concatenate([[0], np.cumsum([len(polygon) for polygon in polygons])])
        if not Soup(positions, start, corners, corners, np.arange(len(polygons))).without_area.any():
            return polygons
    return []


def _with_patch(soup: Soup, border: IntArray, source: IntArray, patch: list[list[int]]) -> Soup:
    """Add the polygons that fill a hole.

    Args:
        soup: the faces.
        border: vertices along the border of the hole, shape (n,).
        source: vertex of the input from which each border vertex comes, shape (n,).
        patch: places of the corners of each polygon, as ``_patch`` returns them.
    """
    places = np.array([place for polygon in patch for place in polygon])
    points, vertices = soup.points, np.append(border, len(soup.points))
    if (places == CENTRE).any():
        points = np.concatenate([points, points[border].mean(axis=0, keepdims=True)])
    ends = soup.start[-1] + np.cumsum([len(polygon) for polygon in patch])
    return replace(
        soup,
        points=points,
        start=np.concatenate([soup.start, ends]),
        vertex=np.concatenate([soup.vertex, vertices[places]]),
        source=np.concatenate([soup.source, np.append(source, -1)[places]]),
        origin=np.concatenate([soup.origin, np.full(len(patch), -1)]),
    )
