# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What the nodes of all yarn models have in common: each one lies in a triangle of the cloth, or above it."""

from __future__ import annotations

from typing import Protocol

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mixed.cloth.cloth import Cloth


class NodesOnCloth(Protocol):
    """Y yarns with N nodes on a cloth."""

    @property
    def node_count(self) -> int:
        """Number N of nodes."""
        ...

    @property
    def yarn_count(self) -> int:
        """Number Y of yarns."""
        ...

    @property
    def panel(self) -> IntArray:
        """Panel of each node, shape (N,)."""
        ...

    @property
    def position(self) -> FloatArray:
        """Position of each node in its panel [cm], shape (N, 2)."""
        ...

    @property
    def triangle(self) -> IntArray:
        """Triangle of each node, shape (N,)."""
        ...

    @property
    def barycentric(self) -> FloatArray:
        """Barycentric coordinates of each node in its triangle, shape (N, 3)."""
        ...

    @property
    def yarn_start(self) -> IntArray:
        """First passage of each yarn, and their number at the end, shape (Y + 1,)."""
        ...

    @property
    def yarn_node(self) -> IntArray:
        """Node of each passage, yarn by yarn, shape (M,)."""
        ...

    @property
    def rest_sliding(self) -> FloatArray:
        """Eulerian coordinates at rest [cm], shape (N, 2); zeros for a model without them."""
        ...

    def world(self, cloth: Cloth, vertices: FloatArray | None = None) -> FloatArray:
        """Return the places of the nodes in space [cm], shape (N, 3)."""
        ...
