# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Brushes over a cloth: which triangles a click or a drag covers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, get_args

import numpy as np

from stitchmesh.mesh import BORDER, FloatArray, IntArray
from stitchmesh.mesh.picking import PickedPlace
from stitchmesh.mixed.cloth.cloth import Cloth, border_sides

ClothBrush = Literal["Circle", "Triangle", "Border", "Panel"]
BRUSHES: tuple[ClothBrush, ...] = get_args(ClothBrush)


def covered_triangles(
    cloth: Cloth, vertices: FloatArray, brush: ClothBrush, path: Sequence[PickedPlace], radius: float
) -> IntArray:
    """Return the triangles that a brush covers, ascending.

    Args:
        cloth: the cloth.
        vertices: where its vertices are shown [cm], shape (V, 3).
        brush: ``Triangle``, the ``Panel`` of each triangle, the side of the ``Border`` that is nearest to each place,
            or a ``Circle`` around it. A circle stays on the cloth: another layer behind it is not painted.
        path: places under the pointer.
        radius: radius of the circle [cm].
    """
    faces = np.unique(np.array([place.face for place in path], dtype=np.int64))
    if brush == "Triangle":
        return faces
    if brush == "Panel":
        return np.flatnonzero(np.isin(cloth.panel, cloth.panel[faces]))
    if brush == "Border":
        return _along_border(cloth, vertices, path)
    centre = vertices[cloth.triangles].mean(axis=1)
    covered: set[int] = set()
    for place in path:
        covered.update(_connected_within(cloth, centre, place, radius))
    return np.array(sorted(covered), dtype=np.int64)


def _along_border(cloth: Cloth, vertices: FloatArray, path: Sequence[PickedPlace]) -> IntArray:
    """The triangles that have an edge on the side of the border nearest to each place; none if there is no border."""
    parts = border_sides(cloth)
    found = [np.zeros(0, dtype=np.int64)]
    for place in path if parts else ():
        distance = [
            np.linalg.norm(vertices[cloth.side_vertices[part]].mean(axis=1) - place.point, axis=1).min()
            for part in parts
        ]
        found.append(parts[int(np.argmin(distance))] // 3)
    return np.unique(np.concatenate(found))


def _connected_within(cloth: Cloth, centre: FloatArray, place: PickedPlace, radius: float) -> set[int]:
    """The triangle at a place, and those that it leads to across edges without leaving a ball around the place."""
    near = np.linalg.norm(centre - place.point, axis=1) <= radius
    found, edge = {place.face}, [place.face]
    while edge:
        beside = cloth.twin.reshape(-1, 3)[np.array(edge)].ravel()
        beside = np.unique(beside[beside != BORDER] // 3)
        edge = [face for face in beside[near[beside]].tolist() if face not in found]
        found.update(edge)
    return found
