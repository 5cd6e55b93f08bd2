# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Lists of pairs with a fixed capacity, one for each element: what may touch it, in ascending order.

A thread fills the list of its element in the order in which a hash grid finds the others, and sorts as it inserts. The
forces that are summed over a list then do not depend on the grid. An entry that does not fit is counted but not stored,
so that the host can allocate longer lists and search again: no pair is dropped.
"""

from __future__ import annotations

import math
from typing import Any

import warp as wp

FIRST_CAPACITY = 16
"""Capacity of a list before its first growth."""


@wp.func
def insert_sorted(lists: wp.array2d[wp.int32], i: int, found: int, entry: int) -> None:
    """Insert an entry into list i, which holds ``found`` smaller and larger ones; do nothing if the list is full."""
    place = found
    if place < lists.shape[1]:
        while place > 0 and lists[i, wp.max(place - 1, 0)] > entry:
            lists[i, place] = lists[i, place - 1]
            place -= 1
        lists[i, place] = entry


def allocate_lists(count: int, longest: int, device: wp.Device) -> wp.array[Any]:
    """Allocate ``count`` lists for ``longest`` entries and a quarter more, shape (count, capacity).

    On a GPU the lists of neighbouring elements are interleaved, so that a warp reads whole lines of memory.
    """
    capacity = math.ceil(longest * 1.25 / 8) * 8 if longest > FIRST_CAPACITY else longest
    if device.is_cuda:
        return wp.zeros((capacity, count), dtype=wp.int32, device=device).transpose()
    return wp.zeros((count, capacity), dtype=wp.int32, device=device)
