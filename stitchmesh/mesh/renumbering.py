# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Numbered things of which some leave and others come: faces, sides or vertices before and after a change.

What stays keeps its order and takes the numbers that what comes leaves free.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

IntArray = NDArray[np.int64]

GONE = -1
"""Number after of what leaves."""


@dataclass(frozen=True, eq=False)
class Renumbering:
    """Numbers before and after."""

    count: int
    """How many things there are before."""
    kept: IntArray
    """Numbers before of those that stay, ascending, shape (k,)."""
    moved: IntArray
    """Their numbers after, shape (k,)."""
    added: IntArray
    """Numbers after of those that come, shape (n,)."""

    @classmethod
    def of(cls, count: int, removed: IntArray, added: IntArray) -> Renumbering:
        """Some of ``count`` things leave, by their numbers before, and others come, by their numbers after."""
        stays = np.ones(count, dtype=bool)
        stays[removed] = False
        kept = np.flatnonzero(stays)
        free = np.ones(len(kept) + len(added), dtype=bool)
        free[added] = False
        return cls(count, kept, np.flatnonzero(free), added)

    @classmethod
    def filling(cls, count: int, removed: IntArray, coming: int) -> Renumbering:
        """The same where so many come that take the numbers that become free, and then go on from the last one."""
        more = np.arange(count, count + max(coming - len(removed), 0))
        return cls.of(count, removed, np.concatenate([removed[:coming], more]).astype(np.int64))

    @cached_property
    def after(self) -> IntArray:
        """Number after of each thing before, ``GONE`` where it leaves, shape (count,)."""
        after = np.full(self.count, GONE)
        after[self.kept] = self.moved
        return after

    def merged(self, before: NDArray, coming: NDArray) -> NDArray:
        """Values of all things after, from those of all before, shape (count, ...), and those of the ones that come."""
        result = np.empty((len(self.moved) + len(self.added), *before.shape[1:]), dtype=before.dtype)
        result[self.moved], result[self.added] = before[self.kept], coming
        return result
