# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Crossed and twisted loops as lines: the front loop is one line, and the rear loop is broken where it crosses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.cable_groups import CableGroup, cable_groups

REACH = 0.42
"""Share of the face above and below a course line that the lines of its loops cover."""
GAP = 0.36
"""Share of the line of a rear loop that is left out in its middle."""
STEPS = 4
"""Number of pieces of the line from one loop to its neighbour."""
TWIST_WIDTH = 0.28
"""Half the width of the mark of a twisted loop, over the length of its side."""


def loop_lines(fabric: StitchMesh, height: float) -> FloatArray:
    """Return the ends of the lines of crossed and twisted loops, ``height`` cm above the fabric, shape (n, 2, 3)."""
    paths = [path for group in cable_groups(fabric) for path in _cable(fabric, group)]
    paths += [path for side in np.flatnonzero(fabric.twist).tolist() for path in _twist(fabric, side)]
    if not paths:
        return np.zeros((0, 2, 3))
    segments = np.concatenate([np.stack([path.points[:-1], path.points[1:]], axis=1) for path in paths])
    sides = np.repeat([path.side for path in paths], [len(path.points) - 1 for path in paths])
    normal = fabric.face_vector_area[fabric.side_face[sides]]
    lift = height * normal / np.linalg.norm(normal, axis=1, keepdims=True)
    lifted: FloatArray = segments + lift[:, None]
    return lifted


@dataclass(frozen=True, eq=False)
class _Path:
    """A line of a loop, or a piece of it."""

    points: FloatArray
    """Points [cm], shape (n, 3)."""
    side: int
    """Top side of the loop."""


def _cable(fabric: StitchMesh, group: CableGroup) -> list[_Path]:
    """Return the lines of a cable: each runs from below the place of a loop to above its new place.

    A line passes through the places between, so that it follows the surface.
    """
    position = fabric.corner_position
    middle, up = 0.5 * (position[group.sides] + position[fabric.side_next[group.sides]]), _upwards(fabric, group.sides)
    places = np.arange(len(group.sides))
    crosses = (places[:, None] < places) != (group.destination[:, None] < group.destination)
    behind = (crosses & (group.layer[:, None] < group.layer)).any(axis=1)
    paths: list[_Path] = []
    for first, last in enumerate(group.destination.tolist()):
        share = np.linspace(0.0, 1.0, STEPS * abs(last - first) + 1)
        place = first + (last - first) * share
        line = np.stack([np.interp(place, places, middle[:, axis]) for axis in range(3)], axis=1)
        rise = np.stack([np.interp(place, places, up[:, axis]) for axis in range(3)], axis=1)
        points = line + (2.0 * share - 1.0)[:, None] * rise
        if last == first:
            points = np.stack([middle[first] - up[first], middle[first] + up[first]])
        paths += _pieces(points, int(group.sides[first]), behind=bool(behind[first]))
    return paths


def _twist(fabric: StitchMesh, side: int) -> list[_Path]:
    """Return the two legs of a twisted loop; at twist 1 the leg that comes from the left is in front."""
    position, up = fabric.corner_position, 0.7 * _upwards(fabric, np.array([side]))[0]
    right, left = position[side], position[fabric.side_next[side]]  # A top side runs from right to left.
    middle, across = 0.5 * (left + right), TWIST_WIDTH * (right - left)
    share = np.linspace(-1.0, 1.0, 2 * STEPS + 1)[:, None]
    legs = [middle + share * (up + across), middle + share * (up - across)]
    from_left_behind = bool(fabric.twist[side] < 0)
    first = _pieces(legs[0], side, behind=from_left_behind)
    return first + _pieces(legs[1], side, behind=not from_left_behind)


def _pieces(points: FloatArray, side: int, *, behind: bool) -> list[_Path]:
    """Return a line; a line behind has two pieces."""
    if not behind:
        return [_Path(points, side)]
    first = max(round((0.5 - GAP / 2) * (len(points) - 1)), 1)
    return [_Path(points[: first + 1], side), _Path(points[len(points) - 1 - first :], side)]


def _upwards(fabric: StitchMesh, sides: IntArray) -> FloatArray:
    """Return the vectors from the course line of top sides to the upper ends of the lines, shape (n, 3)."""
    face, position = fabric.side_face[sides], fabric.corner_position
    right, left = fabric.right_wale[face], fabric.left_wale[face]
    low = 0.5 * (position[fabric.face_start[face]] + position[right])
    high = 0.5 * (position[fabric.side_next[right]] + position[left])
    upwards: FloatArray = REACH * (high - low)
    return upwards
