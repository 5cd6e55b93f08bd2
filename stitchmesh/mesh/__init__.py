# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Polygon meshes and stitch meshes, with their connectivity, courses, cables, stitches and changes."""

from stitchmesh.mesh.polygon_mesh import BORDER, FloatArray, IntArray, Mesh, extent, frozen_array, ranges
from stitchmesh.mesh.stitch_mesh import BOTTOM, LEFT, PER_FACE, PER_SIDE, RIGHT, TOP, StitchMesh

__all__ = [
    "BORDER",
    "BOTTOM",
    "LEFT",
    "PER_FACE",
    "PER_SIDE",
    "RIGHT",
    "TOP",
    "FloatArray",
    "IntArray",
    "Mesh",
    "StitchMesh",
    "extent",
    "frozen_array",
    "ranges",
]
