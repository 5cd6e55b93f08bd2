# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stitches that were found on a surface, and the surface for the stages after them."""

from __future__ import annotations

from dataclasses import dataclass

from stitchmesh.mesh import StitchMesh
from stitchmesh.shaping.triangle_surface import TriangleSurface


@dataclass(frozen=True, eq=False)
class FoundStitches:
    """Stitches that were found on a surface."""

    fabric: StitchMesh
    """The stitches, before patterns."""
    given: TriangleSurface
    """The triangles of the mesh, from which the distance of the stitches is measured."""
    surface: TriangleSurface
    """The triangles for mesh relaxation: those of the mesh without features finer than a stitch, or panels that are
    closed along the seams at which their stitches are joined."""
