# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The triangles on which a budget of yarn nodes removes the most error.

A triangle with yarns needs the nodes in itself and in the hybrid rings around it, and neighbours share most of these
nodes. With a price for each node, the region with the largest error less its price is a closure of largest weight,
which a minimum cut finds exactly (Picard 1976). The price is lowered as far as the budget allows (``best_closure``).

The remaining nodes of the budget, which do not suffice for another closure, are used triangle by triangle: the next
triangle is the one with the most error for each node that it adds. Where growth of this kind alone removes more error,
its region is taken.

The order does not depend on the rounding of sums: equal triangles are taken by their numbers.

*Closures of largest weight* (Picard 1976). Each triangle t is a project with the profit e_t, its error. The project
needs tools: all triangles s that are simulated if t is full of yarns. A tool costs the price times its nodes n_s, once
for all projects that need it. In the network

    source -> t: e_t,    t -> s: unlimited,    s -> sink: price n_s

the projects on the side of the source of a minimum cut have the largest profit less costs. The number of nodes of this
region falls as the price rises, so a bisection finds the largest region of this kind within a budget.

``triangles_of_panels`` and ``triangles_of_faces`` choose triangles by hand.

All functions return numbers of triangles, ascending and without repeats, as a region takes them (``region_around``).
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order, maximum_flow

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import StitchMesh
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.cloth.from_stitches import triangle_start

Integers = NDArray[np.int64]
Numbers = NDArray[np.float64]
UNLIMITED = 2**31 - 1
WHOLE = 2**29
"""Sum of all errors in the network, whose capacities are whole numbers."""


def best_closure(reach: csr_array, nodes: Integers, error: Numbers, budget: int) -> Integers:
    """Return the triangles of the largest region within a budget that is the best region for some price, ascending.

    Args:
        reach: which triangles are simulated if a triangle is full of yarns, shape (T, T).
        nodes: nodes of each triangle, shape (T,).
        error: error of each triangle, shape (T,); zero where no yarns are wanted.
        budget: largest number of nodes.
    """
    total = float(error.sum())
    best = np.zeros(0, dtype=np.int64)
    if total <= 0.0 or budget <= 0:
        return best
    low, high = -12.0, 0.0  # powers of ten of the price of a node, over the error of all triangles
    for _ in range(24):
        price = 0.5 * (low + high)
        chosen = _closure(reach, nodes, error / total, 10.0**price)
        if _needed(reach, nodes, chosen) <= budget:
            best, high = chosen, price
        else:
            low = price
    return best


def _needed(reach: csr_array, nodes: Integers, chosen: Integers) -> int:
    """Number of nodes that a region simulates."""
    mask = np.zeros(len(nodes), dtype=np.int32)
    mask[chosen] = 1
    return int(nodes[np.asarray(reach.astype(bool).astype(np.int32) @ mask) > 0].sum())


def _closure(reach: csr_array, nodes: Integers, error: Numbers, price: float) -> Integers:
    """The triangles with the largest error less price; the errors add up to 1."""
    count = len(nodes)
    source, sink = 2 * count, 2 * count + 1
    profit = np.rint(WHOLE * error).astype(np.int64)
    cost = np.minimum(np.rint(WHOLE * price * nodes), UNLIMITED).astype(np.int64)
    wanted = np.flatnonzero(profit)
    rows, columns = csr_array(reach[wanted]).nonzero()
    start = np.concatenate([np.full(len(wanted), source), wanted[rows], count + np.arange(count)])
    end = np.concatenate([wanted, count + columns, np.full(count, sink)])
    most = np.concatenate([profit[wanted], np.full(len(rows), UNLIMITED), cost])
    shape = (2 * count + 2, 2 * count + 2)
    network = csr_array((most.astype(np.int32), (start, end)), shape=shape)
    left = csr_array(network - maximum_flow(network, source, sink).flow)
    left.data[left.data < 0] = 0
    left.eliminate_zeros()
    reached = breadth_first_order(left, source, return_predecessors=False)
    return np.sort(reached[reached < count]).astype(np.int64)


