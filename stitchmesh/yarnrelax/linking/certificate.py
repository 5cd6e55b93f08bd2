# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The linking certificate: which yarns are linked, as exact integers.

The linking number of two closed curves is half the sum of the signs of their crossings in a projection,

    2 lk(A, B) = sum of sign(c) over crossings c of A and B,

and cannot change unless one passes through the other. Yarns are taken as polylines with whole coordinates
(``picture``), whose crossings and signs are decided without rounding (``crossings``): the numbers are exact for those
polylines, which differ from the curves by a few hundredths of a radius. A change proves that a yarn passed through
another. That nothing changed does not prove that none did, for two passes in opposite senses cancel.

Open yarns are closed far away (``closing``). The closing is no yarn, and others may move through it: the linking of an
open yarn tells how it lies, but only that of two closed yarns is a certificate, which no motion without pull-through
can change.

On a lattice a yarn stands for all its copies, moved by a periods u + b periods v. A yarn whose lattice step is zero is
a ring in each copy; one with another step is an endless line, which its own step moves onto itself. For two yarns and
each image (a, b) of the second relative to the first the signs are summed over one period that the two copies share,
seen along the normal of the fabric or nearly; images that steps of either yarn carry into one another are one. The sum
is a certificate too: motions change the picture, a diagram on a torus, by Reidemeister's moves, of which the second and
third keep the sum, while the first is about a yarn and itself. Nor does it depend on the direction of the projection,
for another direction is a shear of space along the fabric. Rings, and lines that run the same way, cross an even number
of times: half the sum is their linking number. Two lines that run across each other have an odd sum, 1 or -1 where one
lies over the other. Two copies of one yarn count as two yarns; where half its step swaps them, a crossing and the one
that it is carried into count once. Open yarns on a lattice are not closed: their sums tell how they lie.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csr_array

from stitchmesh.compute.device import alone, device_named
from stitchmesh.mesh import IntArray
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.linking.crossing_codes import decoded
from stitchmesh.yarnrelax.linking.crossings import edge_crossings
from stitchmesh.yarnrelax.linking.open_yarns import closing_crossings
from stitchmesh.yarnrelax.linking.projection import draw


@dataclass(frozen=True, eq=False)
class DoubledLinking:
    """Sums of crossing signs, one row for two yarns and an image where it is not zero, sorted."""

    yarn_count: int
    """Number of yarns, Y."""
    yarns: IntArray
    """Two yarns in ascending order, the same one twice for two of its copies, shape (n, 2)."""
    image: IntArray
    """Lattice image of the second relative to the first, (0, 0) without a lattice, shape (n, 2)."""
    doubled: IntArray
    """Sum of the signs of their crossings, twice the linking number of closed yarns, shape (n,)."""


def linking_certificate(yarns: YarnSet, *, device: str | None = None) -> csr_array:
    """Linking numbers of all pairs of yarns, a symmetric integer matrix of shape (Y, Y).

    Without a lattice the diagonal is zero. On a lattice an entry is the sum over all images of the signs of crossings,
    which is twice the linking number where two yarns cross an even number of times, and the diagonal tells of crossings
    of different copies of a yarn; ``doubled_linking`` has the images one by one.

    Args:
        yarns: closed or open yarns.
        device: "cpu", "cuda:0" ...; the first GPU, else the CPU, where not given. Devices agree but for yarns that
            lie within a unit of one another, some millionths of an edge.

    Raises:
        ParameterError: an unknown device, or yarns over too many periods of a lattice.
    """
    linking = doubled_linking(yarns, device=device)
    first, second = linking.yarns.T
    entries = linking.doubled if yarns.lattice is not None else linking.doubled // 2
    half = coo_array((entries, (first, second)), shape=(linking.yarn_count,) * 2).tocsr()
    across = first != second
    return half + coo_array((entries[across], (second[across], first[across])), shape=half.shape).tocsr()


