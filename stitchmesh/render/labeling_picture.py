# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Picture of a partly labeled mesh: its rows, their wale directions, the seams that do not match, and the faults."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stitchmesh.io.contents import FilePath
from stitchmesh.labeling import PartialLabeling
from stitchmesh.labeling.growth import COURSE
from stitchmesh.mesh import IntArray
from stitchmesh.render.labeling_drawing import (
    FAULT_COLOUR,
    MISMATCH_COLOUR,
    UNLABELED_COLOUR,
    faces_at_fault,
    labeling_arrowheads,
    labeling_colours,
)
from stitchmesh.render.lettering import INK, Colour
from stitchmesh.render.options import PICTURE_SIZE, PictureOptions, Size
from stitchmesh.render.stage import picture
from stitchmesh.render.surface import add_arrowheads, add_faces, add_lines
from stitchmesh.render.two_views import two_views

if TYPE_CHECKING:
    import pyvista


def render_labeling(
    labeling: PartialLabeling, path: FilePath, *, size: Size = PICTURE_SIZE, back: bool = True
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
    views = two_views(mesh.corner_position, size, back=back)
    key = _key(labeling, at_fault, mismatched)
    options, caption = PictureOptions(size=size), _caption(labeling, at_fault)
    with picture(path, options, panels=views.panels, caption=caption, key=key) as plotter:
        for _ in views.shown(plotter):
            add_faces(plotter, mesh, labeling_colours(labeling, at_fault))
            _add_edges(plotter, labeling, mismatched)
            add_arrowheads(plotter, labeling_arrowheads(labeling), 0.85)


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
    add_lines(plotter, mesh, mesh.edge_side, INK, 1.0, 0.3)
    add_lines(plotter, mesh, mesh.edge_side[labeling.edge_label == COURSE], INK, 3.5, 0.9)
    add_lines(plotter, mesh, mismatched, MISMATCH_COLOUR, 9.0, 1.0)
