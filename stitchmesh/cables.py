# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Cables: loops that change places before the next row works them (Yuksel et al. 2012, section 4.5).

A course line is the top sides of a course (``courses.py``) from left to right. On it the marks of a stitch mesh say
how far each loop moves (``cable_shift``) and which one lies in front (``cable_layer``). Loops that cross form groups:
the smallest stretches of the line that no loop leaves.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.errors import LabelError
from stitchmesh.mesh import BORDER, IntArray, StitchMesh

NONE = -1
"""Neighbour of an end of a course line."""


@dataclass(frozen=True, eq=False)
class CableGroup:
    """Loops that cross: the loop on ``sides[i]`` is worked where that on ``sides[destination[i]]`` would be."""

    sides: IntArray
    """Top sides from left to right, shape (n,)."""
    destination: IntArray
    """Place in the group to which each loop moves, a permutation of 0 to n - 1, shape (n,)."""
    layer: IntArray
    """Layer of each loop; of two loops that cross, the one of the higher number lies in front, shape (n,)."""


def cable_groups(fabric: StitchMesh) -> list[CableGroup]:
    """The crossing groups of a stitch mesh, in the order of their lowest-numbered marked sides.

    Raises:
        LabelError: a loop is moved off its row or all around it, two loops are moved to one place, loops of one layer
            cross, or the row above runs the other way, so that no stitch takes the loops in their new order.
    """
    if not np.any(fabric.cable_shift):
        return []
    groups, seen = [], set()
    for side in np.flatnonzero(fabric.cable_shift).tolist():
        if side not in seen:
            line, is_ring = course_line(fabric, side)
            seen.update(line.tolist())
            groups += groups_on_line(fabric, line, is_ring)
    return groups


def course_line(fabric: StitchMesh, side: int) -> tuple[IntArray, bool]:
    """The top sides of a side's course line from left to right, and whether it closes around a tube.

    Args:
        fabric: stitch faces.
        side: any top side of the line; a line that closes starts with it.
    """
    rightwards = _walk(fabric, side, 1)
    if len(rightwards) > 1 and _beside(fabric, rightwards[-1], 1) == side:
        return np.array(rightwards), True
    return np.array(_walk(fabric, side, -1)[:0:-1] + rightwards), False


def _walk(fabric: StitchMesh, side: int, step: int) -> list[int]:
    """Top sides from this one on, to the right or to the left, until the line ends or closes."""
    line, following = [side], _beside(fabric, side, step)
    while following not in (NONE, side):
        line.append(following)
        following = _beside(fabric, following, step)
    return line


def _beside(fabric: StitchMesh, side: int, step: int) -> int:
    """The next top side to the right (1) or left (-1), ``NONE`` at an end; they run right to left around their face.

    A face without top sides is passed: loops on both sides of it are neighbours.
    """
    leaving, entered = (1, 3) if step > 0 else (3, 1)
    row = fabric.row[fabric.side_face[side]]
    side -= step
    while fabric.side_role[side] == leaving:
        across = int(fabric.twin[side])
        if across == BORDER or fabric.side_role[across] != entered or fabric.row[fabric.side_face[across]] != row:
            return NONE
        side = across - step
    return side


def groups_on_line(fabric: StitchMesh, line: IntArray, is_ring: bool) -> list[CableGroup]:
    """The crossing groups of one course line: it is cut wherever no loop passes.

    Args:
        fabric: stitch faces.
        line: as ``course_line`` gives it.
        is_ring: likewise.

    Raises:
        LabelError: as for ``cable_groups``.
    """
    shift, count = fabric.cable_shift[line], len(line)
    destination = np.arange(count) + shift
    _check_destinations(fabric, line, destination, is_ring)
    crossed = np.zeros(count, dtype=bool)  # whether a loop passes between each side and the one on its left
    for place in np.flatnonzero(shift > 0):
        crossed[np.arange(place + 1, destination[place] + 1) % count] = True
    if crossed.all():
        raise LabelError(f"{fabric.side_name(line[0])}: its cables reach around the whole row; leave a place uncrossed")
    first = int(np.argmin(crossed))
    starts = (first + np.flatnonzero(~np.roll(crossed, -first))).tolist()
    groups = []
    for start, end in zip(starts, [*starts[1:], first + count], strict=True):
        if end - start > 1:
            places = np.arange(start, end) % count
            sides = line[places]
            groups.append(CableGroup(sides, np.arange(end - start) + shift[places], fabric.cable_layer[sides]))
    for group in groups:
        _check_group(fabric, group)
    return groups


def _check_destinations(fabric: StitchMesh, line: IntArray, destination: IntArray, is_ring: bool) -> None:
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
            f"{fabric.side_name(line[one])}; cables must not overlap, every place takes one loop"
        )


def _check_group(fabric: StitchMesh, group: CableGroup) -> None:
    across = fabric.twin[group.sides]
    against = np.flatnonzero((across != BORDER) & (fabric.side_role[across] != 0))
    if len(against):
        raise LabelError(
            f"{fabric.side_name(group.sides[against[0]])}: crosses where the row above runs the other way; cables need "
            "a row above that takes their loops, move the cable to another row"
        )
    left, right = np.triu_indices(len(group.sides), 1)
    crossing = group.destination[left] > group.destination[right]
    level = np.flatnonzero(crossing & (group.layer[left] == group.layer[right]))
    if len(level):
        one, other = group.sides[left[level[0]]], group.sides[right[level[0]]]
        raise LabelError(
            f"{fabric.side_name(one)}: crosses the loop from {fabric.side_name(other)} in the same cable_layer "
            f"{fabric.cable_layer[one]}; give the one in front a higher number"
        )
