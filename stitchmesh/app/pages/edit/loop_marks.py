# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Crossed and twisted loops as lines: the loop in front is one line, and the loop behind is broken where it crosses."""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.cable_groups import CableGroup, cable_groups

REACH = 0.42
"""Part of the face above and below a course line over which the lines of its loops reach."""
GAP = 0.36
"""Part of the line of a loop behind that is left out in its middle."""
TWIST_WIDTH = 0.28
"""Half the width of the mark of a twisted loop, divided by the length of its side."""


def loop_lines(fabric: StitchMesh, height: float) -> FloatArray:
    """Return lines that show the crossed and the twisted loops of a fabric.

    Args:
        fabric: the fabric.
        height: distance of the lines from the surface [cm].

    Returns:
        Ends of the lines [cm], shape (n, 2, 3).
    """
    parts = [_cable(fabric, group) for group in cable_groups(fabric)]
    twisted = np.flatnonzero(fabric.twist)
    if len(twisted):
        parts.append(_twists(fabric, twisted))
    if not parts:
        return np.zeros((0, 2, 3))
    starts, ends, behind, sides = (np.concatenate(column) for column in zip(*parts, strict=True))
    normal = fabric.face_vector_area[fabric.side_face[sides]]
    lift = height * normal / np.linalg.norm(normal, axis=1, keepdims=True)
    return _broken(starts + lift, ends + lift, behind)


_Loops = tuple[FloatArray, FloatArray, np.ndarray, IntArray]
"""Starts and ends of lines, whether each lies behind another, and the side of each."""


def _cable(fabric: StitchMesh, group: CableGroup) -> _Loops:
    """Return the lines of a cable: from below the place of each loop to above the place to which it moves."""
    middle, up = _middles(fabric, group.sides), _upwards(fabric, group.sides)
    place = np.arange(len(group.sides))
    crosses = (place[:, None] < place) != (group.destination[:, None] < group.destination)
    behind = (crosses & (group.layer[:, None] < group.layer)).any(axis=1)
    return middle - up, middle[group.destination] + up[group.destination], behind, group.sides


def _twists(fabric: StitchMesh, sides: IntArray) -> _Loops:
    """Return the two legs of each twisted loop; at twist 1 the leg that comes from the left is in front."""
    middle, up = _middles(fabric, sides), 0.7 * _upwards(fabric, sides)
    corners = fabric.corner_position
    across = TWIST_WIDTH * (corners[sides] - corners[fabric.side_next[sides]])  # Top sides run from right to left.
    starts = np.concatenate([middle - across - up, middle + across - up])
    ends = np.concatenate([middle + across + up, middle - across + up])
    from_left_behind = fabric.twist[sides] < 0
    return starts, ends, np.concatenate([from_left_behind, ~from_left_behind]), np.concatenate([sides, sides])


def _middles(fabric: StitchMesh, sides: IntArray) -> FloatArray:
    position = fabric.corner_position
    middles: FloatArray = 0.5 * (position[sides] + position[fabric.side_next[sides]])
    return middles


def _upwards(fabric: StitchMesh, sides: IntArray) -> FloatArray:
    """Return the vectors from the course line of top sides to the upper ends of the lines, shape (n, 3)."""
    face, position = fabric.side_face[sides], fabric.corner_position
    right, left = fabric.right_wale[face], fabric.left_wale[face]
    low = 0.5 * (position[fabric.face_start[face]] + position[right])
    high = 0.5 * (position[fabric.side_next[right]] + position[left])
    upwards: FloatArray = REACH * (high - low)
    return upwards


def _broken(starts: FloatArray, ends: FloatArray, behind: np.ndarray) -> FloatArray:
    """Return the lines, those behind in two pieces."""
    along = ends - starts
    first, second = starts + (0.5 - GAP / 2) * along, starts + (0.5 + GAP / 2) * along
    whole = np.stack([starts, ends], axis=1)[~behind]
    pieces = [np.stack([starts, first], axis=1)[behind], np.stack([second, ends], axis=1)[behind]]
    return np.concatenate([whole, *pieces])
