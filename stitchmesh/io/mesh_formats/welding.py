# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Points at exactly equal positions become one vertex.

Programs that write glTF, PLY or USD for renderers repeat a point for each of its normals and texture coordinates. The
points of a mesh that moves are one vertex only if they lie together in all frames.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray


def weld(points: FloatArray, faces: list[list[int]]) -> tuple[FloatArray, list[list[int]]]:
    """Merge points with exactly equal coordinates.

    Args:
        points: shape (P, 3).
        faces: points of each face.

    Returns:
        The distinct points in the order of their first occurrence, shape (V, 3), and the faces with their new numbers.
    """
    welded, renumbered = weld_frames(points[None], faces)
    return welded[0], renumbered


def weld_frames(frames: FloatArray, faces: list[list[int]]) -> tuple[FloatArray, list[list[int]]]:
    """Merge points that have exactly equal coordinates in each frame.

    Args:
        frames: the points in each frame, shape (K, P, 3).
        faces: points of each face.

    Returns:
        The distinct points in the order of their first occurrence, shape (K, V, 3), and the faces with their new
        numbers.
    """
    number, first = np.zeros(frames.shape[1], dtype=np.int64), np.zeros(1, dtype=np.int64)
    for points in frames:
        if frames.shape[1] and not np.array_equal(points[first[number]], points):
            number, first = _divided(number, points)
    renumbered = number.tolist()
    return frames[:, first[: frames.shape[1]]], [[renumbered[point] for point in face] for face in faces]


def _divided(number: IntArray, points: FloatArray) -> tuple[IntArray, IntArray]:
    """Divide groups of points where their coordinates differ.

    Returns:
        The number of the group of each point, and the first point of each group, which ascend.
    """
    told_apart = np.column_stack([number, points + 0.0])  # This turns -0.0 into 0.0.
    _, first, place = np.unique(told_apart, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return rank[place.ravel()], first[order]
