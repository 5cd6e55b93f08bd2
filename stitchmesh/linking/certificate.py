# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The linking certificate: which yarns are linked, as exact integers.

The linking number of two closed curves is half the sum of the signs of their crossings in a projection,

    2 lk(A, B) = sum of sign(c) over crossings c of A and B.

It cannot change unless one curve passes through the other. Polylines with integer coordinates replace the yarns
(``projection``); their crossings and signs are decided without rounding (``crossings``). The numbers are therefore
exact for these polylines, which differ from the curves by a few hundredths of a radius. A changed number proves that a
yarn passed through another, unless the yarns are closer than that. Yarns that are nearly pressed together are therefore
compared once more, with far shorter edges, before a change is believed. Unchanged numbers do not prove that no yarn
passed through another, because two passes in opposite senses cancel.

Open yarns are closed artificially, far away from all yarns (``open_yarns``). An artificial closure is not a yarn, and
other yarns may move through it. The linking number of an open yarn therefore only describes how the yarn lies. The
linking number of two closed yarns is a certificate, which no motion without pull-through can change.

On a lattice a yarn represents all its copies, which are displaced by a periods u + b periods v. A yarn whose lattice
step is zero is a ring in each copy. A yarn with another step is an endless line, which its own step maps onto itself.
For two yarns and each image (a, b) of the second relative to the first, the signs are summed over one period that both
copies share, in a projection along the normal of the fabric or nearly along it. Images that the steps of either yarn
map onto each other count as one. This sum is a certificate too: a motion changes the projection, a diagram on a torus,
by Reidemeister's moves. The second and the third move keep the sum, and the first concerns a yarn and itself. The sum
does not depend on the direction of the projection either, because another direction is a shear of space along the
fabric. Rings, and lines in the same direction, cross an even number of times: half the sum is their linking number. Two
lines in different directions have an odd sum, 1 or -1 where one lies over the other. Two copies of one yarn count as
two yarns. If half the step of the yarn exchanges them, a crossing and its image count once. Open yarns on a lattice are
not closed, and their sums describe how they lie.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csr_array

from stitchmesh.compute.device import alone, device_named
from stitchmesh.compute.shared_work import shared
from stitchmesh.errors import SolverError, check_kind
from stitchmesh.linking.crossings import decoded, edge_crossings
from stitchmesh.linking.open_yarns import open_yarn_crossings
from stitchmesh.linking.pairs_of_images import representative_images
from stitchmesh.linking.projection import FINE, SAMPLES, project_yarns
from stitchmesh.mesh import IntArray
from stitchmesh.yarn import YarnSet


@dataclass(frozen=True, eq=False)
class DoubledLinking:
    """Sums of crossing signs, sorted: one row for two yarns and an image if their sum is not zero."""

    yarn_count: int
    """Number of yarns, Y."""
    yarns: IntArray
    """Two yarns in ascending order, the same one twice for two of its copies, shape (n, 2)."""
    image: IntArray
    """Lattice image of the second yarn relative to the first, (0, 0) without a lattice, shape (n, 2)."""
    doubled: IntArray
    """Sum of the signs of their crossings, twice the linking number of closed yarns, shape (n,)."""


def linking_certificate(yarns: YarnSet, *, device: str | None = None) -> csr_array:
    """Return the linking numbers of all pairs of yarns, a symmetric integer matrix of shape (Y, Y).

    Without a lattice the diagonal is zero. On a lattice an entry is the sum of the signs of crossings over all images.
    It is twice the linking number if two yarns cross an even number of times. The diagonal contains the crossings
    between different copies of a yarn; ``doubled_linking`` has a row for each image.

    Args:
        yarns: closed or open yarns.
        device: "cpu", "cuda:0" ...; None for the first GPU, or the CPU if there is no GPU. Devices agree, except for
            yarns whose distance is below a unit, some millionths of an edge.

    Raises:
        ParameterError: the device is unknown, or the yarns extend over too many periods of a lattice.
    """
    check_kind("linking_certificate", yarns, YarnSet)
    linking = doubled_linking(yarns, device=device)
    first, second = linking.yarns.T
    entries = linking.doubled if yarns.lattice is not None else linking.doubled // 2
    half = coo_array((entries, (first, second)), shape=(linking.yarn_count,) * 2).tocsr()
    across = first != second
    return half + coo_array((entries[across], (second[across], first[across])), shape=half.shape).tocsr()


@alone()
def doubled_linking(yarns: YarnSet, *, device: str | None = None) -> DoubledLinking:
    """Return the sums of crossing signs of all pairs of yarns and images.

    Args:
        yarns: closed or open yarns.
        device: "cpu", "cuda:0" ... (``linking_certificate``).

    Raises:
        ParameterError: the device is unknown, or the yarns extend over too many periods of a lattice.
    """
    return linkings_together([yarns], device=device)[0]


@alone()
def linkings_together(sets: Sequence[YarnSet], *, device: str | None = None) -> list[DoubledLinking]:
    """Return the sums of crossing signs (``doubled_linking``) of many sets of yarns, in the same launches.

    Args:
        sets: sets of yarns on lattices, or one set.
        device: "cpu", "cuda:0" ... (``linking_certificate``).

    Raises:
        ParameterError: the device is unknown, or the yarns extend over too many periods of a lattice.
    """
    return _linkings(sets, device, SAMPLES)


