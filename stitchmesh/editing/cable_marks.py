# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Set and clear cables: loops of one course line that change places (Yuksel et al. 2012, sections 4.5 and 5.3)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stitchmesh.editing.sides import check_side
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import IntArray, StitchMesh
from stitchmesh.mesh.cable_groups import cable_groups, course_line
from stitchmesh.mesh.change import Change, Marks


def cross_cable(fabric: StitchMesh, side: int, left: int, right: int, front: str) -> list[Change]:
    """Cross neighbouring loops: some on the left with some on their right.

    A knitter's ``c4f``, the cable needle held in front, is 2 and 2 with the right ones in front, ``c4b`` the left ones.

    Args:
        fabric: stitch faces.
        side: top side of the leftmost loop.
        left: how many loops go right.
        right: how many loops go left.
        front: ``"left"`` or ``"right"``, those that lie in front.

    Raises:
        ParameterError: the side is no top side, the row is too short, a loop is part of another cable, or a part has
            no loop.
    """
    if left < 1 or right < 1:
        raise ParameterError(f"cable: got {left} loops on the left and {right} on the right; expected at least 1 each")
    if front not in ("left", "right"):
        raise ParameterError(f"front: got {front!r}; expected left or right")
    destinations = [*range(right, left + right), *range(right)]
    in_front = front == "left"
    return set_cable(fabric, side, destinations, [int(in_front)] * left + [int(not in_front)] * right)


def set_cable(fabric: StitchMesh, side: int, destinations: Sequence[int], layers: Sequence[int]) -> list[Change]:
    """Move neighbouring loops to any places among themselves.

    Args:
        fabric: stitch faces.
        side: top side of the leftmost loop.
        destinations: place that each loop moves to, from left to right, a permutation of 0 to n - 1.
        layers: of two loops that cross, the one of the higher number lies in front.

    Raises:
        ParameterError: the side is no top side, the row is too short, a loop is part of another cable, or the numbers
            are no permutation with a layer each.
        LabelError: crossing loops share a layer, or the row above runs the other way.
    """
    count = len(destinations)
    if sorted(destinations) != list(range(count)) or count < 2:
        raise ParameterError(f"destinations: got {list(destinations)}; expected the places 0 to {count - 1} once each")
    if len(layers) != count:
        raise ParameterError(f"layers: got {len(layers)} for {count} loops; expected one each")
    sides = _loops(fabric, side, count)
    shift = np.asarray(destinations, dtype=np.int64) - np.arange(count)
    return _marks(sides, shift, np.asarray(layers, dtype=np.int64))


def clear_cable(fabric: StitchMesh, side: int) -> list[Change]:
    """Leave the loops of a cable in their places.

    Args:
        fabric: stitch faces.
        side: top side of any of its loops.

    Raises:
        ParameterError: the side is no top side, or its loop is in no cable.
    """
    check_side(fabric, side, "top")
    sides = next((group.sides for group in cable_groups(fabric, np.array([side])) if side in group.sides), None)
    if sides is None:
        raise ParameterError(f"{fabric.side_name(side)}: its loop is in no cable")
    nothing = np.zeros(len(sides), dtype=np.int64)
    return _marks(sides, nothing, nothing)


def _loops(fabric: StitchMesh, side: int, count: int) -> IntArray:
    """Top sides from this one to the right, none of them part of a cable."""
    check_side(fabric, side, "top")
    line, is_ring = course_line(fabric, side)
    first = int(np.flatnonzero(line == side)[0])
    room = len(line) - first
    if room < count or (is_ring and room == count):
        kind = "around the row" if is_ring else "to the right end of its row"
        raise ParameterError(
            f"{fabric.side_name(side)}: a cable of {count} loops does not fit; there are {room} {kind}"
        )
    sides = line[first : first + count]
    for group in cable_groups(fabric, np.array([side])):
        taken = np.intersect1d(sides, group.sides)
        if len(taken):
            raise ParameterError(f"{fabric.side_name(taken[0])}: its loop is part of another cable; clear it first")
    return sides


def _marks(sides: IntArray, shift: IntArray, layer: IntArray) -> list[Change]:
    return [Marks("cable_layer", sides, layer), Marks("cable_shift", sides, shift)]
