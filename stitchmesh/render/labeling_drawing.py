# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The contents of pictures of a partly labeled mesh, as arrays: colours of faces, and arrows along the wales."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stitchmesh.labeling import PartialLabeling
from stitchmesh.mesh import FloatArray, IntArray, Mesh
from stitchmesh.render.lettering import Colour
from stitchmesh.render.surface import arrowheads_in, lifted_corners
from stitchmesh.yarn.colours import row_colours

UNLABELED_COLOUR: Colour = (196, 194, 190)
"""Colour of faces without a row, sRGB."""
FAULT_COLOUR: Colour = (205, 30, 38)
"""Colour of faces that cannot be labeled, sRGB."""
MISMATCH_COLOUR: Colour = (214, 66, 176)
"""Colour of the edges at which two wale directions do not match, sRGB."""


def faces_at_fault(labeling: PartialLabeling) -> IntArray:
    """Return the faces that cannot be labeled, in ascending order, shape (n,)."""
    return np.unique(np.array([face for fault in labeling.faults for face in fault.faces], dtype=np.int64))


def labeling_colours(labeling: PartialLabeling, at_fault: IntArray) -> NDArray[np.uint8]:
    """Return the colour of each face, sRGB, shape (F, 3): the colour of its row, grey without a row, red at fault."""
    colours = np.tile(np.array(UNLABELED_COLOUR, dtype=np.uint8), (labeling.mesh.face_count, 1))
    labeled = labeling.labeled
    if labeled.any():
        colours[labeled] = row_colours(labeling.row_number()[labeling.row[labeled]])
    colours[at_fault] = FAULT_COLOUR
    return colours


def labeling_arrowheads(labeling: PartialLabeling) -> FloatArray:
    """Return the tip and the two ends of the base of an arrowhead along the wale of each labeled face [cm].

    Arrowheads stand a little in front of the faces. On a large mesh only some faces have one. Shape (n, 3, 3).
    """
    faces = np.flatnonzero(labeling.labeled)
    faces = faces[:: -(-len(faces) // 6_000) or 1]  # On a large mesh only some faces have an arrow.
    mesh = labeling.mesh
    left, right = (wale[faces] for wale in labeling.directed_wales())
    position = lifted_corners(mesh) + _height_of_bulge(mesh)[mesh.side_face]
    low_left, low_right = position[mesh.side_next[left]], position[right]
    high_right, high_left = position[mesh.side_next[right]], position[left]
    return arrowheads_in(low_left, low_right, high_right, high_left, tip=0.22, half_width=0.14)


def _height_of_bulge(mesh: Mesh) -> FloatArray:
    """Return how far the corners of each face stand off its plane, as a vector along its normal [cm], shape (F, 3)."""
    first, size = mesh.face_start[:-1], np.diff(mesh.face_start)
    middle = np.add.reduceat(mesh.corner_position, first, axis=0) / size[:, None]
    normal = mesh.face_vector_area / np.linalg.norm(mesh.face_vector_area, axis=1, keepdims=True)
    height = np.einsum("ij,ij->i", mesh.corner_position - middle[mesh.side_face], normal[mesh.side_face])
    return np.maximum.reduceat(np.abs(height), first)[:, None] * normal
