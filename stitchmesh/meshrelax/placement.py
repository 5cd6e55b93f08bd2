# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Where the vertices of a fabric are, and what a relaxation needs to know of the constraint that keeps them there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, TypeVar

from stitchmesh.mesh import FloatArray


@dataclass(frozen=True, eq=False)
class PlacedPoints:
    """Positions and normals of the points that the forces act between."""

    position: FloatArray
    """Positions of the points [cm], shape (P, 3); the points of a fabric without a lattice are its vertices."""
    normal: FloatArray
    """Unit normal at each point, shape (P, 3)."""


@dataclass(frozen=True, eq=False)
class SurfacePlacement(PlacedPoints):
    """Positions of the vertices of a fabric on a surface, and the geometry of the surface at the vertices.

    The normal of a vertex on a border is that of the surface next to the vertex.
    """

    shape: FloatArray
    """Shape operator: derivative of the normal along the surface [1/cm], zero at border vertices, shape (V, 3, 3)."""
    arc: FloatArray
    """Arc length of each border vertex along its border [cm], zero at inner vertices, shape (V,)."""
    tangent: FloatArray
    """Unit tangent of the border, zero at inner and fixed vertices, shape (V, 3)."""
    curvature: FloatArray
    """Curvature vector of the border: derivative of the tangent [1/cm], zero at inner vertices, shape (V, 3)."""
    outward: FloatArray
    """Unit direction off the surface of each inner vertex at its end; zero elsewhere, and where it is not asked for,
    shape (V, 3)."""


P = TypeVar("P", bound=PlacedPoints)


class MeshConstraint(Protocol[P]):
    """Says where the unknowns of a relaxation may move. The unknowns of a fabric on a surface are its vertices."""

    def projector(self, placement: P, force: FloatArray) -> FloatArray:
        """Return the projector onto the allowed directions of each unknown, (U, 3, 3); forces have shape (U, 3)."""

    def within(self) -> MeshConstraint[P]:
        """Return the constraint under which no force presses an unknown against the end of what it lies on."""

    def turning_stiffness(self, placement: P, force: FloatArray) -> FloatArray:
        """Return the stiffness from allowed directions that turn [1/cm], shape (U, 3, 3); forces have shape (U, 3)."""

    def move(self, placement: P, step: FloatArray, stride: float) -> P:
        """Return the placement after a step of the unknowns [cm], shape (U, 3), in parts of at most ``stride`` [cm]."""
