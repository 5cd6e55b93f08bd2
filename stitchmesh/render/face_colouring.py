# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Colours of the faces of meshes: by yarn, row, stitch, stretch or irregular stitches, or one colour."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray, Mesh, StitchMesh
from stitchmesh.mesh.palette import colours_of
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.render.colour_scale import diverging_scale
from stitchmesh.render.colouring import LEAST_STRAIN, Coloured, one_colour, stitch_key
from stitchmesh.render.lettering import Colour
from stitchmesh.render.palette import stitch_colour, stitch_colours
from stitchmesh.shaping.report import irregular_faces
from stitchmesh.yarn.colours import row_colours

FACE_COLOUR_BY = ("stitch", "row", "yarn", "stretch", "irregular")
"""The words that choose what the colours of the faces of a stitch mesh show, besides one colour."""
IRREGULAR: dict[str, Colour] = {"increases": (240, 176, 24), "decreases": (24, 138, 92), "turns": (110, 44, 140)}
"""Colours of stitches that change the number of loops, and of stitches at turns of short rows, sRGB."""


def colour_faces(mesh: Mesh, colour: str) -> Coloured:
    """Return the colour of each face.

    Args:
        mesh: a stitch mesh, or a polygon mesh, whose faces can have one colour only.
        colour: a word of ``FACE_COLOUR_BY``, or one colour (``parse_colour``).

    Raises:
        ParameterError: the colour is unknown, or the mesh lacks the values that decide it.
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
    if colour == "irregular":
        return _by_irregularity(mesh)
    if mesh.face_stretch is None:
        raise ParameterError("stretch: the stitch mesh has none; relax the mesh first")
    return _by_stretch(mesh.face_stretch - 1.0, "stretch")


def _by_stretch(values: FloatArray, name: str) -> Coloured:
    scale = diverging_scale(values, LEAST_STRAIN)
    return Coloured(scale.of(values), scale.key(lambda mark: f"{100 * mark:+.1f} % {name}"), scale)


def _by_irregularity(mesh: StitchMesh) -> Coloured:
    """Colour irregular stitches; colour all others by their stretch from the mean if the mesh is relaxed."""
    ground = Coloured(_everywhere(mesh, np.array(stitch_colour(Stitch.KNIT), dtype=np.uint8)))
    if mesh.face_stretch is not None:
        ground = _by_stretch(mesh.face_stretch / mesh.face_stretch.mean() - 1.0, "from mean stretch")
    irregular = irregular_faces(mesh)
    more, fewer = mesh.n_top > mesh.n_bottom, mesh.n_top < mesh.n_bottom
    colours, key = ground.points.copy(), []
    for (name, colour), chosen in zip(IRREGULAR.items(), (more, fewer, irregular & ~(more | fewer)), strict=True):
        colours[chosen] = colour
        key += [(f"{name}  {chosen.sum()}", colour)] if chosen.any() else []
    return Coloured(colours, (*key, *ground.key), ground.scale)


def _everywhere(mesh: Mesh, colour: NDArray[np.uint8]) -> NDArray[np.uint8]:
    return np.tile(colour, (mesh.face_count, 1))
