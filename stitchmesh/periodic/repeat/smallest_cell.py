# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The smallest cell of a repeat: stitches that are alike in a pattern rest alike.

A repeat of a pattern often contains the same courses several times: both rows of a rib are alike, and moss stitch
repeats itself two rows above, one stitch aside. With u and v the periods of the repeat, the translation

    t = (k u + v) / n        n > 1,  0 <= k < n

then takes the generated yarns to themselves, and the periods u and t span a smaller cell, with one n-th of the yarns. A
fabric whose repeats lie alike lies like this in any of its larger cells too. In the larger cell the yarns have more
ways to fall over: every second course of a slack rib turns to the other side, for example. Such states are found or
missed by chance, and the pattern does not show them. Real fabrics do not go to them by themselves, since friction holds
their loops. Free swatches therefore come to rest in their smallest cell, and the yarns of the repeat are its images.

A yarn is the image of another one if its control points are the images of the other's, in their order, and if both have
the same radius and length. Translations that take a yarn to itself are not used.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stitchmesh.lattice import Lattice
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import RelaxCell


@dataclass(frozen=True, eq=False)
class SmallestCell:
    """The smallest cell of a repeat, and where its images lie."""

    copies: int
    """n, the number of images of the cell in the repeat."""
    aside: int
    """k: the cell above is shifted along the first period by k n-th parts of it."""
    kept: IntArray
    """The yarns of the cell, in ascending order."""
    origin: IntArray
    """The kept yarn whose image each yarn of the repeat is, shape (Y,)."""
    image: IntArray
    """The translation from that kept yarn to each yarn: how many t, and how many u and v in addition, shape (Y, 3)."""
    roll: FloatArray
    """Where the first control point of the kept yarn stands among the control points of the image, over their number,
    shape (Y,)."""

    @classmethod
    def of(cls, yarns: YarnSet, lengths: FloatArray) -> SmallestCell:
        """Find the smallest cell of generated yarns; the whole repeat if it has no smaller one.

        Args:
            yarns: the yarns on their lattice, as generated.
            lengths: rest length of each yarn [cm], shape (Y,).
        """
        assert yarns.lattice is not None
        for copies in range(yarns.yarn_count, 1, -1):
            if yarns.yarn_count % copies == 0:
                for aside in range(copies):
                    found = _cell(yarns, lengths, copies, aside)
                    if found is not None:
                        return found
        return cls.whole(yarns.yarn_count)

    @classmethod
    def whole(cls, yarn_count: int) -> SmallestCell:
        """Return the whole repeat as its own smallest cell."""
        everyone = np.arange(yarn_count)
        return cls(1, 0, everyone, everyone, np.zeros((yarn_count, 3), dtype=np.int64), np.zeros(yarn_count))

    def part_of(self, yarns: YarnSet) -> YarnSet:
        """Return the yarns of the smallest cell, on its lattice.

        Args:
            yarns: the yarns of the repeat, with any control points.
        """
        if self.copies == 1:
            return yarns
        assert yarns.lattice is not None and yarns.lattice_step is not None
        u, v = yarns.lattice.periods
        counts = np.diff(yarns.start)
        points = np.concatenate([np.arange(yarns.start[y], yarns.start[y + 1]) for y in self.kept])
        segments = np.concatenate([np.arange(*yarns.segment_start[y : y + 2]) for y in self.kept])
        step = yarns.lattice_step[self.kept]
        return replace(
            yarns, points=yarns.points[points], start=np.concatenate([[0], np.cumsum(counts[self.kept])]),
            closed=yarns.closed[self.kept], radius=yarns.radius[self.kept], rest_length=yarns.rest_length[segments],
            row=yarns.row[points], face=yarns.face[points], part=yarns.part[points], colour=yarns.colour[self.kept],
            natural_curvature=yarns.natural_curvature[points], drawn_radius=yarns.drawn_radius[self.kept],
            mass_per_length=yarns.mass_per_length[self.kept],
            lattice=Lattice(np.stack([u, (self.aside * u + v) / self.copies])),
            lattice_step=np.stack([step[:, 0] - self.aside * step[:, 1], self.copies * step[:, 1]], axis=1),
        )  # fmt: skip

    def cell_of(self, cell: RelaxCell) -> RelaxCell:
        """Return the degrees of freedom of the smallest cell, with its share of the loads that act on the repeat.

        The load along the courses acts on the height of a cell, and the load along the wales on its width.
        """
        return cell if cell.course is None else replace(cell, course=cell.course / self.copies)

    def period_of(self, size: Sequence[float | None]) -> list[float | None]:
        """Return the width and height of the smallest cell for the width and height of a repeat; None stays None."""
        width, height = size
        return [width, None if height is None else height / self.copies]

    def whole_lattice(self, lattice: Lattice) -> Lattice:
        """Return the lattice of the repeat from the lattice of the smallest cell."""
        u, t = lattice.periods
        return Lattice(np.stack([u, self.copies * t - self.aside * u]))

    def is_that_of(self, other: SmallestCell) -> bool:
        """Whether the same yarns have the same images."""
        return (self.copies, self.aside) == (other.copies, other.aside) and np.array_equal(self.kept, other.kept)

    def repeated(self, yarns: YarnSet, like: YarnSet) -> YarnSet:
        """Return the yarns of the repeat as images of the yarns of the smallest cell.

        Args:
            yarns: the yarns of the smallest cell; each has equal rest lengths in all segments.
            like: the yarns of the repeat, whose stitches, rows, parts and colours the result has.
        """
        if self.copies == 1:
            return yarns
        assert yarns.lattice is not None and like.lattice_step is not None
        t, lattice = yarns.lattice.periods[1], self.whole_lattice(yarns.lattice)
        points, rest, natural = [], [], []
        for yarn, own in enumerate(self.origin):
            curve = yarns.points[yarns.start[own] : yarns.start[own + 1]]
            place = np.arange(len(curve)) - round(float(self.roll[yarn]) * len(curve))
            turn = (place // len(curve))[:, None] * lattice.shift(like.lattice_step[yarn])
            moved = self.image[yarn, 0] * t + lattice.shift(self.image[yarn, 1:])
            points.append(curve[place % len(curve)] + turn + moved)
            natural.append(yarns.natural_curvature[yarns.start[own] + place % len(curve)])
            rest.append(yarns.rest_length[yarns.segment_start[own] : yarns.segment_start[own + 1]])
        return replace(
            like, points=np.concatenate(points), rest_length=np.concatenate(rest), lattice=lattice,
            natural_curvature=np.concatenate(natural),
            radius=yarns.radius[self.origin], drawn_radius=yarns.drawn_radius[self.origin],
            mass_per_length=yarns.mass_per_length[self.origin],
        )  # fmt: skip


def _cell(yarns: YarnSet, lengths: FloatArray, copies: int, aside: int) -> SmallestCell | None:
    """Return the cell of a translation; None if the translation does not take the yarns to one another."""
    assert yarns.lattice is not None
    u, v = yarns.lattice.periods
    move = (aside * u + v) / copies
    origin = np.full(yarns.yarn_count, -1)
    image, roll = np.zeros((yarns.yarn_count, 3), dtype=np.int64), np.zeros(yarns.yarn_count)
    kept: list[int] = []
    for first in range(yarns.yarn_count):
        if origin[first] >= 0:
            continue
        yarn, origin[first] = first, len(kept)
        for count in range(1, copies + 1):
            step = _image_of(yarns, lengths, yarn, move)
            if step is None or (origin[step[0]] >= 0) != (count == copies) or (count == copies and step[0] != first):
                return None
            if count < copies:
                before, (yarn, more, behind) = yarn, step
                origin[yarn] = len(kept)
                image[yarn] = [count, *(image[before, 1:] + behind)]
                roll[yarn] = roll[before] + more
        kept.append(first)
    return SmallestCell(copies, aside, np.array(kept), origin, image, roll)


def _image_of(yarns: YarnSet, lengths: FloatArray, yarn: int, move: FloatArray) -> tuple[int, float, IntArray] | None:
    """Return the yarn to which a translation takes a yarn, its roll, and the lattice image to add; None without one."""
    assert yarns.lattice is not None and yarns.lattice_step is not None
    own = yarns.points[yarns.start[yarn] : yarns.start[yarn + 1]] + move
    # Control points that are closer to each other lie at the same place.
    near = 1e-6 * float(np.linalg.norm(yarns.lattice.periods[0]))
    away = yarns.points - own[0]
    behind = np.rint(away @ np.linalg.pinv(yarns.lattice.periods)).astype(np.int64)
    for point in np.flatnonzero(np.linalg.norm(away - yarns.lattice.shift(behind), axis=1) < near):
        other = int(yarns.point_yarn[point])
        first, last = yarns.start[other : other + 2]
        # Largest relative difference of lengths and radii that count as equal
        alike = (yarns.closed[[yarn, other]].all() and len(own) == last - first
                 and (yarns.lattice_step[yarn] == yarns.lattice_step[other]).all()
                 and np.allclose([lengths[yarn], yarns.radius[yarn]], [lengths[other], yarns.radius[other]],
                                 rtol=1e-9, atol=0.0))  # fmt: skip
        if not alike:
            continue
        place = np.arange(len(own)) + int(point - first)
        turn = (place // len(own))[:, None] * yarns.lattice.shift(yarns.lattice_step[other])
        there = yarns.points[first + place % len(own)] + turn - yarns.lattice.shift(behind[point])
        if np.abs(there - own).max() < near:
            return other, int(point - first) / len(own), behind[point]
    return None
