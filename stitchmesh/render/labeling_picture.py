# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Picture of a partly labeled mesh: its rows, their wale directions, the seams that do not match, and the faults."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stitchmesh.io.contents import FilePath
from stitchmesh.labeling import PartialLabeling
from stitchmesh.labeling.growth import COURSE
from stitchmesh.mesh import FloatArray, IntArray, Mesh
from stitchmesh.render.camera import camera_around, picture_axes
from stitchmesh.render.labeling_drawing import (
    FAULT_COLOUR,
    MISMATCH_COLOUR,
    UNLABELED_COLOUR,
    faces_at_fault,
    labeling_arrowheads,
    labeling_colours,
)
from stitchmesh.render.lettering import INK, Colour
from stitchmesh.render.options import PictureOptions
from stitchmesh.render.stage import KEY_LEFT, PAPER, WHOLE, Viewport, look, picture
from stitchmesh.render.surface import add_faces, lifted_corners
from stitchmesh.render.view import FLAT, view_directions

if TYPE_CHECKING:
    import pyvista

PANELS = KEY_LEFT - 0.01
"""Width of the views, divided by the width of the picture; the legend is beside them."""
SIZE = (1600, 1000)
"""Default width and height of the picture [pixels]."""


def render_labeling(
    labeling: PartialLabeling, path: FilePath, *, size: tuple[int, int] = SIZE, back: bool = True
) -> None:
    """Draw a partly labeled mesh from the front and, if it is not flat, from the back.

    Rows have different colours and an arrow along the wale in each face. Faces without a row are grey, and faces that
    cannot be labeled are red. Thick lines are course edges; seams at which the wale directions do not match are marked.

    Args:
        labeling: the partly labeled mesh, with y upwards.
        path: a ``.png`` file; missing folders are created.
        size: width and height [pixels].
        back: whether to draw the back too.

    Raises:
        DisplayError: this machine cannot draw pictures.
        FileError: the suffix is not ``.png``, or the file cannot be written.
    """
    mesh, at_fault = labeling.mesh, faces_at_fault(labeling)
    mismatched = labeling.mismatched_sides()
    towards, up = view_directions(mesh.corner_position)
    extent = np.sort(np.ptp(mesh.corner_position, axis=0))
    views = [towards, -towards] if back and extent[0] > FLAT * extent[1] else [towards]
    panels = _panels(mesh, towards, up, size, len(views))
    aspect = size[0] * (panels[0][2] - panels[0][0]) / (size[1] * (panels[0][3] - panels[0][1]))
    key = _key(labeling, at_fault, mismatched)
    options, caption = PictureOptions(size=size), _caption(labeling, at_fault)
    with picture(path, options, panels=(WHOLE, *panels), caption=caption, key=key) as plotter:
        plotter.set_background(PAPER)  # One colour, so that the panels have no visible borders.
        for number, direction in enumerate(views, start=1):
            plotter.subplot(0, number)
            add_faces(plotter, mesh, labeling_colours(labeling, at_fault))
            _add_edges(plotter, labeling, mismatched)
            _add_arrows(plotter, labeling)
            look(plotter, camera_around(mesh.corner_position, direction, up, aspect))


def _panels(mesh: Mesh, towards: FloatArray, up: FloatArray, size: tuple[int, int], count: int) -> tuple[Viewport, ...]:
    """The panels of one or two views: one beside the other, or one above the other if the mesh is larger then."""
    if count == 1:
        return ((0.0, 0.0, PANELS, 1.0),)
    width, height, _ = np.ptp(mesh.corner_position @ picture_axes(towards, up), axis=0)
    free = PANELS * size[0] / width, size[1] / height  # Pixels per cm for one view in the whole free part.
    if min(free[0] / 2, free[1]) > min(free[0], free[1] / 2):
        return (0.0, 0.0, PANELS / 2, 1.0), (PANELS / 2, 0.0, PANELS, 1.0)
    return (0.0, 0.5, PANELS, 1.0), (0.0, 0.0, PANELS, 0.5)


def _caption(labeling: PartialLabeling, at_fault: IntArray) -> str:
    labeled = np.count_nonzero(labeling.labeled)
    faults = f", {len(at_fault)} at fault" if len(at_fault) else ""
    return f"{labeling.row_count} rows; {labeled} of {labeling.mesh.face_count} faces labeled{faults}"


def _key(labeling: PartialLabeling, at_fault: IntArray, mismatched: IntArray) -> list[tuple[str, Colour]]:
    entries = [("no row yet", UNLABELED_COLOUR)] if not labeling.labeled.all() else []
    if len(at_fault):
        entries.append((f"at fault  {len(at_fault)}", FAULT_COLOUR))
    if len(mismatched):
        entries.append(("wales do not match", MISMATCH_COLOUR))
    return entries


def _add_edges(plotter: pyvista.Plotter, labeling: PartialLabeling, mismatched: IntArray) -> None:
    """Add all edges as thin lines, course edges as thick lines, and the seams that do not match in their colour."""
    mesh = labeling.mesh
    _add_lines(plotter, mesh, mesh.edge_side, INK, 1.0, 0.3)
    _add_lines(plotter, mesh, mesh.edge_side[labeling.edge_label == COURSE], INK, 3.5, 0.9)
    _add_lines(plotter, mesh, mismatched, MISMATCH_COLOUR, 9.0, 1.0)


def _add_lines(
    plotter: pyvista.Plotter, mesh: Mesh, sides: IntArray, colour: str | Colour, width: float, opacity: float
) -> None:
    """Add sides as lines of a width [pixels of the window]."""
    import pyvista

    if not len(sides):
        return
    corners = np.stack([sides, mesh.side_next[sides]], axis=1)
    lines = np.insert(np.arange(2 * len(sides)), np.arange(0, 2 * len(sides), 2), 2)
    points = lifted_corners(mesh)[corners.ravel()].astype(np.float32)
    plotter.add_mesh(
        pyvista.PolyData(points, lines=lines), color=colour, line_width=width, opacity=opacity, lighting=False
    )


def _add_arrows(plotter: pyvista.Plotter, labeling: PartialLabeling) -> None:
    """Add an arrowhead along the wale to each labeled face, or to some faces of a large mesh."""
    import pyvista

    points = labeling_arrowheads(labeling)
    if not len(points):
        return
    triangles = np.arange(3 * len(points)).reshape(-1, 3)
    arrows = pyvista.PolyData.from_regular_faces(points.reshape(-1, 3).astype(np.float32), triangles)
    plotter.add_mesh(arrows, color=INK, lighting=False, opacity=0.85)