def _linkings(sets: Sequence[YarnSet], device: str | None, edges: int) -> list[DoubledLinking]:
    """Return the sums of ``linkings_together``, for polylines with ``edges`` edges in a segment."""
    projection = project_yarns(sets, device_named(device), edges)
    codes = edge_crossings(projection)
    if sets[0].lattice is None and not sets[0].closed.all():
        codes = np.concatenate([codes, open_yarn_crossings(projection, sets[0].closed)])
    codes, counts = np.unique(codes, return_counts=True)
    pairs, images, signs = decoded(projection, codes)
    images = representative_images(images, pairs, projection.step.numpy())
    rows, doubled = _summed(np.concatenate([pairs, images], axis=1), counts * signs)
    linkings, first = list[DoubledLinking](), 0
    for own in sets:
        part = slice(*np.searchsorted(rows[:, 0], [first, first + own.yarn_count]).tolist())
        linkings.append(DoubledLinking(own.yarn_count, rows[part, :2] - first, rows[part, 2:], doubled[part]))
        first += own.yarn_count
    return linkings


def changed_pairs(before: DoubledLinking | csr_array, after: DoubledLinking | csr_array) -> IntArray:
    """Return the pairs of yarns whose linking differs in some image, shape (n, 2), each once, in ascending order.

    Args:
        before: linking of the yarns, or their ``linking_certificate``, which sums over images.
        after: the linking, or the certificate, of the same yarns later.
    """
    (old_rows, old_sums), (new_rows, new_sums) = _rows(before), _rows(after)
    rows, _ = _summed(np.concatenate([old_rows, new_rows]), np.concatenate([old_sums, -new_sums]))
    return np.unique(rows[:, :2], axis=0)


@shared
@alone()
def refuse_pull_through(drawn: YarnSet, relaxed: YarnSet, device: str | None = None) -> None:
    """Check that yarns are linked as they were drawn.

    Raises:
        SolverError: the linking of two closed yarns changed; the message names them.
    """
    refuse_changed_linking(drawn, relaxed, doubled_linking(drawn, device=device), device)


@alone()
def pull_throughs_together(
    pairs: Sequence[tuple[YarnSet, YarnSet]], device: str | None = None
) -> list[SolverError | None]:
    """Return the error of ``refuse_pull_through`` for each pair of drawn and relaxed yarns on lattices, or None."""
    every = list({id(yarns): yarns for pair in pairs for yarns in pair}.values())
    linking = dict(zip(map(id, every), linkings_together(every, device=device), strict=True))
    errors = list[SolverError | None]()
    for drawn, relaxed in pairs:
        try:
            changed = changed_pairs(linking[id(drawn)], linking[id(relaxed)])
            _refuse(drawn, relaxed, changed, device)
            errors.append(None)
        except SolverError as error:
            errors.append(error)
    return errors


@alone()
def refuse_changed_linking(
    drawn: YarnSet, relaxed: YarnSet, before: DoubledLinking, device: str | None = None
) -> None:  # fmt: skip
    """Do the check of ``refuse_pull_through``; ``before`` is the linking of the drawn yarns."""
    _refuse(drawn, relaxed, changed_pairs(before, doubled_linking(relaxed, device=device)), device)


def _refuse(drawn: YarnSet, relaxed: YarnSet, changed: IntArray, device: str | None) -> None:
    """Refuse pairs of closed yarns with changed linking; the linking of open yarns may change at their ends.

    Args:
        drawn: the yarns before.
        relaxed: the same yarns later.
        changed: the pairs whose linking seems to have changed (``changed_pairs``), shape (n, 2).
        device: "cpu", "cuda:0" ... (``linking_certificate``).

    Raises:
        SolverError: the linking of two closed yarns changed; the message names them and their stitch faces.
    """
    if not drawn.closed[changed].all(axis=1).any():
        return
    fine = [_linkings([yarns], device, FINE)[0] for yarns in (drawn, relaxed)]
    for first, second in changed_pairs(*fine):
        if drawn.closed[first] and drawn.closed[second]:
            faces = [sorted(set(drawn.face[drawn.start[y] : drawn.start[y + 1]].tolist()))[:3] for y in (first, second)]
            where = f"yarns {first} and {second} (stitch faces {faces[0]} ... and {faces[1]} ...)"
            raise SolverError(f"{where}: their linking number changed; report this with the yarns, it must not happen")


def _rows(linking: DoubledLinking | csr_array) -> tuple[IntArray, IntArray]:
    """Return two yarns and an image in each row, and the sum of signs or the entry of each row."""
    if isinstance(linking, DoubledLinking):
        return np.concatenate([linking.yarns, linking.image], axis=1), linking.doubled
    entries = linking.tocoo()
    upper = entries.row <= entries.col
    pairs = np.stack([entries.row, entries.col], axis=1)[upper].astype(np.int64)
    return np.concatenate([pairs, 0 * pairs], axis=1), entries.data[upper]


def _summed(rows: IntArray, values: IntArray) -> tuple[IntArray, IntArray]:
    """Return the unique rows, sorted, with the sums of their values; rows whose sum is zero are left out."""
    if len(rows) == 0:
        return rows, values
    order = np.lexsort(rows.T[::-1])
    rows, values = rows[order], values[order]
    first = np.flatnonzero(np.append(True, (np.diff(rows, axis=0) != 0).any(axis=1)))
    total: IntArray = np.add.reduceat(values, first)
    return rows[first][total != 0], total[total != 0]
