# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Vectors that turn with triangles: they are constant in the frame of a triangle.

The frame is the direction of its first side, what is perpendicular to it in the plane, and the normal.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import launch
from stitchmesh.compute.precision import vector

Numbers = NDArray[np.float64]
Integers = NDArray[np.int64]


@kernel
def turn_vectors(
    # model
    corners: wp.array[wp.vec3i],
    local: wp.array[Any],
    # state in
    vertices: wp.array[Any],
    # state out
    turned: wp.array[Any],
) -> None:
    """Each vector in space."""
    k = wp.tid()
    corner = corners[k]
    side, other = vertices[corner[1]] - vertices[corner[0]], vertices[corner[2]] - vertices[corner[0]]
    along, normal = wp.normalize(side), wp.normalize(wp.cross(side, other))
    c = local[k]
    turned[k] = along * c[0] + wp.cross(normal, along) * c[1] + normal * c[2]


class TurnedVectors:
    """Vectors on a device."""

    def __init__(self, corners: Integers, vectors: Numbers, vertices: Numbers, scalar: Any, device: wp.Device) -> None:
        """Store the vectors in the frames of their triangles.

        Args:
            corners: vertices of the triangle with which each vector turns, shape (n, 3).
            vectors: the vectors, shape (n, 3), where the vertices are at ``vertices``.
            vertices: positions of the vertices [cm], shape (V, 3).
            scalar: Warp's floating-point type.
            device: where the vectors lie.
        """
        kind = vector(3, scalar)
        local = np.einsum("nij,nj->ni", triangle_frames(vertices[corners]), vectors)
        self._corners = wp.array(corners.astype(np.int32), dtype=wp.vec3i, device=device)
        self._local = wp.array(local, dtype=kind, device=device)
        self.vectors = wp.array(vectors, dtype=kind, device=device)
        """The vectors in space, as last turned, shape (n, 3)."""
        self._launch = partial(launch, device=device)

    def turn(self, vertices: wp.array[Any]) -> None:
        """Turn the vectors with their triangles."""
        self._launch(turn_vectors, len(self.vectors), [self._corners, self._local, vertices], [self.vectors])


def triangle_frames(corners: Numbers) -> Numbers:
    """Return the frame of each triangle as rows, shape (n, 3, 3).

    Args:
        corners: positions of the corners [cm], shape (n, 3, 3).
    """
    side, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.cross(side, other)
    along = side / np.linalg.norm(side, axis=1, keepdims=True)
    normal = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    return np.stack([along, np.cross(normal, along), normal], axis=1)
