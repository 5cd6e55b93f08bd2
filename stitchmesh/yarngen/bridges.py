# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Bridges and tails, where yarn leaves a face through a side but does not continue in the face across it.

A crossing is a place where yarn crosses a side of a stitch face. It has the number ``side * SLOTS + slot``. Yarn that
leaves a face through a crossing normally continues in the face across that side (``tracing.py``). There are two
exceptions: a bridge leads the yarn to another crossing, or the yarn ends there in a tail. Bridges form the turns at row
ends, the loops that change places in a cable, and the floats between stitches of one yarn.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from stitchmesh.mesh import FloatArray

SLOTS = 3
"""Largest number of crossings of a side. A course side has two crossings. A wale side has one, or three in a chain
bind-off."""

Image = tuple[int, int]
"""Lattice image: the number of periods along the courses and the number of periods along the wales."""
SAME_IMAGE: Image = (0, 0)
"""The lattice image of the cell itself."""


def crossing_number(side: int, slot: int = 0) -> int:
    """Number of a crossing, from the number of its side and its slot. Slots are counted along the side."""
    return int(side) * SLOTS + slot


@dataclass(frozen=True, eq=False)
class BridgePath:
    """The path of the yarn along a bridge, seen from one of its two ends."""

    to: int
    """Number of the crossing at the other end of the bridge."""
    points: FloatArray
    """Points of the yarn between the two crossings [cm], shape (n, 3), in the lattice image of the part that owns them.
    The array is empty where the two crossings lie side by side."""
    belongs_to_target: bool
    """True if the points belong to the yarn part at the other end of the bridge, false if they belong to the part at
    this end."""
    rest_length_ratio: float = 1.0
    """Rest length of the yarn of the bridge over its length as generated."""
    image: Image = SAME_IMAGE
    """Lattice image of the yarn part at the other end, seen from the part at this end."""
    is_float: bool = False
    """Whether the bridge is a float, which lies behind stitches of other yarns."""


@dataclass(frozen=True, eq=False)
class Bridges:
    """Bridges and tails, stored by the crossings at which they begin."""

    paths: dict[int, BridgePath] = field(default_factory=dict)
    """The bridge path from each crossing that has a bridge. Each bridge is stored twice, once from either end."""
    tails: dict[int, FloatArray] = field(default_factory=dict)
    """Points of the tail at each crossing at which a yarn ends [cm], shape (n, 3). The first point is next to the
    crossing."""

    def join(
        self, first: int, second: int, points: FloatArray, *, rest_length_ratio: float = 1.0, image: Image = SAME_IMAGE,
        is_float: bool = False,
    ) -> None:  # fmt: skip
        """Join two crossings by a bridge.

        Args:
            first: number of the crossing at which the bridge begins.
            second: number of the crossing at which the bridge ends.
            points: points of the yarn between the crossings [cm], shape (n, 3); they belong to the yarn part at
                ``first``.
            rest_length_ratio: rest length of the yarn of the bridge over its length as generated.
            image: lattice image of the yarn part at ``second``, seen from the part at ``first``.
            is_float: whether the bridge is a float, which lies behind stitches of other yarns.
        """
        back = (-image[0], -image[1])
        self.paths[first] = BridgePath(
            second, points, belongs_to_target=False, rest_length_ratio=rest_length_ratio, image=image, is_float=is_float
        )
        self.paths[second] = BridgePath(
            first,
            points[::-1],
            belongs_to_target=True,
            rest_length_ratio=rest_length_ratio,
            image=back,
            is_float=is_float,
        )

    def end_in_tail(self, crossing: int, tail: FloatArray) -> None:
        """End the yarn at a crossing in a tail, given by its points [cm], shape (n, 3)."""
        self.tails[crossing] = tail

    def redirects(self, crossing: int) -> bool:
        """Whether a bridge or a tail begins at a crossing, so that the yarn does not continue across the side."""
        return crossing in self.paths or crossing in self.tails
