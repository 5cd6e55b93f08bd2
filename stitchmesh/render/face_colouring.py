# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Colours of the faces of meshes: by yarn, row, stitch or stretch, or one colour."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.mesh.palette import colours_of
from stitchmesh.render.colour_scale import diverging_scale
from stitchmesh.render.colouring import LEAST_STRAIN, Coloured, one_colour, stitch_key
from stitchmesh.render.palette import stitch_colours
from stitchmesh.yarn.colours import row_colours

FACE_COLOUR_BY = ("stitch", "row", "yarn", "stretch")
"""What can decide the colours of the faces of a stitch mesh, besides one colour."""


def colour_faces(mesh: Mesh, colour: str) -> Coloured:
    """Return the colour of each face.

    Args:
        mesh: a stitch mesh, or a polygon mesh, whose faces can have one colour only.
        colour: a word of ``FACE_COLOUR_BY``, or one colour (``parse_colour``).

    Raises:
        ParameterError: the colour is unknown, or the mesh has nothing that decides it.
    """
    if colour not in FACE_COLOUR_BY:
        return Coloured(_everywhere(mesh, one_colour(colour)))
    if not isinstance(mesh, StitchMesh):
        raise ParameterError(f"colour: got {colour!r} for a polygon mesh, which has no {colour}s; give one colour")
    if colour == "stitch":
        return Coloured(stitch_colours(mesh.stitch, mesh.row), stitch_key(mesh, mesh.stitch))
    if colour == "row":
        return Coloured(row_colours(mesh.row))
    if colour == "yarn":
        return Coloured(colours_of(mesh.yarn, mesh.palette))
    return _by_stretch(mesh)


def _by_stretch(mesh: StitchMesh) -> Coloured:
    if mesh.face_stretch is None:
        raise ParameterError("stretch: the stitch mesh has none; relax the mesh first")
    values = mesh.face_stretch - 1.0
    scale = diverging_scale(values, LEAST_STRAIN)
    return Coloured(scale.of(values), scale.key(lambda mark: f"{100 * mark:+.1f} % stretch"), scale)


def _everywhere(mesh: Mesh, colour: NDArray[np.uint8]) -> NDArray[np.uint8]:
    return np.tile(colour, (mesh.face_count, 1))
