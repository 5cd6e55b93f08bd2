# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarn of cables: the loops of a group cross between two rows (Yuksel et al. 2012, section 4.5).

Yuksel et al. insert a cable face without wale sides between the rows. Here the rows move apart to make the same room:
the inner corners of the faces below the group move down along their wales, the inner corners of the faces above it move
up, and the two ends of the group stay in place. Each of the two legs of a loop runs from its crossing below to its
crossing above, at the height of its layer. A position in the gap has two coordinates: ``course``, the number of sides
from the left end of the group, and ``share``, the fraction of the way from the row below to the row above.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.mesh import BORDER, LEFT, RIGHT, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.cable_groups import CableGroup
from stitchmesh.yarngen.bridges import Bridges, crossing_number
from stitchmesh.yarngen.embedding import FEWEST_POINTS
from stitchmesh.yarngen.templates.template import CURVE_POINTS

OPENING = 0.42
"""Displacement of the corners, over the height of their face."""
OPENING_ON_BOTH_SIDES = 0.27
"""The same for a face that opens both below and above; about half of its height remains for its own yarn."""
LAYER_GAP = 2.5
"""Distance between two layers [radii]. Touching yarns are 2 apart; the distance is larger because some legs cross
before they have reached their layers."""
LEG_GAP = 1.3
"""Distance along the normal between neighbouring legs of one layer that run side by side [radii]."""
SLOPE_EXPONENT = 1.8
"""Exponent of the sideways motion of a leg. At 1 the leg is straight; at 2 it is close to a smooth step, which leaves
the rows at right angles."""
REST_LENGTH_RATIO, REST_LENGTH_RATIO_STEP = 0.55, 0.12
"""Rest length of crossing legs over their length as generated, and its increase for each loop beyond two that a loop
crosses. A crossing loop holds little more yarn than other loops, so it pulls the stitches on both sides together.
Without the increase, wide cables would start with so large a strain that their yarns collide."""


def open_corners(fabric: StitchMesh, groups: list[CableGroup]) -> FloatArray:
    """Corner positions that leave room for the crossing legs [cm], shape (C, 3).

    Args:
        fabric: stitch faces, including the bind-off row.
        groups: the groups of loops that cross.
    """
    if not groups:
        return fabric.corner_position
    below = [side for group in groups for side in group.sides[:-1].tolist()]
    corners = np.unique([corner for side in below for corner in _corners_right_of(fabric, side)])
    position = fabric.corner_position.copy()
    position[corners] += _opening(fabric, corners)[:, None] * _to_opposite_course(fabric, corners)
    return position


def cross_loops(
    fabric: StitchMesh, groups: list[CableGroup], corner_position: FloatArray, radius: float, points_per_width: float,
    bridges: Bridges,
) -> None:  # fmt: skip
    """Add the legs of each group of crossing loops, which lead to the new places of the loops in the row above.

    Args:
        fabric: stitch faces, including the bind-off row.
        groups: the groups of loops that cross.
        corner_position: corners that leave room for the legs (``open_corners``) [cm], shape (C, 3).
        radius: yarn radius [cm].
        points_per_width: points per stitch width of yarn.
        bridges: the legs are added to these bridges.
    """
    for group in groups:
        gap = _gap(fabric, group, corner_position)
        legs = _legs(group, gap, radius)
        points_per_length = points_per_width / float(np.linalg.norm(gap.below[:, 1] - gap.below[:, 0], axis=1).mean())
        rest_length_ratio = crossing_rest_length_ratio(group)
        below, above = group.sides.tolist(), fabric.twin[group.sides][group.destination].tolist()
        images_above = (_images_above(fabric, group)[group.destination] - group.image).tolist()
        for loop, leg in np.ndindex(legs.shape[:2]):
            # a top side begins at the right leg of its loop, the bottom side above it begins at the left leg
            start, end = crossing_number(below[loop], 1 - leg), crossing_number(above[loop], leg)
            points = _resample(legs[loop, leg], points_per_length) - fabric.shift(group.image[loop])
            bridges.join(
                start,
                end,
                points,
                rest_length_ratio=rest_length_ratio,
                image=(images_above[loop][0], images_above[loop][1]),
            )


def crossing_rest_length_ratio(group: CableGroup) -> float:
    """Rest length of the crossing legs of a group, over their length as generated."""
    farthest = int(np.abs(group.destination - np.arange(len(group.destination))).max())
    return min(REST_LENGTH_RATIO + REST_LENGTH_RATIO_STEP * max(farthest - 2, 0), 1.0)


def _corners_right_of(fabric: StitchMesh, side: int) -> list[int]:
    """Corners, below and above the course line, of all faces that meet at the right end of a top side."""
    below, above = [side], [int(fabric.twin[side]) + 1]
    while fabric.side_role[below[-1] - 1] == RIGHT:
        below.append(int(fabric.twin[below[-1] - 1]))
    while fabric.side_role[above[-1]] == RIGHT:
        across = int(fabric.twin[above[-1]])
        if across == BORDER or fabric.side_role[across] != LEFT:
            break
        above.append(int(fabric.side_next[across]))
    return below + above


def _opening(fabric: StitchMesh, corners: IntArray) -> FloatArray:
    """Displacement of corners, over the height of their face, shape (n,).

    Corners of one row that meet in a vertex have the same displacement.
    """
    face, is_top = fabric.side_face[corners], fabric.side_place[corners] > fabric.n_bottom[fabric.side_face[corners]]
    opens_on_both_sides = np.isin(face, face[is_top]) & np.isin(face, face[~is_top])
    meeting, place = np.unique(2 * fabric.face_vertex[corners] + is_top, return_inverse=True)
    opening = np.full(len(meeting), OPENING)
    opening[place[opens_on_both_sides]] = OPENING_ON_BOTH_SIDES
    return opening[place]


