# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Courses as chains of course edges, and their division where the rows of a band branch.

Where two limbs meet, the course of the joined limb is divided among the courses of the limbs by their distance. A graft
completes the parts that a limb gets. It is a chain of course edges through the saddle, which the limbs on its two sides
share, as a knitter grafts an underarm. Where rows end at the sides of a slit, the course is only cut.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.tessellate.stitch_faces import RowBoundary


@dataclass(frozen=True)
class Chain:
    """Consecutive course edges from left to right."""

    vertices: tuple[int, ...]
    """Vertices along the chain; a closed chain ends with its first vertex."""
    edges: tuple[int, ...]
    """Numbers of its edges, one fewer than vertices."""

    @property
    def closed(self) -> bool:
        """Whether the chain is a ring."""
        return self.vertices[0] == self.vertices[-1]

    def turned(self, start: int) -> Chain:
        """Return the same ring from another of its vertices."""
        vertices = self.vertices[:-1]
        return Chain((*vertices[start:], *vertices[: start + 1]), (*self.edges[start:], *self.edges[:start]))

    def part(self, first: int, last: int) -> Chain:
        """Return the edges from one place to another, across the end of a ring where ``last`` is beyond it."""
        count = len(self.edges)
        places = [place % count for place in range(first, last)]
        vertices = (*(self.vertices[place] for place in places), self.vertices[(last - 1) % count + 1])
        return Chain(vertices, tuple(self.edges[place] for place in places))

    def reversed(self) -> Chain:
        """Return the chain in the other direction."""
        return Chain(self.vertices[::-1], self.edges[::-1])

    def row_boundary(self, ends: IntArray) -> RowBoundary:
        """Return the chain as the course line below or above a row whose wale edges end at some places of it."""
        return RowBoundary(self.vertices, self.edges, ends)

    def followed_by(self, other: Chain) -> Chain:
        """Return the chain and another one that starts at its end."""
        return Chain((*self.vertices, *other.vertices[1:]), (*self.edges, *other.edges))


Bridge = Callable[[int, int], Chain]
"""Function that returns the graft from one vertex to another; for the same two vertices always the same edges."""


@dataclass
class Grafts:
    """The grafts made so far, by their two vertices."""

    make: Bridge
    made: dict[tuple[int, int], Chain] = field(default_factory=dict)

    def between(self, first: int, last: int) -> Chain:
        """Return the graft from one vertex to another."""
        if (last, first) in self.made:
            return self.made[last, first].reversed()
        if (first, last) not in self.made:
            self.made[first, last] = self.make(first, last)
        return self.made[first, last]


def divide(chain: Chain, owner: IntArray, closed: Sequence[bool], grafts: Grafts) -> list[Chain | None]:
    """Divide a course among several courses.

    Args:
        chain: the course.
        owner: number of the course that gets each edge, shape (edges,).
        closed: whether each of the other courses is a ring.
        grafts: the grafts.

    Returns:
        For each of the other courses its chain; None if it gets no edge.
    """
    runs = _runs(owner, chain.closed)
    return [_chain_of(chain, runs, number, is_ring, grafts) for number, is_ring in enumerate(closed)]


@dataclass(frozen=True)
class _Run:
    """Consecutive edges with one owner."""

    owner: int
    first: int
    last: int


def _runs(owner: IntArray, closed: bool) -> list[_Run]:
    """Return the runs of edges with one owner; the last run of a ring may go on beyond its end."""
    count = len(owner)
    cuts = np.flatnonzero(np.diff(owner)) + 1
    if closed and owner[0] != owner[-1]:
        cuts = np.concatenate([[0], cuts])
    if not len(cuts):
        return [_Run(int(owner[0]), 0, count)]
    if closed:
        ends = np.append(cuts[1:], cuts[0] + count)
        return [_Run(int(owner[a % count]), int(a), int(b)) for a, b in zip(cuts, ends, strict=True)]
    starts = np.concatenate([[0], cuts])
    return [_Run(int(owner[a]), int(a), int(b)) for a, b in zip(starts, np.append(cuts, count), strict=True)]


def _chain_of(chain: Chain, runs: list[_Run], number: int, is_ring: bool, grafts: Grafts) -> Chain | None:
    """Join the runs of one owner by grafts, and for a ring the last run to the first."""
    own = [run for run in runs if run.owner == number]
    if not own:
        return None
    whole = chain.part(own[0].first, own[0].last)
    if len(runs) == 1:
        return whole
    for run in own[1:]:
        part = chain.part(run.first, run.last)
        whole = whole.followed_by(grafts.between(whole.vertices[-1], part.vertices[0])).followed_by(part)
    if is_ring and not whole.closed:
        whole = whole.followed_by(grafts.between(whole.vertices[-1], whole.vertices[0]))
    return whole


def owners(points: FloatArray, lines: Sequence[FloatArray], closed: bool) -> IntArray:
    """Return the number of the line nearest to each point of a course, with as few runs of points as possible.

    Args:
        points: middles of the edges of the course [cm], shape (n, 3).
        lines: points of each line [cm], shape (m, 3).
        closed: whether the course is a ring.
    """
    from scipy.spatial import cKDTree

    distance = np.stack([cKDTree(line).query(points)[0] for line in lines])
    owner: IntArray = distance.argmin(axis=0)
    most = max(2 * (len(lines) - 1), 1) if closed else 2 * len(lines) - 1
    while len(runs := _runs(owner, closed)) > most:
        owner = _without_shortest_run(owner, runs, closed)
    return owner


def _without_shortest_run(owner: IntArray, runs: list[_Run], closed: bool) -> IntArray:
    """Find the shortest run whose owner has a longer run too, and give it to the neighbour of the run."""
    counts = np.bincount([run.owner for run in runs])
    order = sorted(range(len(runs)), key=lambda k: (counts[runs[k].owner] == 1, runs[k].last - runs[k].first))
    shortest = order[0]
    neighbour = runs[shortest - 1] if closed or shortest > 0 else runs[1]
    changed = owner.copy()
    changed[np.arange(runs[shortest].first, runs[shortest].last) % len(owner)] = neighbour.owner
    return changed
