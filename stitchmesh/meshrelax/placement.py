# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Positions of the vertices of a fabric, and the constraint that says where they may move."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, TypeVar

from stitchmesh.mesh import FloatArray

VERTICES_OF_BLOCK = 8192
"""Vertices whose place, curvature, projector or stiffness is computed at once."""


@dataclass(frozen=True, eq=False)
class PlacedPoints:
    """Positions and normals of the points between which the forces act."""

    position: FloatArray
    """Positions of the points [cm], shape (P, 3); the points of a fabric without a lattice are its vertices."""
    normal: FloatArray
    """Unit normal at each point, shape (P, 3)."""


@dataclass(frozen=True, eq=False)
class SurfacePlacement(PlacedPoints):
    """Positions of the vertices of a fabric on a surface, and the geometry of the surface at the vertices.

    The normal of a border vertex is the normal of the surface beside the vertex.
    """

    shape: FloatArray
    """Shape operator, the derivative of the normal along the surface [1/cm], shape (V, 3, 3); zero at border
    vertices."""
    arc: FloatArray
    """Arc length of each border vertex along its border [cm], zero at inner vertices, shape (V,)."""
    tangent: FloatArray
    """Unit tangent of the border, zero at inner and fixed vertices, shape (V, 3)."""
    curvature: FloatArray
    """Curvature vector of the border: derivative of the tangent [1/cm], zero at inner vertices, shape (V, 3)."""
    outward: FloatArray
    """Unit direction off the surface, for inner vertices at its end, shape (V, 3); zero at all others, and everywhere
    if the constraint does not use it."""


P = TypeVar("P", bound=PlacedPoints)


class MeshConstraint(Protocol[P]):
    """Says where the unknowns of a relaxation may move. The unknowns of a fabric on a surface are its vertices."""

    def projector(self, placement: P, force: FloatArray) -> FloatArray:
        """Return the projector onto the allowed directions of each unknown, (U, 3, 3); forces have shape (U, 3)."""

    def within(self) -> MeshConstraint[P]:
        """Return the constraint under which no force presses an unknown over the end of its surface."""

    def turning_stiffness(self, placement: P, force: FloatArray) -> FloatArray:
        """Return the stiffness by the turning of the allowed directions [1/cm], (U, 3, 3); forces have shape (U, 3)."""

    def move(self, placement: P, step: FloatArray, stride: float) -> P:
        """Return the placement after a step of the unknowns [cm], shape (U, 3), in parts of at most ``stride`` [cm]."""
