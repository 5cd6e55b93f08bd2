# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What is prepared once and used many times, until an array to which it refers is replaced.

A captured launch holds the addresses of its arrays. Code that replaces such an array, because it has become too small,
counts its generation up. A simulation compares the generations of everything it launches before each use, and forgets
what it has prepared if one of them has changed. Nothing else says that captured launches are stale.

A simulation holds its captures, so the captures refer to it weakly. Otherwise the two would keep each other, with all
arrays on the device, until Python's collector of cycles runs, which may be long after the next simulation has begun.
"""

from __future__ import annotations

import weakref
from collections.abc import Callable, Hashable
from typing import Any, Generic, TypeVar

T = TypeVar("T")
Owner = TypeVar("Owner")

MOST = 64
"""Largest number of entries; the oldest one is forgotten first."""


class Captures(Generic[Owner]):
    """Captured launches, or values that hold some, by name."""

    def __init__(self, owner: Owner, generations: Callable[[Owner], Hashable]) -> None:
        """Begin without any.

        Args:
            owner: the simulation that holds the captures.
            generations: returns the generations of all its arrays that captured launches name.
        """
        self._owner, self._generations = weakref.ref(owner), generations
        self._current: Hashable = None
        self._kept: dict[Hashable, tuple[tuple[object, ...], Any]] = {}

    def get(self, name: Hashable, make: Callable[[], T], of: tuple[object, ...] = ()) -> T:
        """Return what is kept under a name, or else make it and keep it.

        Args:
            name: name of the work; numbers that its launches contain are part of the name.
            make: prepares the launches.
            of: further objects that the launches name. If one of them is another one than before, the launches are made
                again.
        """
        owner = self._owner()
        assert owner is not None
        current = self._generations(owner)
        if current != self._current:
            self._kept.clear()
            self._current = current
        kept = self._kept.get(name)
        if kept is None or any(one is not other for one, other in zip(kept[0], of, strict=True)):
            kept = self._kept[name] = of, make()
            while len(self._kept) > MOST:
                del self._kept[next(iter(self._kept))]
        made: T = kept[1]
        return made
