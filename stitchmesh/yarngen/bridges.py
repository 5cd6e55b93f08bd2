# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarn between crossings that do not lie across from one another, and yarn that ends.

A crossing is a place where yarn passes a side of a stitch face, numbered ``side * SLOTS + slot``. Yarn that leaves a
face through one goes on in the face across the side (``tracing.py``), unless a bridge leads it elsewhere or it ends
in a tail there: the turns of row ends, loops that change places in a cable, floats between stitches of one yarn.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from stitchmesh.mesh import FloatArray

SLOTS = 3
"""Most crossings of a side: a course side has two, a wale side one, or three in a chain that binds off."""

Image = tuple[int, int]
"""How many periods away along the courses and along the wales."""
HERE: Image = (0, 0)
"""The same image."""


def crossing_number(side: int, slot: int = 0) -> int:
    """Number of a side's crossing; slots are counted along the side."""
    return int(side) * SLOTS + slot


@dataclass(frozen=True, eq=False)
class BridgePath:
    """Where a bridge leads."""

    to: int
    """Crossing at its other end."""
    points: FloatArray
    """Points on the way there [cm], shape (n, 3), in the lattice image of the part that they belong to; none where the
    crossings lie side by side."""
    is_return: bool
    """Whether the points belong to the part that it leads to, rather than to the part that it comes from."""
    ease: float = 1.0
    """Rest length of its yarn over the length that is drawn."""
    image: Image = HERE
    """Lattice image of the part that it leads to, seen from the part that it comes from."""
    floats: bool = False
    """Whether it leads behind stitches of other yarns."""


@dataclass(frozen=True, eq=False)
class Bridges:
    """Bridges and tails by the crossings where they begin."""

    ways: dict[int, BridgePath] = field(default_factory=dict)
    """The bridge at each bridged crossing, both ways."""
    tails: dict[int, FloatArray] = field(default_factory=dict)
    """Points of the tail at each crossing where yarn ends [cm], away from it, shape (n, 3)."""

    def join(
        self, first: int, second: int, points: FloatArray, *, ease: float = 1.0, image: Image = HERE,
        floats: bool = False,
    ) -> None:  # fmt: skip
        """Lead the yarn from one crossing to another through points that belong to the part at the first [cm].

        ``image`` is that of the part at the second crossing, seen from the first.
        """
        back = (-image[0], -image[1])
        self.ways[first] = BridgePath(second, points, is_return=False, ease=ease, image=image, floats=floats)
        self.ways[second] = BridgePath(first, points[::-1], is_return=True, ease=ease, image=back, floats=floats)

    def tie(self, crossing: int, tail: FloatArray) -> None:
        """End the yarn at a crossing in a tail [cm]."""
        self.tails[crossing] = tail

    def holds(self, crossing: int) -> bool:
        """Whether the yarn at a crossing goes elsewhere than across."""
        return crossing in self.ways or crossing in self.tails
