# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns as B-splines on a cloth: each control point is a yarn node that lies off the triangles by its height.

Loops stand out of the plane of the cloth. A control point q is therefore given by a triangle, barycentric coordinates b
and a height h along the interpolated normal n of the cloth,

    q = B v + h n(b),

so that B holds only the barycentric coordinates, as for nodes within the triangles. Outside the enriched region this
formula places the yarn. In the hybrid region the height does not belong to B: there it belongs to F x, which turns with
the yarn (``enrichment.region``). If B contained the normals, the motions p = B v + F x would not be linear in v. If
E (v, p) kept the heights as constants, a cloth that turns would be strained.

``LaidYarns`` are yarns of either model, laid out on a cloth: with nodes at crossings, or with control points of
B-splines. Both have ``node_count`` nodes with a ``panel``, a ``position`` in it, a ``triangle`` and ``barycentric``
coordinates, a place in the ``world``, and Eulerian coordinates ``rest_sliding``; ``yarn_start`` and ``yarn_node`` list
the nodes of each yarn.

``lay_splines`` finds the foot and the height of each control point of the yarns of a stitch mesh. Each control point
knows the stitch that made it. The triangles of this stitch and of the stitches around it are the candidates for its
foot, so layers of a garment that lie on one another do not mix. The point takes the candidate whose prism along its
normal holds it, or comes nearest to it. The foot then follows from the interpolated normal n by a few rounds of

    h = n(b) . (q - B v),    b = barycentric coordinates of q - h n(b).

A control point that no stitch made, such as in a tail, has the candidates of the nearest point of its yarn that a
stitch made.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray, IntArray, StitchMesh, frozen_array
from stitchmesh.mesh.polygon_mesh import ranges
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.cloth.from_stitches import triangle_start
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


def lay_splines(cloth: Cloth, fabric: StitchMesh, curves: YarnSet) -> SplineYarns:
    """Lay B-spline yarns out on the cloth of the stitch mesh from which they were made.

    Args:
        cloth: the cloth that ``cloth_from_stitches`` made of the fabric.
        fabric: the stitch mesh.
        curves: the yarns of the stitch mesh, as generated or as relaxed.

    Raises:
        ParameterError: the cloth or the yarns do not belong to the fabric.
    """
    faces = _faces_of_points(fabric, curves)
    start = triangle_start(fabric)
    if start[-1] != len(cloth.triangles):
        found = f"got a cloth of {len(cloth.triangles)} triangles"
        raise ParameterError(f"spline yarns: {found}; expected {start[-1]}, those of the stitches")
    point, triangle = _candidates(fabric, start, faces)
    chosen = _nearest_prism(cloth, curves.points, point, triangle)
    barycentric, height = _feet(cloth, curves.points, chosen)
    return spline_yarns(cloth, curves, chosen, barycentric, height)


def _faces_of_points(fabric: StitchMesh, curves: YarnSet) -> IntArray:
    """The stitch of each control point, or the stitch of the nearest point of its yarn that has one, shape (N,)."""
    if curves.face.max() >= fabric.face_count:
        found = f"got yarns of stitch {curves.face.max()}"
        raise ParameterError(f"spline yarns: {found}; expected 0 to {fabric.face_count - 1}")
    known = np.flatnonzero(curves.face >= 0)
    yarn = curves.point_yarn
    missing = np.setdiff1d(yarn, yarn[known])
    if len(missing):
        raise ParameterError(f"spline yarns: yarn {missing[0]}: belongs to no stitch; expected yarns of the fabric")
    after = np.searchsorted(known, np.arange(len(yarn)))
    sides = np.stack([known[np.maximum(after - 1, 0)], known[np.minimum(after, len(known) - 1)]], axis=1)
    distance = np.abs(sides - np.arange(len(yarn))[:, None]) + len(yarn) * (yarn[sides] != yarn[:, None])
    nearest: IntArray = curves.face[sides[np.arange(len(yarn)), distance.argmin(axis=1)]]
    return nearest


def _candidates(fabric: StitchMesh, start: IntArray, faces: IntArray) -> tuple[IntArray, IntArray]:
    """Pairs of a control point and a triangle of a stitch that shares a vertex with its own, point by point."""
    holds = csr_array((np.ones(len(fabric.face_vertex)), fabric.face_vertex, fabric.face_start))
    around = csr_array(holds @ holds.T)
    near = np.repeat(np.arange(len(faces)), np.diff(around.indptr)[faces])
    face = around.indices[ranges(around.indptr, faces)]
    return np.repeat(near, np.diff(start)[face]), ranges(start, face)


def _nearest_prism(cloth: Cloth, places: FloatArray, point: IntArray, triangle: IntArray) -> IntArray:
    """The candidate whose prism is nearest to each point, shape (N,); of several that hold it, the lowest one."""
    corners = cloth.vertices[cloth.triangles[triangle]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(normal, axis=1)
    apart = places[point] - corners[:, 0]
    height = np.abs((apart * normal).sum(axis=1)) / area
    outside = np.maximum(-_barycentric(cloth, triangle, places[point]).min(axis=1), 0.0) * np.sqrt(area)
    order = np.lexsort((height + outside, point))
    first = np.searchsorted(point[order], np.arange(len(places)))
    return triangle[order[first]]


def _feet(cloth: Cloth, places: FloatArray, triangle: IntArray) -> tuple[FloatArray, FloatArray]:
    """Barycentric coordinates and height of each point in its triangle, shapes (N, 3) and (N,)."""
    corners = cloth.vertices[cloth.triangles[triangle]]
    barycentric = _barycentric(cloth, triangle, places)
    height = np.zeros(len(places))
    for _ in range(8):  # each round multiplies the error by the height over the radius of curvature of the cloth
        normal = normals_at(cloth, triangle, barycentric, cloth.vertices)
        foot = np.einsum("nk,nkd->nd", barycentric, corners)
        height = ((places - foot) * normal).sum(axis=1)
        barycentric = _barycentric(cloth, triangle, places - height[:, None] * normal)
    return barycentric, height


def _barycentric(cloth: Cloth, triangle: IntArray, places: FloatArray) -> FloatArray:
    """Barycentric coordinates of the projections of points onto the planes of triangles, shape (n, 3)."""
    corners = cloth.vertices[cloth.triangles[triangle]]
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.cross(first, second)
    square = (normal * normal).sum(axis=1)
    apart = places - corners[:, 0]
    b1 = (np.cross(apart, second) * normal).sum(axis=1) / square
    b2 = (np.cross(first, apart) * normal).sum(axis=1) / square
    return np.stack([1.0 - b1 - b2, b1, b2], axis=1)
