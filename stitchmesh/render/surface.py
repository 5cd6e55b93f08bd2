# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Drawing of meshes: faces, edges, and arrows along the wales."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import FloatArray, IntArray, Mesh, StitchMesh
from stitchmesh.render.lettering import INK, Colour

if TYPE_CHECKING:
    import pyvista

LIFT = 0.03
"""Distance of arrows and edges from the surface, divided by the mean side length; it keeps them visible."""
MOST_LINES = 12_000
"""Largest number of faces for which edges and arrows are drawn; more of them would cover the surface."""


def polygon_surface(mesh: Mesh) -> pyvista.PolyData:
    """Return the faces with smooth normals; every corner is a separate point, so that lattice images need no seam."""
    import pyvista

    sizes = np.diff(mesh.face_start)
    polygons = np.insert(np.arange(mesh.side_count), mesh.face_start[:-1], sizes)
    surface = pyvista.PolyData(mesh.corner_position.astype(np.float32), faces=polygons)
    surface.point_data["Normals"] = mesh.vertex_normal[mesh.face_vertex].astype(np.float32)
    surface.point_data.active_normals_name = "Normals"
    return surface


def add_faces(plotter: pyvista.Plotter, mesh: Mesh, colours: NDArray[np.uint8]) -> None:
    """Add the faces with one sRGB colour each, shape (F, 3)."""
    plotter.add_mesh(
        polygon_surface(mesh), scalars=colours, rgb=True, smooth_shading=True, ambient=0.32, diffuse=0.55, specular=0.0
    )


def add_edges(plotter: pyvista.Plotter, mesh: Mesh, width: float, opacity: float) -> None:
    """Add all edges as lines, unless they are too many.

    Args:
        plotter: the plotter.
        mesh: the mesh.
        width: width of the lines [pixels of the window].
        opacity: opacity of the lines, from 0 to 1.
    """
    if mesh.face_count <= MOST_LINES:
        add_lines(plotter, mesh, mesh.edge_side, INK, width, opacity)


def add_lines(
    plotter: pyvista.Plotter, mesh: Mesh, sides: IntArray, colour: str | Colour, width: float, opacity: float
) -> None:
    """Add sides as lines.

    Args:
        plotter: the plotter.
        mesh: the mesh.
        sides: the sides, shape (n,).
        colour: colour of the lines, a text or sRGB.
        width: width of the lines [pixels of the window].
        opacity: opacity of the lines, from 0 to 1.
    """
    import pyvista

    if not len(sides):
        return
    corners = np.stack([sides, mesh.side_next[sides]], axis=1)
    lines = np.insert(np.arange(2 * len(sides)), np.arange(0, 2 * len(sides), 2), 2)
    points = lifted_corners(mesh)[corners.ravel()].astype(np.float32)
    plotter.add_mesh(
        pyvista.PolyData(points, lines=lines), color=colour, line_width=width, opacity=opacity, lighting=False
    )


def add_arrowheads(plotter: pyvista.Plotter, arrowheads: FloatArray, opacity: float) -> None:
    """Add flat arrowheads, shape (n, 3, 3), with an opacity from 0 to 1."""
    import pyvista

    if not len(arrowheads):
        return
    triangles = np.arange(3 * len(arrowheads)).reshape(-1, 3)
    arrows = pyvista.PolyData.from_regular_faces(arrowheads.reshape(-1, 3).astype(np.float32), triangles)
    plotter.add_mesh(arrows, color=INK, lighting=False, opacity=opacity)


def wale_arrowheads(fabric: StitchMesh) -> FloatArray:
    """Return the tip and the two ends of the base of the arrowhead of each face [cm], shape (F, 3, 3)."""
    position = lifted_corners(fabric)
    first, last, right = fabric.face_start[:-1], fabric.face_start[1:] - 1, fabric.right_wale
    corners = position[first], position[right], position[right + 1], position[last]
    return arrowheads_in(*corners, tip=0.2, half_width=0.12)


def arrowheads_in(
    low_left: FloatArray, low_right: FloatArray, high_right: FloatArray, high_left: FloatArray, *, tip: float,
    half_width: float,
) -> FloatArray:  # fmt: skip
    """Return arrowheads in the middle of quads, which point from the low corners to the high ones, shape (n, 3, 3).

    Args:
        low_left: lower left corner of each quad [cm], shape (n, 3).
        low_right: lower right corner of each.
        high_right: upper right corner of each.
        high_left: upper left corner of each.
        tip: distance of the tip from the middle, over the height of the quad.
        half_width: half the width of the base, over the width of the quad.

    Returns:
        The tip and the two ends of the base of each arrowhead [cm].
    """
    bottom, top = (low_left + low_right) / 2, (high_right + high_left) / 2
    across = (low_right + high_right - low_left - high_left) / 2
    wale, middle = top - bottom, (bottom + top) / 2
    base = middle - 0.15 * wale
    return np.stack([middle + tip * wale, base - half_width * across, base + half_width * across], axis=1)


def lifted_corners(mesh: Mesh) -> FloatArray:
    """Return the position of each corner, shifted along the normal by ``LIFT`` [cm], shape (C, 3)."""
    height = LIFT * float(mesh.side_length.mean())
    return mesh.corner_position + height * mesh.vertex_normal[mesh.face_vertex]
