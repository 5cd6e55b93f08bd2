# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How a fabric is held by its surface: inner vertices on the sheet, border vertices on their border, corners fixed.

The first association follows Yuksel et al. 2012, section 6.1: vertices are projected onto the input polygons, refined
like the surface but not smoothed, and the barycentric coordinates found there are evaluated on the limit surface.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import MeshError
from stitchmesh.mesh import FloatArray, IntArray, StitchMesh
from stitchmesh.meshrelax.catmull_clark import border_vertices
from stitchmesh.meshrelax.closest_point import ClosestPoint
from stitchmesh.meshrelax.limit_surface import LimitSurface

TINY = np.finfo(np.float64).tiny
RIGHT_ANGLE = 1e-9
"""Cosine up to which a border turns by a right angle, whatever rounding says: that is no corner yet."""


@dataclass(frozen=True, eq=False)
class Placement:
    """Where the vertices of a fabric are."""

    position: FloatArray
    """[cm], shape (V, 3)."""
    normal: FloatArray
    """Unit normal of the surface there or, on a border, next to it, shape (V, 3)."""
    shape: FloatArray
    """Change of the normal along the surface, zero at border vertices [1/cm], shape (V, 3, 3)."""
    arc: FloatArray
    """Arc length along its border of each border vertex, zero elsewhere [cm], shape (V,)."""
    tangent: FloatArray
    """Unit tangent of the border, zero at inner and fixed vertices, shape (V, 3)."""
    bend: FloatArray
    """Change of the tangent along the border, zero at inner vertices [1/cm], shape (V, 3)."""


@dataclass(frozen=True, eq=False)
class Attachment:
    """A surface and what holds each vertex of a fabric to it."""

    surface: LimitSurface
    closest: ClosestPoint
    """The triangles of the limit surface."""
    border: IntArray
    """Border that each vertex is on, -1 for inner vertices, shape (V,)."""
    fixed: NDArray[np.bool_]
    """Vertices at corners, which do not move, shape (V,)."""

    def projector(self, placement: Placement) -> FloatArray:
        """Projectors onto the directions in which each vertex may move, shape (V, 3, 3)."""
        normal, tangent = placement.normal, placement.tangent
        allowed = np.eye(3) - normal[:, :, None] * normal[:, None, :]
        along = tangent[:, :, None] * tangent[:, None, :]
        allowed = np.where((self.border >= 0)[:, None, None], along, allowed)
        return np.where(self.fixed[:, None, None], 0.0, allowed)

    def moved(self, placement: Placement, step: FloatArray, stride: float) -> Placement:
        """The placement after a step along the surface, in strides short enough to stay on the sheet.

        Args:
            placement: where the vertices are.
            step: allowed displacement of each vertex [cm], shape (V, 3).
            stride: largest distance between two projections [cm].
        """
        strides = max(1, int(np.ceil(np.linalg.norm(step, axis=1).max() / stride)))
        position, normal, part = placement.position, placement.normal, step / strides
        length = np.linalg.norm(part, axis=1, keepdims=True)
        for _ in range(strides):
            found = self.closest.find(position + part, normal)
            position, normal = self.surface.evaluate(*found)
            turned = part - np.einsum("vi,vi->v", part, normal)[:, None] * normal
            part = turned * (length / np.maximum(np.linalg.norm(turned, axis=1, keepdims=True), TINY))
        arc = placement.arc + np.einsum("vi,vi->v", step, placement.tangent)
        return self.placed(found[0], position, normal, arc)

    def placed(self, triangle: IntArray, position: FloatArray, normal: FloatArray, arc: FloatArray) -> Placement:
        """The placement of points found on triangles of the surface, border vertices at their arc lengths."""
        shape = np.where((self.border < 0)[:, None, None], self.surface.shape_operator(triangle, normal), 0.0)
        position, tangent, bend = position.copy(), np.zeros_like(position), np.zeros_like(position)
        for number, border in enumerate(self.surface.borders):
            members = np.flatnonzero(self.border == number)
            position[members], tangent[members], bend[members] = border.at(arc[members])
        tangent[self.fixed] = 0.0
        return Placement(position, normal, shape, arc, tangent, bend)


def attach(fabric: StitchMesh, surface: LimitSurface, reach: float, device: str | None) -> tuple[Attachment, Placement]:
    """Hold a fabric that lies on the input polygons to their limit surface.

    Args:
        fabric: stitch faces whose vertices lie on the polygons of the surface's mesh.
        surface: limit surface of that mesh.
        reach: distance within which a vertex usually finds its triangle [cm].
        device: Warp's name of the device.

    Raises:
        MeshError: the fabric has a border where the surface has none.
    """
    flat = ClosestPoint(surface.flat_vertices, surface.triangles, reach, device)
    triangle, weights = flat.find(fabric.vertices, fabric.vertex_normal)
    position, normal = surface.evaluate(triangle, weights)
    border, arc = _locate_borders(fabric, surface)
    closest = ClosestPoint(surface.vertices, surface.triangles, reach, device)
    held = Attachment(surface, closest, border, np.zeros(len(border), dtype=bool))
    fixed = border_corners(fabric, held.placed(triangle, position, normal, arc).position)
    attachment = replace(held, fixed=fixed)
    return attachment, attachment.placed(triangle, position, normal, arc)


def border_corners(fabric: StitchMesh, position: FloatArray) -> NDArray[np.bool_]:
    """Border vertices at which the border has a corner, shape (V,).

    One face uses the corner of a swatch, three and more the end of a slit; at the ends of a tip that was closed flat
    the border turns back within a stitch.
    """
    faces = np.bincount(fabric.face_vertex, minlength=len(position))
    corner = border_vertices(fabric) & (faces != 2)
    for loop in fabric.boundary_loops:
        members = fabric.face_vertex[loop]
        ahead = np.roll(position[members], -1, axis=0) - position[members]
        behind = np.roll(ahead, 1, axis=0)
        size = np.linalg.norm(ahead, axis=1) * np.linalg.norm(behind, axis=1)
        corner[members] |= np.einsum("ni,ni->n", ahead, behind) < -RIGHT_ANGLE * size
    return corner


def _locate_borders(fabric: StitchMesh, surface: LimitSurface) -> tuple[IntArray, FloatArray]:
    """The surface border of each border loop of the fabric, the closest as a whole, and the arc lengths on it."""
    border, arc = np.full(len(fabric.vertices), -1), np.zeros(len(fabric.vertices))
    if border_vertices(fabric).any() and not surface.borders:
        side = fabric.side_name(int(fabric.boundary_loops[0][0]))
        raise MeshError(f"{side}: a border of the fabric; got a surface without border, expected the mesh it came from")
    for loop in fabric.boundary_loops:
        members = fabric.face_vertex[loop]
        found = [curve.locate(fabric.vertices[members]) for curve in surface.borders]
        best = int(np.argmin([np.mean(distance**2) for _, distance in found]))
        border[members], arc[members] = best, found[best][0]
    return border, arc