@alone()
def doubled_linking(yarns: YarnSet, *, device: str | None = None) -> DoubledLinking:
    """Sums of crossing signs of all pairs of yarns and images.

    Args:
        yarns: closed or open yarns.
        device: as for ``linking_certificate``.

    Raises:
        ParameterError: as for ``linking_certificate``.
    """
    picture = draw(yarns, device_named(device))
    codes = edge_crossings(picture)
    arcs, arc_signs = np.zeros((0, 2), dtype=np.int64), np.zeros(0, dtype=np.int64)
    if yarns.lattice is None and not yarns.closed.all():
        line_codes, arcs, arc_signs = closing_crossings(picture, yarns.closed)
        codes = np.concatenate([codes, line_codes])
    codes, counts = np.unique(codes, return_counts=True)
    pairs, images, signs = decoded(picture, codes)
    pairs = np.concatenate([pairs, arcs])
    images = np.concatenate([_representative(images, pairs[: len(images)], picture.step.numpy()), 0 * arcs])
    rows, doubled = _summed(np.concatenate([pairs, images], axis=1), np.concatenate([counts * signs, arc_signs]))
    return DoubledLinking(yarns.yarn_count, rows[:, :2], rows[:, 2:], doubled)


def changed_pairs(before: DoubledLinking | csr_array, after: DoubledLinking | csr_array) -> IntArray:
    """Pairs of yarns whose linking differs in some image, shape (n, 2), each pair once, in ascending order.

    Args:
        before: linking of the yarns, or their ``linking_certificate``, which sums over images.
        after: the same of the same yarns later.
    """
    (old_rows, old_sums), (new_rows, new_sums) = _rows(before), _rows(after)
    rows, _ = _summed(np.concatenate([old_rows, new_rows]), np.concatenate([old_sums, -new_sums]))
    return np.unique(rows[:, :2], axis=0)


def _rows(linking: DoubledLinking | csr_array) -> tuple[IntArray, IntArray]:
    """Two yarns and an image, and their sum of signs or entry."""
    if isinstance(linking, DoubledLinking):
        return np.concatenate([linking.yarns, linking.image], axis=1), linking.doubled
    entries = linking.tocoo()
    upper = entries.row <= entries.col
    pairs = np.stack([entries.row, entries.col], axis=1)[upper].astype(np.int64)
    return np.concatenate([pairs, 0 * pairs], axis=1), entries.data[upper]


def _summed(rows: IntArray, values: IntArray) -> tuple[IntArray, IntArray]:
    """Equal rows once, sorted, with the sum of their values where it is not zero."""
    if len(rows) == 0:
        return rows, values
    order = np.lexsort(rows.T[::-1])
    rows, values = rows[order], values[order]
    first = np.flatnonzero(np.append(True, (np.diff(rows, axis=0) != 0).any(axis=1)))
    total: IntArray = np.add.reduceat(values, first)
    return rows[first][total != 0], total[total != 0]


def _representative(image: IntArray, pairs: IntArray, step: IntArray) -> IntArray:
    """One image for all that steps of the two yarns carry into one another, or that swap two copies of one yarn."""
    first, second = _reduced_steps(step[pairs[:, 0]].astype(np.int64), step[pairs[:, 1]].astype(np.int64))
    here, there = _modulo(image, first, second), _modulo(-image, first, second)
    swap = (there[:, 0] < here[:, 0]) | ((there[:, 0] == here[:, 0]) & (there[:, 1] < here[:, 1]))
    swap &= pairs[:, 0] == pairs[:, 1]
    return np.where(swap[:, None], there, here)


def _reduced_steps(first: IntArray, second: IntArray) -> tuple[IntArray, IntArray]:
    """Steps that span the same images, (g, h) and (0, k) with g and k not negative (Hermite's normal form)."""
    while second[:, 0].any():
        some = second[:, 0] != 0
        rest = first[some] - (first[some, :1] // second[some, :1]) * second[some]
        first[some], second[some] = second[some], rest
    along = first[:, 0] == 0
    second[along, 1] = np.gcd(first[along, 1], second[along, 1])
    first[along] = 0
    return np.where(first[:, :1] < 0, -first, first), np.abs(second)


def _modulo(image: IntArray, first: IntArray, second: IntArray) -> IntArray:
    """Image less as many steps (g, h) and (0, k) as leave it the least that is not negative."""
    x, y = image[:, 0], image[:, 1]
    turns: IntArray = np.where(first[:, 0] > 0, x // np.maximum(first[:, 0], 1), 0)
    x, y = x - turns * first[:, 0], y - turns * first[:, 1]
    return np.stack([x, np.where(second[:, 1] > 0, y % np.maximum(second[:, 1], 1), y)], axis=1)
