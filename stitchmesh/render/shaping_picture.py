# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Pictures of shaping: where stitches increase, decrease, turn and are grafted, and how they are stretched."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from stitchmesh.io.contents import FilePath
from stitchmesh.mesh import IntArray, StitchMesh
from stitchmesh.render.colouring import Coloured
from stitchmesh.render.fabric_pictures import look_at_mesh
from stitchmesh.render.face_colouring import colour_faces
from stitchmesh.render.labeling_drawing import MISMATCH_COLOUR
from stitchmesh.render.lettering import Colour
from stitchmesh.render.options import DEFAULTS, PICTURE_SIZE, PictureOptions, Size
from stitchmesh.render.stage import KEY_LEFT, picture
from stitchmesh.render.surface import add_edges, add_faces, add_lines
from stitchmesh.render.two_views import two_views

if TYPE_CHECKING:
    import pyvista


def render_shaping(
    fabric: StitchMesh, path: FilePath, figures: Mapping[str, Any], *, size: Size = PICTURE_SIZE
) -> None:  # fmt: skip
    """Draw the shaping of a fabric from the front and, if it is not flat, from the back.

    Increases, decreases and turns of short rows have colours of their own; the colours of all other stitches show their
    stretch. Thick lines are grafts.

    Args:
        fabric: the stitch mesh; without mesh relaxation no stretch is shown.
        path: a ``.png`` file; missing folders are created.
        figures: fields of a ``ShapingReport`` by name, for the caption.
        size: width and height [pixels].

    Raises:
        DisplayError: this machine cannot draw pictures.
        FileError: the suffix is not ``.png``, or the file cannot be written.
    """
    coloured, grafts = colour_faces(fabric, "irregular"), _grafts(fabric)
    views = two_views(fabric.corner_position, size)
    with picture(
        path, PictureOptions(size=size), panels=views.panels, caption=_caption(figures), key=_key(coloured, grafts)
    ) as plotter:  # fmt: skip
        for _ in views.shown(plotter):
            _add_fabric(plotter, fabric, coloured, grafts)


def render_irregular(fabric: StitchMesh, path: FilePath, options: PictureOptions = DEFAULTS) -> None:
    """Draw the shaping of a fabric from one side, as ``render_shaping`` does.

    Raises:
        DisplayError: this machine cannot draw pictures.
        FileError: the suffix is not ``.png``, or the file cannot be written.
    """
    coloured, grafts = colour_faces(fabric, "irregular"), _grafts(fabric)
    with picture(path, options, key=_key(coloured, grafts)) as plotter:
        _add_fabric(plotter, fabric, coloured, grafts)
        look_at_mesh(plotter, fabric, options, 1 - KEY_LEFT)


def _grafts(fabric: StitchMesh) -> IntArray:
    """Return one side of each edge at which wale directions differ."""
    return np.flatnonzero(fabric.mismatched & (np.arange(fabric.side_count) < fabric.twin))


def _key(coloured: Coloured, grafts: IntArray) -> list[tuple[str, Colour]]:
    own = [(f"grafted edges  {len(grafts)}", MISMATCH_COLOUR)] if len(grafts) else []
    return [*own, *coloured.key]


def _caption(figures: Mapping[str, Any]) -> str:
    stretch = figures["rms_stretch"]
    return (
        f"{figures['stitches']:,} stitches in {figures['rows']:,} rows, {figures['irregular_per_thousand']:.3g} in a "
        f"thousand irregular, {figures['short_rows']} short rows; off the surface by {figures['rms_distance']:.2g} "
        f"(rms) to {figures['largest_distance']:.2g} stitch widths"
        + ("" if stretch is None else f"; rms stretch {100 * stretch:.2g} %")
    )


def _add_fabric(plotter: pyvista.Plotter, fabric: StitchMesh, coloured: Coloured, grafts: IntArray) -> None:
    """Add the faces in their colours, their edges if these are not too many, and the grafts as thick lines."""
    add_faces(plotter, fabric, coloured.points)
    add_edges(plotter, fabric, 1.0, 0.25)
    add_lines(plotter, fabric, grafts, MISMATCH_COLOUR, 9.0, 1.0)