def _to_opposite_course(fabric: StitchMesh, corners: IntArray) -> FloatArray:
    """Vector from each corner across its face [cm], shape (n, 3).

    It points down for corners of the top course and up for corners of the bottom course.
    """
    face = fabric.side_face[corners]
    position, place = fabric.corner_position, fabric.side_place[corners]
    n_bottom, n_top = fabric.n_bottom[face], fabric.n_top[face]
    right, left, first = fabric.right_wale[face], fabric.left_wale[face], fabric.face_start[face]
    is_top = place > n_bottom
    sides = np.where(is_top, n_top, n_bottom)
    from_left = np.where(is_top, n_bottom + n_top + 1 - place, place)
    share = np.where(sides > 0, from_left / np.maximum(sides, 1), 0.5)[:, None]
    up = share * (position[right + 1] - position[right]) + (1.0 - share) * (position[left] - position[first])
    vectors: FloatArray = np.where(is_top, -1.0, 1.0)[:, None] * up
    return vectors


@dataclass(frozen=True, eq=False)
class _Gap:
    """The gap between two rows at a group, in the lattice image of the first side of the group."""

    below: FloatArray
    """Left and right ends of the top sides of the row below [cm], shape (n, 2, 3)."""
    above: FloatArray
    """Left and right ends of the bottom sides of the row above [cm], shape (n, 2, 3)."""
    normal: FloatArray
    """Unit normals at the ends of the sides below, shape (n, 2, 3)."""

    def points(self, course: FloatArray, share: FloatArray, height: FloatArray) -> FloatArray:
        """Points of the gap [cm], shape (m, 3).

        Args:
            course: number of sides from the left end of the group, shape (m,).
            share: fraction of the way from the row below to the row above, shape (m,).
            height: distance along the normal [cm], shape (m,).
        """
        side = np.clip(course.astype(int), 0, len(self.below) - 1)
        along, up = (course - side)[:, None], share[:, None]
        ends = (1.0 - up)[:, None] * self.below[side] + up[:, None] * self.above[side]
        normal = (1.0 - along) * self.normal[side, 0] + along * self.normal[side, 1]
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
        points: FloatArray = (1.0 - along) * ends[:, 0] + along * ends[:, 1] + height[:, None] * normal
        return points


def _images_above(fabric: StitchMesh, group: CableGroup) -> IntArray:
    """Lattice image of the face above each side of a group, seen from the face below its first side, shape (n, 2)."""
    return group.image + fabric.side_image[group.sides]


def _gap(fabric: StitchMesh, group: CableGroup, corner_position: FloatArray) -> _Gap:
    """The gap between the rows at a group, from the displaced corners [cm], shape (C, 3)."""
    below, above = group.sides, fabric.twin[group.sides]
    left_to_right = np.stack([fabric.side_next[below], below], axis=1)
    shift_below, shift_above = fabric.shift(group.image), fabric.shift(_images_above(fabric, group))
    return _Gap(
        below=corner_position[left_to_right] + shift_below[:, None],
        above=corner_position[np.stack([above, fabric.side_next[above]], axis=1)] + shift_above[:, None],
        normal=fabric.vertex_normal[fabric.face_vertex[left_to_right]],
    )


def _leg_heights(group: CableGroup) -> FloatArray:
    """Height at which the left and the right leg of each loop cross [radii], shape (n, 2).

    Legs that move far run flat and close to each other. Neighbouring legs of one layer therefore alternate between
    several heights; the number of heights grows with the distance that the legs move.
    """
    heights = np.zeros((len(group.sides), 2))
    floor = 0.0
    for layer in np.unique(group.layer):
        loops = np.flatnonzero(group.layer == layer)
        farthest = int(np.abs(group.destination - np.arange(len(group.sides)))[loops].max())
        levels = 1 + farthest // 2
        heights[loops] = floor + LEG_GAP * (np.arange(2 * len(loops)) % levels).reshape(-1, 2)
        floor += LEG_GAP * (levels - 1) + LAYER_GAP
    return heights - 0.5 * (floor - LAYER_GAP)


def _legs(group: CableGroup, gap: _Gap, radius: float) -> FloatArray:
    """Densely sampled left and right legs of each loop [cm], shape (n, 2, CURVE_POINTS, 3)."""
    moved = (group.destination - np.arange(len(group.sides)))[:, None, None]
    first = np.arange(len(group.sides))[:, None, None] + np.array([[0.25], [0.75]])
    share = np.linspace(0.0, 1.0, CURVE_POINTS)
    start_distance, end_distance = share**SLOPE_EXPONENT, (1.0 - share) ** SLOPE_EXPONENT
    course = first + moved * start_distance / (start_distance + end_distance)
    # Sideways distance over which a leg moves to the height of its layer, and back at the other end [stitch
    # widths], for a leg that runs straight.
    level_share = np.clip(np.minimum(share, 1.0 - share) * np.maximum(np.abs(moved), 1) / 0.55, 0.0, 1.0)
    height = radius * _leg_heights(group)[:, :, None] * np.sin(0.5 * np.pi * level_share)
    shares = np.broadcast_to(share, course.shape)
    points: FloatArray = gap.points(course.ravel(), shares.ravel(), height.ravel()).reshape(*course.shape, 3)
    return points


def _resample(curve: FloatArray, points_per_length: float) -> FloatArray:
    """Points of a curve at equal arc lengths, the first and the last half a step from its ends [cm], shape (n, 3)."""
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))])
    count = max(FEWEST_POINTS, round(points_per_length * arc[-1]))
    places = (np.arange(count) + 0.5) / count * arc[-1]
    return np.stack([np.interp(places, arc, axis) for axis in curve.T], axis=1)
