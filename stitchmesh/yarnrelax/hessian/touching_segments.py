# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The segments that touch each segment: those whose contact samples form pairs with its own.

They decide which blocks of the assembled Hessian are not zero. Each list is ascending and without repetition. The
blocks of a pair of segments are stored once, for the segment with the lower number; a segment may touch an image of
itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import Launcher, ZeroArray
from stitchmesh.compute.kernel import kernel
from stitchmesh.yarnrelax.energies.pair_stiffness import PairStiffness
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.lattice_images import sample_number

CAPACITY = 16
"""Segments that may touch a segment before the lists are made longer; about six do in a fabric at rest."""


@wp.func
def insert_number(lists: wp.array2d[wp.int32], row: int, count: int, number: int) -> int:
    """Insert a number into an ascending list; its new length, which is one too many if the list has no room."""
    capacity = lists.shape[1]
    if count > capacity:
        return count
    place = count
    while place > 0 and lists[row, place - 1] > number:
        place -= 1
    if place > 0 and lists[row, place - 1] == number:
        return count
    if count < capacity:
        for k in range(count - place):
            lists[row, count - k] = lists[row, count - k - 1]
        lists[row, place] = number
    return count + 1


@wp.func
def place_in_list(lists: wp.array2d[wp.int32], row: int, count: int, number: int) -> int:
    """Place of a number in an ascending list; -1 where it is not there."""
    low, high = int(0), int(count)
    while low < high:
        middle = (low + high) // 2
        if lists[row, middle] < number:
            low = middle + 1
        else:
            high = middle
    if low < count and lists[row, low] == number:
        return low
    return -1


@kernel
def list_touching_segments(
    # model
    model: Any,
    images: Any,
    # state in
    pair_count: wp.array[wp.int32],
    entries: wp.array2d[wp.int32],
    # state in and out
    count: wp.array[wp.int32],
    segments: wp.array2d[wp.int32],
) -> None:
    """Add the segments that some pairs connect to each segment."""
    s = wp.tid()
    found = count[s]
    for p in range(model.sample_start[s], model.sample_start[s + 1]):
        for c in range(pair_count[p]):
            found = insert_number(segments, s, found, model.sample_segment[sample_number(images, entries[p, c])])
    count[s] = found


class TouchingSegments:
    """The lists on a device."""

    def __init__(self, model: Model) -> None:
        """Allocate short lists."""
        self.model = model
        self.count = wp.zeros(model.segment_count, dtype=wp.int32, device=model.device)
        """Number of segments that touch each segment, shape (S,)."""
        self._allocate(CAPACITY)

    def _allocate(self, capacity: int) -> None:
        shape = (self.model.segment_count, capacity)
        self.segments = wp.zeros(shape, dtype=wp.int32, device=self.model.device)
        """Their numbers, ascending, shape (S, capacity)."""

    def launches(self, pairs: Sequence[PairStiffness], launcher: Launcher) -> list[Any]:
        """The launches that list the segments that any of the pairs connect."""
        listing = [
            launcher(list_touching_segments, self.model.segment_count,
                     [self.model.constants, own.images, own.count, own.entries], [self.count, self.segments])
            for own in pairs
        ]  # fmt: skip
        return [ZeroArray(self.count), *listing]

    def on_host(self) -> TouchingLists | None:
        """The lists as they were found; None if they had no room, which they have the next time."""
        count = self.count.numpy()
        most, capacity = int(count.max()), self.segments.shape[1]
        if most > capacity:
            self._allocate(2 * capacity)
            return None
        listed = np.arange(capacity) < count[:, None]
        return TouchingLists(count.astype(np.int64), self.segments.numpy()[listed].astype(np.int64))


@dataclass(frozen=True, eq=False)
class TouchingLists:
    """The lists of all segments on the host, one after the other."""

    count: NDArray[np.int64]
    """Length of each list, shape (S,)."""
    segments: NDArray[np.int64]
    """The segments of all lists, shape (n,)."""

    def is_like(self, other: TouchingLists) -> bool:
        """Whether the same segments touch."""
        return np.array_equal(self.count, other.count) and np.array_equal(self.segments, other.segments)
