# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""One panel as a surface of fine triangles that keep their texture coordinates."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mesh.face_triangles import face_triangles
from stitchmesh.shaping.panels.panel_mesh import PanelMesh
from stitchmesh.shaping.triangle_surface import MOST_TRIANGLES, TriangleSurface


@dataclass(frozen=True, eq=False)
class RefinedPanel:
    """A panel, divided into fine triangles."""

    surface: TriangleSurface
    """The triangles."""
    texture: FloatArray
    """Texture coordinates of each vertex of the surface, shape (n, 2)."""
    own: IntArray
    """Vertices of the panel mesh that are the first vertices of the surface, ascending, shape (m,)."""

    @property
    def flat(self) -> FloatArray:
        """Positions of the vertices in the flat pattern, scaled to the size in space [cm], shape (n, 2)."""
        a, b, c = (self.texture[self.surface.triangles[:, corner]] for corner in range(3))
        area = 0.5 * np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]).sum()
        return self.texture * np.sqrt(self.surface.area.sum() / max(float(area), np.finfo(np.float64).tiny))

    def place(self, vertex: int) -> int:
        """Return the vertex of the surface that a vertex of the panel mesh became."""
        return int(np.searchsorted(self.own, vertex))


def refined_panel(panels: PanelMesh, panel: int, longest_edge: float) -> RefinedPanel:
    """Divide a panel into triangles whose edges are at most ``longest_edge`` long [cm]."""
    mesh = panels.mesh
    divided = face_triangles(mesh)
    corners = divided.corners[panels.face_panel[divided.face] == panel]
    own, triangles = np.unique(mesh.face_vertex[corners], return_inverse=True)
    points = np.concatenate([mesh.vertices[own], panels.texture[own]], axis=1)
    points, triangles = refined(points, triangles.reshape(-1, 3), longest_edge)
    return RefinedPanel(TriangleSurface(np.ascontiguousarray(points[:, :3]), triangles), points[:, 3:], own)


def refined(points: FloatArray, triangles: IntArray, longest_edge: float) -> tuple[FloatArray, IntArray]:
    """Divide triangles until no edge is longer than a length.

    In each round, the edges that are the longest of all triangles beside them are divided into halves, so that the
    surface stays closed and triangles do not become thin (Rivara 1984).

    Args:
        points: positions [cm] and any further coordinates of the vertices, shape (V, 3 + k).
        triangles: vertices of each triangle, shape (T, 3).
        longest_edge: length of an edge that is not divided any more [cm].
    """
    while len(triangles) < MOST_TRIANGLES:
        ends = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2)
        edges, edge = np.unique(np.sort(ends.reshape(-1, 2), axis=1), axis=0, return_inverse=True)
        edge = edge.reshape(-1, 3)
        length = np.linalg.norm(points[edges[:, 1], :3] - points[edges[:, 0], :3], axis=1)
        if not (length > longest_edge).any():
            break
        points, triangles = _halved(points, triangles, edges, edge, _longest_beside(length, edge, longest_edge))
    return points, triangles


def _longest_beside(length: FloatArray, edge: IntArray, longest_edge: float) -> np.ndarray:
    """Whether each edge is too long and the longest edge of all triangles beside it, shape (E,).

    Of equally long edges the first one counts as the longest.
    """
    rank = np.empty(len(length), dtype=np.int64)
    rank[np.lexsort((-np.arange(len(length)), length))] = np.arange(len(length))
    beaten = np.zeros(len(length), dtype=bool)
    beaten[edge[rank[edge] < rank[edge].max(axis=1, keepdims=True)]] = True
    return ~beaten & (length > longest_edge)


def _halved(
    points: FloatArray, triangles: IntArray, edges: IntArray, edge: IntArray, chosen: np.ndarray
) -> tuple[FloatArray, IntArray]:
    """Divide the chosen edges and the triangles beside them; each triangle has at most one of them."""
    middle = np.where(chosen, len(points) + np.cumsum(chosen) - 1, -1)
    cut = chosen[edge]
    divided = cut.any(axis=1)
    turn = (cut[divided].argmax(axis=1)[:, None] + np.arange(3)) % 3
    a, b, c = np.take_along_axis(triangles[divided], turn, axis=1).T
    new = middle[edge[divided][cut[divided]]]
    halves = [np.stack(corners, axis=1) for corners in ((a, new, c), (new, b, c))]
    return np.concatenate([points, points[edges[chosen]].mean(axis=1)]), np.concatenate([triangles[~divided], *halves])
