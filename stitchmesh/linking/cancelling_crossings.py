# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Which crossings on a deformation path cancel each other.

Two crossings of opposite sign between the same two stretches of yarn can cancel: the first one makes a bight, and the
second one takes it back. The two stretches between the two crossings form a closed ring. If no other yarn passes
through this ring (``rings``), nothing holds the bight, and the yarns could have slid to the same positions without
crossing. One crossing alone cancels where a yarn crosses itself and its curl is such an empty ring: the curl opens, and
closes again on the other side (Reidemeister's first move).

All crossings are paired at once, so that the total length of all rings is smallest.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import min_weight_full_bipartite_matching

from stitchmesh.linking.crossings_along_path import SampledPath, YarnCrossing
from stitchmesh.linking.rings import FORBIDDEN, FREE, LONGEST_RING, Rings
from stitchmesh.linking.yarn_polylines import YarnPolylines
from stitchmesh.mesh import FloatArray, IntArray


def uncancelled(path: SampledPath) -> list[YarnCrossing]:
    """The crossings of a path that no other crossings cancel, in the order of time."""
    crossings = path.crossings
    if not crossings:
        return []
    rings = Rings(path)
    right, left = ([k for k, crossing in enumerate(crossings) if crossing.sign == sign] for sign in (1, -1))
    curl_costs = [rings.curl_cost(crossing) for crossing in crossings]
    pairs = {
        (row, column): rings.pair_cost(crossings[right[row]], crossings[left[column]])
        for row, column in near_crossings(
            path.polylines, [crossings[k] for k in right], [crossings[k] for k in left], LONGEST_RING * path.radius
        )
    }
    pairs = {which: cost for which, cost in pairs.items() if cost < FORBIDDEN}
    remaining = _unmatched(pairs, [curl_costs[k] for k in right], [curl_costs[k] for k in left])
    return [crossings[k] for k in sorted([right[k] for k in remaining[0]] + [left[k] for k in remaining[1]])]


def near_crossings(
    polylines: YarnPolylines, one: list[YarnCrossing], two: list[YarnCrossing], reach: float
) -> list[tuple[int, int]]:
    """Pairs of crossings that are near each other along their yarns.

    Args:
        polylines: the polylines of the yarns.
        one: the first crossings.
        two: the second crossings.
        reach: largest sum of the distances along both yarns [cm].

    Returns:
        Pairs of an index into ``one`` and an index into ``two``.
    """
    others = np.array([(crossing.first, crossing.second) for crossing in two], dtype=np.int64).reshape(-1, 2)
    pairs = []
    for number, crossing in enumerate(one):
        same = _distances_along_yarn(polylines, crossing.first, others[:, 0]) + _distances_along_yarn(
            polylines, crossing.second, others[:, 1]
        )
        crosswise = _distances_along_yarn(polylines, crossing.first, others[:, 1]) + _distances_along_yarn(
            polylines, crossing.second, others[:, 0]
        )
        pairs += [(number, int(k)) for k in np.flatnonzero(np.minimum(same, crosswise) < reach)]
    return pairs


def _distances_along_yarn(polylines: YarnPolylines, point: int, others: IntArray) -> FloatArray:
    """Length of yarn from a point to other points, the shorter way around a closed yarn [cm], shape (n,).

    It is infinite for points of other yarns.
    """
    distances = np.abs(polylines.arc_length[others] - polylines.arc_length[point])
    yarn = int(polylines.yarn[point])
    if polylines.yarns.closed[yarn]:
        begin, end = polylines.arc_length[polylines.start[yarn : yarn + 2]]
        distances = np.minimum(distances, end - begin - distances)
    return np.where(polylines.yarn[others] == yarn, distances, np.inf)


def _unmatched(
    pairs: dict[tuple[int, int], float], right: list[float], left: list[float]
) -> tuple[list[int], list[int]]:
    """Crossings that remain in the assignment of least cost.

    Each crossing is assigned to a crossing of the other sign or to itself. It remains if it is assigned to itself at
    the cost ``FORBIDDEN``.

    Args:
        pairs: cost of each pair of a right and a left crossing.
        right: cost of each right crossing alone.
        left: cost of each left crossing alone.

    Returns:
        The numbers of the remaining right crossings and of the remaining left crossings.
    """
    p, m = len(right), len(left)
    entries = [(row, column, cost) for (row, column), cost in pairs.items()]
    entries += [(p + column, m + row, FREE) for row, column in pairs]
    entries += [(row, m + row, cost) for row, cost in enumerate(right)]
    entries += [(p + column, column, cost) for column, cost in enumerate(left)]
    rows, columns, costs = np.array(entries).T
    # Largest random number that is added to a cost [radii]. Among equally long rings it selects the same one in
    # every run.
    costs += np.random.default_rng(0).uniform(0.0, 1e-6, len(costs))
    graph = coo_array((costs, (rows.astype(np.int32), columns.astype(np.int32))), shape=(p + m, m + p)).tocsr()
    row, column = min_weight_full_bipartite_matching(graph)
    remaining_right = [int(k) for k, n in zip(row, column, strict=True) if k < p and n >= m and right[k] >= FORBIDDEN]
    remaining_left = [int(n) for k, n in zip(row, column, strict=True) if k >= p and n < m and left[n] >= FORBIDDEN]
    return remaining_right, remaining_left
