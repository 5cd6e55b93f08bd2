# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stitches that were found on a surface, and the surface for the stages after them."""

from __future__ import annotations

from dataclasses import dataclass

from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.shaping.triangle_surface import TriangleSurface


@dataclass(frozen=True, eq=False)
class FoundStitches:
    """Stitches that were found on a surface."""

    fabric: StitchMesh
    """The stitches, before patterns."""
    given: TriangleSurface
    """The triangles of the mesh, from which the distance of the stitches is measured."""
    surface: TriangleSurface | None
    """The triangles of the mesh for mesh relaxation, without features finer than a stitch. None for stitches on panels
    and flat pieces, whose own faces are the surface."""

    @property
    def surface_mesh(self) -> Mesh:
        """The surface for mesh relaxation."""
        return faces_of(self.fabric) if self.surface is None else self.surface.mesh


def faces_of(fabric: StitchMesh) -> Mesh:
    """Return the faces of a stitch mesh as a surface."""
    return Mesh(fabric.vertices, fabric.face_start, fabric.face_vertex, fabric.twin)
