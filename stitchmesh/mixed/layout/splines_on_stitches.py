# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The B-spline yarns of a stitch mesh on its cloth: the foot of each control point, and its height.

Each control point knows the stitch that made it. The triangles of this stitch and of the stitches around it are the
candidates for its foot, so layers of a garment that lie on one another do not mix. The point takes the candidate whose
prism along its normal holds it, or comes nearest to it. The foot then follows from the interpolated normal n by a few
rounds of

    h = n(b) . (q - B v),    b = barycentric coordinates of q - h n(b).

A control point that no stitch made, such as in a tail, has the candidates of the nearest point of its yarn that a
stitch made.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.polygon_mesh import ranges
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.cloth.from_stitches import triangle_start
from stitchmesh.mixed.layout.curves import normals_at
from stitchmesh.mixed.layout.spline_yarns import SplineYarns, spline_yarns
from stitchmesh.yarn import YarnSet


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