def triangles_of_panels(cloth: Cloth, *panels: str) -> Integers:
    """The triangles of panels by name.

    Raises:
        ParameterError: there is no such panel.
    """
    return np.flatnonzero(np.isin(cloth.panel, [_panel_number(cloth, panel) for panel in panels]))


def triangles_of_faces(fabric: StitchMesh, faces: ArrayLike) -> Integers:
    """The triangles of faces of a stitch mesh, in the cloth of ``cloth_from_stitches``.

    Args:
        fabric: the stitch mesh.
        faces: numbers of faces, as ``sm.select`` returns them for a selection such as ``hem 6``.

    Raises:
        ParameterError: a number does not belong to a face.
    """
    start = triangle_start(fabric)
    chosen = np.unique(np.asarray(faces, dtype=np.int64))
    if len(chosen) and (chosen[0] < 0 or chosen[-1] >= len(start) - 1):
        found = f"got face {chosen[0] if chosen[0] < 0 else chosen[-1]}"
        raise ParameterError(f"yarn placement: {found}; expected 0 to {len(start) - 2}")
    mask = np.zeros(len(start) - 1, dtype=bool)
    mask[chosen] = True
    return np.flatnonzero(np.repeat(mask, np.diff(start)))


def _panel_number(cloth: Cloth, panel: str) -> int:
    if panel not in cloth.panel_names:
        raise ParameterError(f"yarn placement: got panel {panel!r}; expected one of {', '.join(cloth.panel_names)}")
    return cloth.panel_names.index(panel)


@dataclass(frozen=True, kw_only=True)
class NodeBudget:
    """The largest number of yarn nodes that are simulated, including the nodes of the hybrid rings.

    Raises:
        ParameterError: the number is negative.
    """

    nodes: int
    """Number of nodes."""

    def __post_init__(self) -> None:
        if self.nodes < 0:
            raise ParameterError(f"node budget: got {self.nodes} nodes; expected at least 0")

    @staticmethod
    def of_seconds(seconds: float, *, base: float, per_node: float) -> NodeBudget:
        """The number of nodes that a time for each step pays for.

        Args:
            seconds: time of a step [s].
            base: measured time of a step with triangles alone [s].
            per_node: measured time that a node adds to a step [s].

        Raises:
            ParameterError: a time is negative or not finite, or a node costs no time.
        """
        times = {"seconds": seconds, "base": base, "per_node": per_node}
        for name, value in times.items():
            if not (np.isfinite(value) and value >= 0.0) or (name == "per_node" and value == 0.0):
                raise ParameterError(f"node budget: {name} is {value}; expected a time in seconds")
        return NodeBudget(nodes=max(0, int((seconds - base) / per_node)))


def choose_triangles(
    triangles: ArrayLike,
    node_triangle: ArrayLike,
    error: ArrayLike,
    budget: NodeBudget,
    *,
    rings: int = 1,
) -> Integers:
    """The full-yarn triangles of a region, ascending, shape (n,); none if no region pays or the budget holds none.

    Args:
        triangles: vertices of each triangle, shape (T, 3).
        node_triangle: triangle of each yarn node of the layout, shape (N,).
        error: indicated error of each triangle, at least 0, shape (T,).
        budget: nodes that may be simulated.
        rings: width of the hybrid region in rings of triangles, at least 1.

    Raises:
        ParameterError: errors are negative, not finite or of the wrong shape, or there are no rings.
    """
    corners, values = np.asarray(triangles, dtype=np.int64), np.asarray(error, dtype=np.float64)
    if values.shape != (len(corners),) or not (np.isfinite(values) & (values >= 0.0)).all():
        raise ParameterError(f"region: expected {len(corners)} errors, one a triangle, finite and at least 0")
    if rings < 1:
        raise ParameterError(f"region: got {rings} hybrid rings; expected at least 1")
    nodes = np.bincount(np.asarray(node_triangle, dtype=np.int64), minlength=len(corners))
    reach, least = reach_of(corners, rings), 1e-5 * float(values.max(initial=0.0))  # less is not worth a node
    wanted = np.where(values >= least, values, 0.0)
    regions = []
    for start in (best_closure(reach, nodes, wanted, budget.nodes), np.zeros(0, dtype=np.int64)):
        growth = _Growth(reach, nodes, values, budget.nodes)
        growth.begin(start)
        regions.append(growth.run(least))
    return max(regions, key=lambda chosen: float(values[chosen].sum()))


