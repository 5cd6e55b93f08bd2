# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Numbers of faces, sides or vertices before and after a change that removes some of them and adds others.

The elements that are kept stay in their order. They take the numbers that are not given to added elements.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

IntArray = NDArray[np.int64]

REMOVED = -1
"""Number of a removed element after the change."""


@dataclass(frozen=True, eq=False)
class Renumbering:
    """Numbers of elements before and after a change."""

    count: int
    """Number of elements before the change."""
    kept: IntArray
    """Numbers of the kept elements before the change, ascending, shape (k,)."""
    moved: IntArray
    """Numbers of the kept elements after the change, shape (k,)."""
    added: IntArray
    """Numbers of the added elements after the change, shape (n,)."""

    @classmethod
    def of(cls, count: int, removed: IntArray, added: IntArray) -> Renumbering:
        """Renumber after some elements are removed and others are added with given numbers.

        Args:
            count: number of elements before the change.
            removed: numbers of the removed elements before the change.
            added: numbers of the added elements after the change.
        """
        is_kept = np.ones(count, dtype=bool)
        is_kept[removed] = False
        kept = np.flatnonzero(is_kept)
        free = np.ones(len(kept) + len(added), dtype=bool)
        free[added] = False
        return cls(count, kept, np.flatnonzero(free), added)

    @classmethod
    def filling(cls, count: int, removed: IntArray, added_count: int) -> Renumbering:
        """Renumber so that added elements first take the numbers of removed ones, and then numbers from ``count``.

        Args:
            count: number of elements before the change.
            removed: numbers of the removed elements before the change, ascending.
            added_count: number of added elements.
        """
        more = np.arange(count, count + max(added_count - len(removed), 0))
        return cls.of(count, removed, np.concatenate([removed[:added_count], more]).astype(np.int64))

    @cached_property
    def after(self) -> IntArray:
        """Number after the change of each element before it, ``REMOVED`` if the element is removed, shape (count,)."""
        after = np.full(self.count, REMOVED)
        after[self.kept] = self.moved
        return after

    def merged(self, before: NDArray, added: NDArray) -> NDArray:
        """Return the values of all elements after the change, shape (k + n, ...).

        Args:
            before: values of all elements before the change, shape (count, ...).
            added: values of the added elements, shape (n, ...).
        """
        result = np.empty((len(self.moved) + len(self.added), *before.shape[1:]), dtype=before.dtype)
        result[self.moved], result[self.added] = before[self.kept], added
        return result
