# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The borders of a limit surface as closed polylines, parametrized by arc length."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from stitchmesh.mesh import FloatArray
from stitchmesh.mesh.unit_vectors import unit_vectors


@dataclass(frozen=True, eq=False)
class BorderCurve:
    """One closed border, on the limit surface and on the input polygons."""

    points: FloatArray
    """Vertices of the border on the limit surface [cm], shape (N, 3)."""
    flat_points: FloatArray
    """The same vertices on the input polygons [cm], shape (N, 3)."""

    @cached_property
    def spans(self) -> FloatArray:
        """Vector from each vertex to the next [cm], shape (N, 3)."""
        return np.roll(self.points, -1, axis=0) - self.points

    @cached_property
    def arc(self) -> FloatArray:
        """Arc length at each vertex, and the length of the whole border at the end [cm], shape (N + 1,)."""
        return np.concatenate([[0.0], np.cumsum(np.linalg.norm(self.spans, axis=1))])

    def locate(self, targets: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Find the arc lengths of points near the border of the input polygons, and their distances from that border.

        Args:
            targets: points on or near the border of the input polygons [cm], shape (M, 3).

        Returns:
            Arc lengths on the limit surface [cm], shape (M,), and distances to the border of the input polygons [cm],
            shape (M,).
        """
        count = len(self.points)
        # The closest segment is searched at this number of nearest vertices of the polyline.
        near = cKDTree(self.flat_points).query(targets, k=min(4, count))[1].reshape(len(targets), -1)
        segment = np.concatenate([near, (near - 1) % count], axis=1)
        start = self.flat_points[segment]
        span = self.flat_points[(segment + 1) % count] - start
        along = np.einsum("mci,mci->mc", targets[:, None] - start, span)
        along = np.clip(along / np.maximum(np.einsum("mci,mci->mc", span, span), np.finfo(float).tiny), 0.0, 1.0)
        distance = np.linalg.norm(targets[:, None] - start - along[:, :, None] * span, axis=2)
        best = (np.arange(len(targets)), distance.argmin(axis=1))
        segment, along = segment[best], along[best]
        return self.arc[segment] + along * np.diff(self.arc)[segment], distance[best]

    def distance(self, targets: FloatArray) -> float:
        """Root mean square distance of points from the vertices of the border on the limit surface [cm].

        Args:
            targets: points [cm], shape (M, 3).
        """
        return float(np.sqrt(np.mean(cKDTree(self.points).query(targets)[0] ** 2)))

    @cached_property
    def tangents(self) -> FloatArray:
        """Unit tangent at each vertex, the mean of the directions of its two segments, shape (N, 3)."""
        length = np.diff(self.arc)[:, None]
        along = self.spans / np.where(length > 0.0, length, 1.0)
        return _directions(along + np.roll(along, 1, axis=0), along)

    def at(self, arc: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Evaluate the border at arc lengths; arc lengths beyond the ends wrap around.

        Tangents are interpolated between vertices. The directions of the segments would jump at the vertices, and then
        there might be no place where the forces on a vertex along the border balance.

        Args:
            arc: arc lengths [cm], shape (M,).

        Returns:
            Points [cm], unit tangents, and curvature vectors (derivatives of the tangent) [1/cm], shape (M, 3) each.
        """
        arc = np.mod(arc, self.arc[-1])
        segment = np.clip(np.searchsorted(self.arc, arc, side="right") - 1, 0, len(self.points) - 1)
        length = np.diff(self.arc)[segment][:, None]
        length = np.where(length > 0.0, length, 1.0)
        part = (arc - self.arc[segment])[:, None] / length
        first, last = self.tangents[segment], np.roll(self.tangents, -1, axis=0)[segment]
        tangent = _directions((1.0 - part) * first + part * last, first)
        return self.points[segment] + part * self.spans[segment], tangent, (last - first) / length


def _directions(vectors: FloatArray, instead: FloatArray) -> FloatArray:
    """Return the unit vectors along vectors, and other vectors in the place of zero vectors, shape (n, 3)."""
    return np.where(vectors.any(axis=1, keepdims=True), unit_vectors(vectors), instead)