def reach_of(triangles: Integers, rings: int) -> csr_array:
    """Which triangles are simulated with yarns if one of them is full of yarns: itself and its rings, shape (T, T)."""
    count = len(triangles)
    rows = np.repeat(np.arange(count), 3)
    shape = (count, int(triangles.max(initial=-1)) + 1)
    touches = csr_array((np.ones(3 * count, dtype=np.int32), (rows, triangles.ravel())), shape=shape)
    beside = csr_array(touches @ touches.T)
    reached = beside
    for _ in range(rings - 1):
        reached = csr_array(reached @ beside)
        reached.data[:] = 1
    reached.sort_indices()
    return reached


def simulated_nodes(triangles: ArrayLike, node_triangle: ArrayLike, chosen: ArrayLike, *, rings: int = 1) -> int:
    """Number of yarn nodes that a region and its rings simulate, with the arguments of ``choose_triangles``."""
    corners = np.asarray(triangles, dtype=np.int64)
    mask = np.zeros(len(corners), dtype=bool)
    mask[np.asarray(chosen, dtype=np.int64)] = True
    simulated = np.asarray(reach_of(corners, rings) @ mask.astype(np.int32)) > 0
    nodes = np.bincount(np.asarray(node_triangle, dtype=np.int64), minlength=len(corners))
    return int(nodes[simulated].sum())


class _Growth:
    """A region that grows triangle by triangle."""

    def __init__(self, reach: csr_array, nodes: Integers, error: Numbers, budget: int) -> None:
        self.reach, self.nodes, self.error, self.left = reach, nodes, error, budget
        self.added = np.asarray(reach.astype(bool).astype(np.int64) @ nodes)
        self.simulated = np.zeros(len(nodes), dtype=bool)
        self.chosen = np.zeros(len(nodes), dtype=bool)

    def begin(self, chosen: Integers) -> None:
        """Take the given triangles, whose nodes are within the budget."""
        for t in chosen.tolist():
            self._add(t)

    def run(self, least: float) -> Integers:
        """Add triangles as long as a triangle with enough error fits."""
        wanted = (self.error > 0.0) & (self.error >= least)
        queue = [(self._rank(t), t) for t in np.flatnonzero(wanted).tolist()]
        heapq.heapify(queue)
        while queue:
            rank, t = heapq.heappop(queue)
            if self.chosen[t] or rank != self._rank(t) or self.added[t] > self.left:
                continue  # chosen, or in the queue again with fewer nodes, or too large until its neighbours are chosen
            for other in self._add(t):
                if wanted[other] and not self.chosen[other]:
                    heapq.heappush(queue, (self._rank(other), other))
        return np.flatnonzero(self.chosen)

    def _rank(self, t: int) -> float:
        """Minus the error for each node; a triangle that adds no node comes first."""
        return -float(self.error[t]) / float(max(self.added[t], 1e-9))

    def _add(self, t: int) -> list[int]:
        """Add a triangle; return the triangles that now add fewer nodes than before."""
        self.chosen[t] = True
        self.left -= int(self.added[t])
        new = self._reached(t)
        new = new[~self.simulated[new]]
        self.simulated[new] = True
        changed: set[int] = set()
        for s in new.tolist():
            if self.nodes[s]:
                around = self._reached(s)
                self.added[around] -= self.nodes[s]
                changed.update(around.tolist())
        return sorted(changed)

    def _reached(self, t: int) -> Integers:
        row: Integers = self.reach.indices[self.reach.indptr[t] : self.reach.indptr[t + 1]]
        return row
