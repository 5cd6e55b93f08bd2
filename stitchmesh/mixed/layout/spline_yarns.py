# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns as B-splines on a cloth: each control point is a yarn node that lies off the triangles by its height.

Loops stand out of the plane of the cloth. A control point q is therefore given by a triangle, barycentric coordinates b
and a height h along the interpolated normal n of the cloth,

    q = B v + h n(b),

so that B holds only the barycentric coordinates, as for nodes within the triangles. Outside the enriched region this
formula places the yarn. In the hybrid region the height does not belong to B: there it belongs to F x, which turns with
the yarn (``enrichment.embedding``). If B contained the normals, the motions p = B v + F x would not be linear in v. If
E (v, p) kept the heights as constants, a cloth that turns would be strained.

``LaidYarns`` are yarns of either model, laid out on a cloth: with nodes at crossings, or with control points of
B-splines. Both have ``node_count`` nodes with a ``panel``, a ``position`` in it, a ``triangle`` and ``barycentric``
coordinates, a place in the ``world``, and Eulerian coordinates ``rest_sliding``; ``yarn_start`` and ``yarn_node`` list
the nodes of each yarn.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray, IntArray, frozen_array
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.layout.crossing_yarns import CrossingYarns
from stitchmesh.mixed.layout.curves import normals_at
from stitchmesh.mixed.layout.embedding import rest_positions, world_positions
from stitchmesh.yarn import YarnSet


@dataclass(frozen=True, eq=False, kw_only=True)
class SplineYarns:
    """Y yarns with N control points on a cloth.

    Raises:
        ParameterError: an array has the wrong shape, or the yarns repeat on a lattice.
    """

    curves: YarnSet
    """The yarns as they were laid out, with their rest lengths."""
    panel: IntArray
    """Panel of each control point, shape (N,)."""
    position: FloatArray
    """Position of the foot of each control point in its panel [cm], shape (N, 2)."""
    triangle: IntArray
    """Triangle of the cloth below each control point, shape (N,)."""
    barycentric: FloatArray
    """Barycentric coordinates of the foot, shape (N, 3); beyond a border of the cloth one of them is negative."""
    height: FloatArray
    """Distance of each control point from its foot along the normal [cm], shape (N,)."""

    def __post_init__(self) -> None:
        for name in ("position", "barycentric", "height"):
            object.__setattr__(self, name, frozen_array(getattr(self, name), np.float64))
        for name in ("panel", "triangle"):
            object.__setattr__(self, name, frozen_array(getattr(self, name), np.int64))
        n = self.node_count
        expected = {"panel": (n,), "position": (n, 2), "triangle": (n,), "barycentric": (n, 3), "height": (n,)}
        for name, shape in expected.items():
            found = getattr(self, name).shape
            if found != shape:
                raise ParameterError(f"spline yarns: {name}: got shape {found}; expected {shape}")
        if self.curves.lattice is not None:
            raise ParameterError("spline yarns: got yarns on a lattice; expected yarns with ends or rings")

    def __repr__(self) -> str:
        """Return one line: the numbers of yarns and control points."""
        return f"SplineYarns({self.yarn_count} yarns, {self.node_count} control points)"

    @property
    def node_count(self) -> int:
        """Number N of control points."""
        return len(self.curves.points)

    @property
    def yarn_count(self) -> int:
        """Number Y of yarns."""
        return self.curves.yarn_count

    @property
    def yarn_start(self) -> IntArray:
        """First control point of each yarn, and N at the end, shape (Y + 1,)."""
        return self.curves.start

    @cached_property
    def yarn_node(self) -> IntArray:
        """The control points yarn by yarn, shape (N,)."""
        return np.arange(self.node_count)

    @cached_property
    def rest_sliding(self) -> FloatArray:
        """Eulerian coordinates, which this model does not have: zeros, shape (N, 2)."""
        return np.zeros((self.node_count, 2))

    def world(self, cloth: Cloth, vertices: FloatArray | None = None) -> FloatArray:
        """Return the places of the control points above the triangles [cm], shape (N, 3).

        Args:
            cloth: the cloth on which the yarns are laid out.
            vertices: positions of the vertices [cm], shape (V, 3); by default the positions of the cloth.
        """
        corners = cloth.vertices if vertices is None else np.asarray(vertices)
        foot = world_positions(cloth, self.triangle, self.barycentric, corners)
        normals = normals_at(cloth, self.triangle, self.barycentric, corners)
        placed: FloatArray = foot + self.height[:, None] * normals
        return placed


LaidYarns = CrossingYarns | SplineYarns
"""Yarns of either model."""


def spline_yarns(
    cloth: Cloth, curves: YarnSet, triangle: IntArray, barycentric: FloatArray, height: FloatArray
) -> SplineYarns:
    """Return yarns whose control points have given feet on a cloth; the arguments are fields of ``SplineYarns``."""
    return SplineYarns(
        curves=curves,
        panel=cloth.panel[triangle],
        position=rest_positions(cloth, triangle, barycentric),
        triangle=triangle,
        barycentric=barycentric,
        height=height,
    )
