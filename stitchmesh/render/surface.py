# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Drawing of meshes: faces, edges, and arrows along the wales."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import BORDER, FloatArray, IntArray, Mesh, StitchMesh
from stitchmesh.render.lettering import INK, Colour

if TYPE_CHECKING:
    import pyvista

LIFT = 0.03
"""Distance of arrows and edges from the surface, divided by the mean side length; it keeps them visible."""


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


def add_edges(plotter: pyvista.Plotter, mesh: Mesh, sides: NDArray[np.bool_], width: float, opacity: float) -> None:
    """Add the edges of the selected sides as lines, each edge once.

    Args:
        plotter: the plotter.
        mesh: the mesh.
        sides: whether each side is selected, shape (C,).
        width: width of the lines [pixels of the window].
        opacity: opacity of the lines, from 0 to 1.
    """
    chosen = np.flatnonzero(sides & ((mesh.twin == BORDER) | (np.arange(mesh.side_count) < mesh.twin)))
    add_lines(plotter, mesh, chosen, INK, width, opacity)


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


def add_wale_arrows(plotter: pyvista.Plotter, fabric: StitchMesh) -> None:
    """Add an arrowhead to each face; it points along the wale of the face."""
    import pyvista

    triangles = np.arange(3 * fabric.face_count).reshape(-1, 3)
    arrows = pyvista.PolyData.from_regular_faces(wale_arrowheads(fabric).reshape(-1, 3).astype(np.float32), triangles)
    plotter.add_mesh(arrows, color=INK, lighting=False, opacity=0.8)


def wale_arrowheads(fabric: StitchMesh) -> FloatArray:
    """Return the tip and the two ends of the base of the arrowhead of each face [cm], shape (F, 3, 3)."""
    position = lifted_corners(fabric)
    first, last, right = fabric.face_start[:-1], fabric.face_start[1:] - 1, fabric.right_wale
    bottom = (position[first] + position[right]) / 2
    top = (position[right + 1] + position[last]) / 2
    across = (position[right] + position[right + 1] - position[first] - position[last]) / 2
    wale = top - bottom
    middle = (bottom + top) / 2
    return np.stack(
        [middle + 0.2 * wale, middle - 0.15 * wale - 0.12 * across, middle - 0.15 * wale + 0.12 * across], 1
    )


def lifted_corners(mesh: Mesh) -> FloatArray:
    """Return the position of each corner, shifted along the normal by ``LIFT`` [cm], shape (C, 3)."""
    height = LIFT * float(mesh.side_length.mean())
    return mesh.corner_position + height * mesh.vertex_normal[mesh.face_vertex]
