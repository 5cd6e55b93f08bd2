# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Edits that set and clear cables: loops of one course line that exchange places.

Source: Yuksel et al. 2012, sections 4.5 and 5.3.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stitchmesh.editing.sides import check_side
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import IntArray, StitchMesh
from stitchmesh.mesh.cable_groups import cable_groups, course_line
from stitchmesh.mesh.change import Change, Marks


def cross_cable(fabric: StitchMesh, side: int, left: int, right: int, front: str) -> list[Change]:
    """Cross adjacent loops: a group on the left with a group on its right.

    The cable ``c4f`` (the cable needle is held in front) crosses 2 loops with 2 loops, the right ones in front. In
    ``c4b`` the left ones lie in front.

    Args:
        fabric: a mesh of stitches.
        side: top side of the leftmost loop.
        left: number of loops that move to the right.
        right: number of loops that move to the left.
        front: ``"left"`` or ``"right"``: which of the two groups lies in front.

    Raises:
        ParameterError: the side is not a top side, the row is too short, a loop is part of another cable, or a group
            has no loops.
    """
    if left < 1 or right < 1:
        raise ParameterError(f"cable: got {left} loops on the left and {right} on the right; expected at least 1 each")
    if front not in ("left", "right"):
        raise ParameterError(f"front: got {front!r}; expected left or right")
    destinations = [*range(right, left + right), *range(right)]
    in_front = front == "left"
    return set_cable(fabric, side, destinations, [int(in_front)] * left + [int(not in_front)] * right)


def set_cable(fabric: StitchMesh, side: int, destinations: Sequence[int], layers: Sequence[int]) -> list[Change]:
    """Permute adjacent loops.

    Args:
        fabric: a mesh of stitches.
        side: top side of the leftmost loop.
        destinations: the place to which each loop moves, counted from the left: a permutation of 0 to n - 1.
        layers: the layer of each loop; of two loops that cross, the loop with the higher layer lies in front.

    Raises:
        ParameterError: the side is not a top side, the row is too short, a loop is part of another cable, the
            destinations are not a permutation, or the number of layers is wrong.
        LabelError: loops that cross have the same layer, or the row above runs in the opposite direction.
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
    """Remove a cable; its loops stay in their places.

    Args:
        fabric: a mesh of stitches.
        side: top side of any loop of the cable.

    Raises:
        ParameterError: the side is not a top side, or its loop is not part of a cable.
    """
    check_side(fabric, side, "top")
    sides = next((group.sides for group in cable_groups(fabric, np.array([side])) if side in group.sides), None)
    if sides is None:
        raise ParameterError(f"{fabric.side_name(side)}: its loop is not part of a cable")
    zero = np.zeros(len(sides), dtype=np.int64)
    return _marks(sides, zero, zero)


def _loops(fabric: StitchMesh, side: int, count: int) -> IntArray:
    """Return ``count`` top sides from a side to the right; none of their loops may be part of a cable."""
    check_side(fabric, side, "top")
    line, is_ring = course_line(fabric, side)
    first = int(np.flatnonzero(line == side)[0])
    available = len(line) - first
    if available < count or (is_ring and available == count):
        where = "around the row" if is_ring else "to the right end of its row"
        raise ParameterError(
            f"{fabric.side_name(side)}: a cable of {count} loops does not fit; there are {available} {where}"
        )
    sides = line[first : first + count]
    for group in cable_groups(fabric, np.array([side])):
        taken = np.intersect1d(sides, group.sides)
        if len(taken):
            raise ParameterError(f"{fabric.side_name(taken[0])}: its loop is part of another cable; clear it first")
    return sides


def _marks(sides: IntArray, shift: IntArray, layer: IntArray) -> list[Change]:
    return [Marks("cable_layer", sides, layer), Marks("cable_shift", sides, shift)]
