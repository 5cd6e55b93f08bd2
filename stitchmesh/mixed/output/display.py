# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Positions for display: smooth triangles outside the region, and yarns everywhere.

Outside the full-yarn region the triangles are subdivided (``loop_subdivision``), and the yarn nodes that are not
simulated lie on the subdivided surface (Casafranca et al. 2020, section 6.1). Loop's rules need two corrections. First,
they leave the vertices on the inner side of a curved surface. L is therefore their matrix times 2 - L_v, with the rows
L_v of the vertices, which undoes most of this. Second, they move points of a flat but irregular mesh within its plane,
and straight yarns with them. Points are therefore moved only along the interpolated normal n of the surface,

    x = B v + n (n . (L v - B v))        with the place B v on the triangles.

Control points of B-spline yarns stand above these places by their heights, along n.

In the hybrid region, the display shows alpha times the simulated place of a node plus 1 - alpha times its place on the
surface, so that nothing jumps where the full-yarn region (alpha = 1) or the triangles (alpha = 0) begin.

A vertex whose triangles are all full-yarn triangles has no position of its own, because only yarns are simulated there.
For display and for normals, ``CoveredVertices`` places it so that the triangles follow the yarn nodes. A run that goes
on with another region places it by ``region_change`` instead: velocities, which have no initial shape, move in
the same way there, while a display must not depend on what the run did before. The positions v of these vertices
minimize

    sum over the nodes in their triangles of |p_i - (B v)_i|^2 + e sum over their triangles of |D v - D r|^2

where D v are the differences between the corners of a triangle and D r the same differences in the initial shape. The
second sum places vertices whose triangles hold too few nodes.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mesh.arrays import unit_vectors
from stitchmesh.mixed.cloth.cloth import Cloth, vertex_normals
from stitchmesh.mixed.enrichment.region import YARNS, Region, basis_of
from stitchmesh.mixed.layout.curves import yarn_curves
from stitchmesh.mixed.layout.spline_yarns import LaidYarns, SplineYarns
from stitchmesh.mixed.output.frames import DrapeFrame
from stitchmesh.mixed.output.loop_subdivision import Subdivision, loop_subdivision
from stitchmesh.yarn import YarnSet

SOFTNESS = 1e-4
"""The number e: it is small, so it decides only what the nodes leave undetermined."""
ROUNDS = 2
"""Default number of rounds of subdivision."""


class CoveredVertices:
    """The vertices without a position of their own; the matrix of their positions is factored once."""

    def __init__(self, cloth: Cloth, region: Region) -> None:
        """Factor the matrix.

        Args:
            cloth: the cloth; its initial shape decides what the nodes leave undetermined.
            region: the region of interest.
        """
        self.covered: IntArray = np.flatnonzero(~region.unknown_vertices)
        """Vertices that are placed, ascending, shape (n,)."""
        self._known = np.flatnonzero(region.unknown_vertices)
        if not len(self.covered):
            return
        basis = basis_of(region.triangles[region.node_triangle], region.node_weight, len(cloth.vertices))
        near = np.flatnonzero(abs(basis[:, self.covered]).sum(axis=1) > 0.0)
        self._nodes, self._basis = near, csr_array(basis[near])
        self._sides = _side_differences(cloth, self.covered)
        self._initial = self._sides @ cloth.vertices
        self._solve = self._factored()

    def placed(self, vertices: FloatArray, nodes: FloatArray) -> FloatArray:
        """Return the positions of all vertices; the nodes determine the covered ones; shape (V, 3).

        Args:
            vertices: positions of the vertices [cm], shape (V, 3).
            nodes: positions of all nodes of the layout [cm], shape (N, 3); only those near covered vertices are used.
        """
        if not len(self.covered):
            return vertices
        known = np.zeros_like(vertices)
        known[self._known] = vertices[self._known]
        right = self._basis[:, self.covered].T @ (nodes[self._nodes] - self._basis @ known)
        right += SOFTNESS * (self._sides[:, self.covered].T @ (self._initial - self._sides @ known))
        known[self.covered] = self._solve(right)
        return known

    def _factored(self) -> Any:
        from scipy.sparse.linalg import splu

        of_nodes, of_sides = self._basis[:, self.covered], self._sides[:, self.covered]
        square = of_nodes.T @ of_nodes + SOFTNESS * (of_sides.T @ of_sides)
        return splu(square.tocsc()).solve


def _side_differences(cloth: Cloth, covered: IntArray) -> csr_array:
    """Differences between the ends of all sides of triangles with a covered vertex, shape (sides, V)."""
    touched = np.isin(cloth.side_vertices, covered).any(axis=1)
    ends = cloth.side_vertices[touched]
    rows, values = np.repeat(np.arange(len(ends)), 2), np.tile([-1.0, 1.0], len(ends))
    return csr_array((values, (rows, ends.ravel())), shape=(len(ends), len(cloth.vertices)))


@dataclass(frozen=True, eq=False)
class Shown:
    """A state for display."""

    vertices: FloatArray
    """Vertices of the cloth [cm], shape (V, 3); the nodes place the vertices of the full-yarn region."""
    nodes: FloatArray
    """Yarn nodes [cm], shape (N, 3)."""
    surface: FloatArray
    """Vertices of the subdivided triangles outside the full-yarn region [cm], shape (W, 3)."""


