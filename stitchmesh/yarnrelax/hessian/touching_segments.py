# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Lists the segments that touch each segment: their contact samples form pairs with its own.

These segments decide which blocks of the assembled Hessian are not zero. Each list is ascending and without repetition.
The blocks of a pair of segments are stored once, for the segment with the lower number. A segment may touch an image of
itself.

The places of the blocks, and the analysis of the factors, last as long as the lists for which they were found. On the
way to rest, segments touch, part and touch again. If the analysis takes longer than the factors, all segments that the
candidate lists connect therefore have places; segments that do not touch have blocks of zeros.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.captured import Launcher, ZeroArray
from stitchmesh.compute.kernel import kernel
from stitchmesh.yarnrelax.collision.narrow_phase import Candidates
from stitchmesh.yarnrelax.energies.pair_stiffness import PairStiffness
from stitchmesh.yarnrelax.model.constants import Model, YarnConstants
from stitchmesh.yarnrelax.model.lattice_images import LatticeImages, cell_of, sample_number

CAPACITY = 16
"""First number of segments that may touch a segment; longer lists follow. A fabric at rest needs about six."""
LESS, MISSING = wp.constant(1), wp.constant(2)
"""How the list of a segment differs from the kept one."""


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
    model: YarnConstants,
    images: LatticeImages,
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


@kernel
def compare_lists(
    # model
    kept_count: wp.array[wp.int32],
    kept: wp.array2d[wp.int32],
    # state in
    count: wp.array[wp.int32],
    segments: wp.array2d[wp.int32],
    # state out
    difference: wp.array[wp.int32],
) -> None:
    """``MISSING`` for each list with a number that the kept list has not, ``LESS`` if it only lacks some of them."""
    s = wp.tid()
    found = wp.where(kept_count[s] > count[s], LESS, 0)
    for k in range(count[s]):
        if place_in_list(kept, s, kept_count[s], segments[s, k]) < 0:
            found = MISSING
    difference[s] = found


@kernel
def copy_lists(
    # state in
    count: wp.array[wp.int32],
    segments: wp.array2d[wp.int32],
    # state out
    copied_count: wp.array[wp.int32],
    copied: wp.array2d[wp.int32],
) -> None:
    """The same lists with another capacity."""
    s = wp.tid()
    copied_count[s] = count[s]
    for k in range(count[s]):
        copied[s, k] = segments[s, k]


@kernel
def put_former_lists(
    # model
    images: LatticeImages,
    changed: wp.array[wp.int32],
    # state in
    former_count: wp.array[wp.int32],
    former: wp.array2d[wp.int32],
    # state out
    count: wp.array[wp.int32],
    segments: wp.array2d[wp.int32],
) -> None:
    """The former lists in the cells that have not changed."""
    s = wp.tid()
    if changed[cell_of(images, s)] == 0:
        count[s] = former_count[s]
        for k in range(former_count[s]):
            segments[s, k] = former[s, k]


class TouchingSegments:
    """The lists of the present state, and the lists for which matrices have places, on a device."""

    def __init__(self, model: Model) -> None:
        """Allocate short lists; no pair has places yet."""
        self.model = model
        self.count, self.kept_count = (
            wp.zeros(model.segment_count, dtype=wp.int32, device=model.device) for _ in range(2)
        )
        """Number of segments that touch each segment, and number of segments that have places with it, shape (S,)."""
        self.segments, self.kept = self._lists(CAPACITY), self._lists(CAPACITY)
        """Numbers of these segments, ascending, shape (S, capacity)."""

    def _lists(self, capacity: int) -> wp.array[Any]:
        return wp.zeros((self.model.segment_count, capacity), dtype=wp.int32, device=self.model.device)

    def launches(self, pairs: Sequence[PairStiffness], launcher: Launcher) -> list[Any]:
        """Return the launches that list the segments that any of the pairs connect."""
        listing = [
            launcher(list_touching_segments, self.model.segment_count,
                     [self.model.constants, own.images, own.count, own.entries], [self.count, self.segments])
            for own in pairs
        ]  # fmt: skip
        return [ZeroArray(self.count), *listing]

    def make_room(self) -> bool:
        """Lengthen the lists of the present state if they are too short; return whether they must be made again."""
        most = int(self.count.numpy().max())
        if most <= self.segments.shape[1]:
            return False
        self.segments = self._lists(2 * most)
        return True

    def keep(self, candidates: Candidates | None) -> bool:
        """Keep the present lists of the cells whose kept lists do not suit; return whether any cell changed.

        Args:
            candidates: the candidate lists, whose segments get places too, so that the places last longer; None to give
                places only to the segments that touch.
        """
        model, count = self.model, self.model.segment_count
        difference = wp.zeros(count, dtype=wp.int32, device=model.device)
        found, former = [self.count, self.segments], [self.kept_count, self.kept]
        model.launch(compare_lists, count, [*former, *found], [difference])
        least = LESS if candidates is None else MISSING
        changed = np.maximum.reduceat(difference.numpy(), model.segment_start[:-1]) >= least
        if not changed.any():
            return False
        images, capacity = model.constants.images, max(self.segments.shape[1], self.kept.shape[1])
        self.kept_count = wp.zeros_like(self.count)
        while True:
            self.kept = self._lists(capacity)
            kept = [self.kept_count, self.kept]
            model.launch(copy_lists, count, found, kept)
            if candidates is not None:
                inputs = [model.constants, images, candidates.count, candidates.lists]
                model.launch(list_touching_segments, count, inputs, kept)
            if int(self.kept_count.numpy().max()) <= capacity:
                break
            capacity *= 2
        if not changed.all():
            model.launch(put_former_lists, count, [images, model.integers(changed), *former], kept)
        return True
