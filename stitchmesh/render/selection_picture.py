# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Picture of selections: the faces of each in its own colour."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from stitchmesh.io.contents import FilePath
from stitchmesh.mesh import IntArray, StitchMesh
from stitchmesh.render.camera import camera_around
from stitchmesh.render.options import PICTURE_SIZE, PictureOptions, Size
from stitchmesh.render.stage import KEY_LEFT, look, picture
from stitchmesh.render.surface import add_faces

SELECTED = (
    (196, 62, 52), (58, 92, 176), (72, 146, 78), (224, 166, 52), (132, 78, 160), (46, 150, 160), (206, 112, 150),
    (120, 96, 66),
)  # fmt: skip
"""Colours of selections (sRGB), repeated in this order."""
LONGEST_TEXT = 34
"""Number of characters of a selection for which the legend has space."""
ODD_ROW = 0.86
"""Brightness of odd rows, so that rows can be counted."""
VIEW = np.array([0.25, 0.15, 1.0]) / np.linalg.norm([0.25, 0.15, 1.0])
"""Direction from the fabric to the camera: in front, a little from the wearer's left and from above."""


def render_selections(
    fabric: StitchMesh, selections: Mapping[str, IntArray], path: FilePath, *, size: Size = PICTURE_SIZE
) -> None:
    """Draw a stitch mesh with its selections in colours; a later selection covers an earlier one.

    Args:
        fabric: the stitch mesh.
        selections: faces of each selection, by the text of the legend.
        path: a ``.png`` file.
        size: width and height [pixels].

    Raises:
        DisplayError: this machine cannot draw pictures.
        FileError: the suffix is not ``.png``, or the file cannot be written.
    """
    # Faces of no selection are grey.
    colours = np.tile(np.array((206, 203, 196), dtype=np.float64), (fabric.face_count, 1))
    key = []
    for number, (text, faces) in enumerate(selections.items()):
        colour = SELECTED[number % len(SELECTED)]
        colours[faces] = colour
        key.append((text if len(text) <= LONGEST_TEXT else f"{text[: LONGEST_TEXT - 3]}...", colour))
    colours[fabric.row % 2 == 1] *= ODD_ROW
    with picture(path, PictureOptions(size=size), caption=f"{fabric.face_count} stitches", key=key) as plotter:
        add_faces(plotter, fabric, colours.astype(np.uint8))
        points, up = fabric.corner_position, np.array([0.0, 1.0, 0.0])
        look(plotter, camera_around(points, VIEW, up, size[0] / size[1], part=(KEY_LEFT, 1.0)))
        plotter.camera.SetWindowCenter(1 - KEY_LEFT, 0.0)
