# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Cables: loops that change places before the next row works them (Yuksel et al. 2012, section 4.5).

A course line consists of the top sides of a course (``courses``) from left to right. Two marks of a stitch mesh
describe the cables on the line: how far each loop moves (``cable_shift``) and which loop is in front
(``cable_layer``). Loops that cross form groups. A group is a smallest interval of the line that no loop enters or
leaves.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from stitchmesh.errors import LabelError
from stitchmesh.mesh.courses import course_through, top_sides
from stitchmesh.mesh.polygon_mesh import BORDER, IntArray
from stitchmesh.mesh.stitch_mesh import BOTTOM, StitchMesh


@dataclass(frozen=True, eq=False)
class CableGroup:
    """Loops that cross: the loop on ``sides[i]`` moves to the place of the loop on ``sides[destination[i]]``."""

    sides: IntArray
    """Top sides from left to right, shape (n,)."""
    destination: IntArray
    """Place in the group to which each loop moves, a permutation of 0 to n - 1, shape (n,)."""
    layer: IntArray
    """Layer of each loop, shape (n,); where two loops cross, the loop of the higher layer is in front."""
    image: IntArray
    """Lattice image of the face of each side, relative to the face of the first side, shape (n, 2)."""


def cable_groups(fabric: StitchMesh, sides: IntArray | None = None) -> list[CableGroup]:
    """Find the cable groups on the course lines of some top sides.

    Args:
        fabric: stitch mesh.
        sides: top sides, shape (n,); all top sides with a ``cable_shift`` if None.

    Returns:
        The groups, line by line. The lines have the order in which ``sides`` first names them.

    Raises:
        LabelError: a loop moves beyond its row or completely around it, two loops move to one place, loops of one
            layer cross, or the row above has the opposite wale direction, so that no stitch takes the loops in their
            new order.
    """
    if not np.any(fabric.cable_shift):
        return []
    groups: list[CableGroup] = []
    seen: set[int] = set()
    for side in (np.flatnonzero(fabric.cable_shift) if sides is None else sides).tolist():
        if side not in seen:
            line, is_ring = course_line(fabric, side)
            seen.update(line.tolist())
            groups += _groups_on_line(fabric, line, is_ring) if fabric.cable_shift[line].any() else []
    return groups


def course_line(fabric: StitchMesh, side: int) -> tuple[IntArray, bool]:
    """Return the course line of a top side, shape (n,), and whether it is closed around a tube.

    Args:
        fabric: stitch mesh.
        side: any top side of the line; a closed line starts with this side.
    """
    course = course_through(fabric, int(fabric.side_face[side]))
    line = top_sides(fabric, course.faces)
    first = line.index(side) if course.closed else 0
    return np.array(line[first:] + line[:first]), course.closed and len(line) > 1


def _groups_on_line(fabric: StitchMesh, line: IntArray, is_ring: bool) -> list[CableGroup]:
    """Find the cable groups of one course line, which is cut between two neighbours wherever no loop passes."""
    shift, count = fabric.cable_shift[line], len(line)
    destination = np.arange(count) + shift
    _check_destinations(fabric, line, destination, is_ring)
    crossed = np.zeros(count, dtype=bool)  # Whether a loop passes between each side and its left neighbour.
    for place in np.flatnonzero(shift > 0):
        crossed[np.arange(place + 1, destination[place] + 1) % count] = True
    if crossed.all():
        raise LabelError(
            f"{fabric.side_name(line[0])}: the cables of its row cross all around the tube; leave two neighbouring "
            "stitches between which no loop passes"
        )
    first = int(np.argmin(crossed))
    starts = (first + np.flatnonzero(~np.roll(crossed, -first))).tolist()
    groups = []
    for start, end in zip(starts, [*starts[1:], first + count], strict=True):
        if end - start > 1:
            places = np.arange(start, end) % count
            sides = line[places]
            image = _images_along(fabric, sides)
            groups.append(CableGroup(sides, np.arange(end - start) + shift[places], fabric.cable_layer[sides], image))
    for group in groups:
        _check_group(fabric, group)
    return groups


def _images_along(fabric: StitchMesh, sides: IntArray) -> IntArray:
    """Lattice image of the faces of neighbouring top sides, relative to the first face, shape (n, 2)."""
    steps = np.zeros((len(sides), 2), dtype=np.int64)
    for place, (side, after) in enumerate(pairwise(sides.tolist()), start=1):
        face = int(fabric.side_face[side])
        while after != side - 1:  # The top sides of one face are numbered from right to left.
            right = int(fabric.right_wale[face])
            steps[place] += fabric.side_image[right]
            face = int(fabric.side_face[fabric.twin[right]])
            if face == fabric.side_face[after]:
                break
    return np.cumsum(steps, axis=0)


def _check_destinations(fabric: StitchMesh, line: IntArray, destination: IntArray, is_ring: bool) -> None:
    """Check that the loops of a course line stay on the line and that each place takes one loop."""
    count = len(line)
    shift = destination - np.arange(count)
    outside = np.abs(shift) >= count if is_ring else (destination < 0) | (destination >= count)
    if outside.any():
        place = int(np.argmax(outside))
        raise LabelError(
            f"{fabric.side_name(line[place])}: cable_shift {shift[place]} leads off its row; it has {place} loops on "
            f"the left and {count - 1 - place} on the right"
        )
    reached = destination % count
    taken = np.flatnonzero(np.bincount(reached, minlength=count) > 1)
    if len(taken):
        one, other = np.flatnonzero(reached == taken[0])[:2]
        raise LabelError(
            f"{fabric.side_name(line[other])}: cable_shift {shift[other]} leads to the place of the loop from "
            f"{fabric.side_name(line[one])}; cables must not overlap, because each place takes one loop"
        )


def _check_group(fabric: StitchMesh, group: CableGroup) -> None:
    """Check that stitches above take the loops of a group and that loops that cross have different layers."""
    across = fabric.twin[group.sides]
    against = np.flatnonzero((across != BORDER) & (fabric.side_role[across] != BOTTOM))
    if len(against):
        raise LabelError(
            f"{fabric.side_name(group.sides[against[0]])}: its loop crosses others where the row above has the "
            "opposite wale direction; a cable needs a row above that takes its loops, so move it to another row"
        )
    left, right = np.triu_indices(len(group.sides), 1)
    crossing = group.destination[left] > group.destination[right]
    level = np.flatnonzero(crossing & (group.layer[left] == group.layer[right]))
    if len(level):
        one, other = group.sides[left[level[0]]], group.sides[right[level[0]]]
        raise LabelError(
            f"{fabric.side_name(one)}: its loop crosses the loop from {fabric.side_name(other)} in the same "
            f"cable_layer {fabric.cable_layer[one]}; give the one in front a higher number"
        )