class Display:
    """The maps from a state to its display, for one cloth and one region."""

    def __init__(self, cloth: Cloth, yarns: LaidYarns, region: Region, rounds: int = ROUNDS) -> None:
        """Make the maps.

        Args:
            cloth: the cloth.
            yarns: yarns laid out everywhere on the cloth.
            region: the region of interest.
            rounds: number of rounds of subdivision.
        """
        self.cloth, self.yarns, self.region = cloth, yarns, region
        self._covered = CoveredVertices(cloth, region)
        outside = np.flatnonzero(region.triangle_kind != YARNS)
        divided = loop_subdivision(region.triangles[outside], len(cloth.vertices), rounds)
        used, triangles = np.unique(divided.triangles, return_inverse=True)
        self.triangles: IntArray = triangles.reshape(-1, 3)
        """Vertices of the subdivided triangles, as rows of ``Shown.surface``, shape (4^rounds n, 3)."""
        self.parent: IntArray = np.repeat(outside, 4**rounds)
        """Triangle of the cloth of each subdivided triangle."""
        self._linear = csr_array(divided.linear[used])
        at_vertices = csr_array(divided.matrix[: len(cloth.vertices)])
        smooth = csr_array(2.0 * divided.matrix - divided.matrix @ at_vertices)
        self._change = csr_array(smooth[used] - self._linear)
        self._basis = basis_of(region.triangles[region.node_triangle], region.node_weight, len(cloth.vertices))
        self._node_change = self._changes_at_nodes(outside, divided, smooth)

    @property
    def surface_alpha(self) -> FloatArray:
        """The blending field at the vertices of the surface, shape (W,)."""
        alpha: FloatArray = self._linear @ self.region.vertex_alpha
        return alpha

    def at_surface(self, values: FloatArray) -> FloatArray:
        """Return values of the cloth triangles, shape (T,), averaged at the vertices of the surface, shape (W,)."""
        corners, repeated = self.triangles.ravel(), np.repeat(values[self.parent], 3)
        count = np.maximum(np.bincount(corners, minlength=self._linear.shape[0]), 1)
        means: FloatArray = np.bincount(corners, repeated, self._linear.shape[0]) / count
        return means

    def show(self, vertices: FloatArray, simulated: FloatArray) -> Shown:
        """Return positions for display.

        Args:
            vertices: positions of the triangle vertices [cm], shape (V, 3).
            simulated: positions of the simulated nodes [cm], shape (n, 3).
        """
        places = self._basis @ vertices
        places[self.region.nodes] = simulated
        corners = self._covered.placed(vertices, places)
        normals = vertex_normals(self.cloth.triangles, corners)
        at_nodes = self._basis @ normals
        smooth = self._basis @ corners + _along_normals(at_nodes, self._node_change @ corners)
        if isinstance(self.yarns, SplineYarns):
            smooth += self.yarns.height[:, None] * unit_vectors(at_nodes)
        nodes = smooth + self.region.node_alpha[:, None] * (places - smooth)
        linear = self._linear @ corners
        change = _along_normals(self._linear @ normals, self._change @ corners)
        return Shown(corners, nodes, linear + (1.0 - self.surface_alpha)[:, None] * change)

    def curves(self, shown: Shown, radius: float | FloatArray, *, measured: bool = True) -> YarnSet:
        """Return the yarns as curves in space.

        Args:
            shown: the state.
            radius: radius of all yarns, or of each yarn [cm], shape (Y,).
            measured: as in ``yarn_curves``.
        """
        if isinstance(self.yarns, SplineYarns):
            return replace(self.yarns.curves, points=shown.nodes)
        return yarn_curves(
            self.cloth, self.yarns, radius=radius, nodes=shown.nodes, vertices=shown.vertices, measured=measured
        )

    def _changes_at_nodes(self, outside: IntArray, divided: Subdivision, smooth: csr_array) -> csr_array:
        """L - B at the nodes outside the full-yarn region, zero rows elsewhere, shape (N, V)."""
        number = np.full(len(self.region.triangles), -1)
        number[outside] = np.arange(len(outside))
        own = number[self.region.node_triangle]
        moved = np.flatnonzero(own >= 0)
        child, weight = divided.children(own[moved], self.region.node_weight[moved])
        within = basis_of(divided.triangles[child], weight, divided.matrix.shape[0])
        change = csr_array(within @ smooth - self._basis[moved]).tocoo()
        return csr_array((change.data, (moved[change.row], change.col)), shape=self._basis.shape)


def _along_normals(normals: FloatArray, change: FloatArray) -> FloatArray:
    """The part of displacements along normals."""
    unit = unit_vectors(normals)
    part: FloatArray = unit * (unit * change).sum(axis=1, keepdims=True)
    return part


class Displays:
    """The displays of a run whose region may change; the last one is kept and serves all frames of the same region."""

    def __init__(self, cloth: Cloth, yarns: LaidYarns, region: Region, rounds: int = ROUNDS) -> None:
        """Begin with the region at the start; the arguments are the same as for ``Display``."""
        self.cloth, self.yarns, self.rounds = cloth, yarns, rounds
        self._region = region
        self._made: Display | None = None  # made at the first use: it takes seconds for large runs, and some need none

    def of(self, frame: DrapeFrame) -> Display:
        """Return the display of a frame."""
        made = self._made  # another thread may ask for another frame in the meantime
        region = self._region if made is None else made.region
        same = np.array_equal(region.triangle_kind, frame.triangle_kind)
        if not (same and np.array_equal(region.vertex_alpha, frame.vertex_alpha)):
            region = replace(region, triangle_kind=frame.triangle_kind, vertex_alpha=frame.vertex_alpha)
        if made is None or region is not made.region:
            self._made = made = Display(self.cloth, self.yarns, region, self.rounds)
        return made

    def show(self, frame: DrapeFrame) -> Shown:
        """Return vertices, yarn nodes and smooth surface of a frame [cm]."""
        return self.of(frame).show(frame.vertices, frame.nodes)
