# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Loops of yarns and the links between them, identified by the stitches that made them.

The yarn is cut wherever the yarn of a row crosses a top side. The top sides of a row form the line of the needle on
which the loops hang. Above the cuts are the *loops*: a loop runs from the two places where it crosses the top side of
its stitch up to where it is held, also through slipped stitches and cables. Below the cuts are the *links*: a link runs
from one loop down its leg, along the row, and up into the next loop. At the ends of a row, and beside yarn that is
drawn through loops, a link has one loop or none. Yarn that is drawn through the last loops is cut into one link for
each face.

Loops and links are index ranges of sampled points, so they do not change when the yarns are relaxed.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from stitchmesh.linking.yarn_polylines import SAMPLES_PER_POINT
from stitchmesh.mesh import BOTTOM, StitchMesh
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.yarn import YarnSet
from stitchmesh.yarngen.bridges import SLOTS
from stitchmesh.yarngen.finish import DEFAULT_FINISH, YarnFinish
from stitchmesh.yarngen.loop_check.pieces import YarnPieces, points_before, yarn_pieces

DRAWN_THROUGH = (Stitch.BIND_OFF, Stitch.DRAW_THROUGH)
"""Stitches whose yarn is drawn through loops and makes no loops."""


@dataclass(frozen=True, eq=False)
class Arc:
    """A stretch of yarn between two cuts, or a closed yarn without cuts."""

    yarn: int
    """Number of the yarn."""
    first: int
    """Sampled point at its first cut."""
    count: int
    """Number of its sampled points, including both cuts."""
    last: int
    """Sampled point at its last cut."""
    pieces: tuple[int, ...]
    """The pieces of yarn in the arc (``YarnPieces``)."""
    ends: tuple[int, int]
    """Crossings of face sides at its two cuts."""
    on_needle: tuple[bool, bool]
    """Whether the cut at each end lies on a course side. For a link, a loop continues there."""


@dataclass(frozen=True, eq=False)
class Arcs:
    """All loops and links of a fabric's yarns."""

    pieces: YarnPieces
    """The pieces of all yarns."""
    loops: list[Arc]
    """The arcs above the cuts."""
    links: list[Arc]
    """The arcs below the cuts."""

    @property
    def whole(self) -> StitchMesh:
        """The stitch mesh with its bind-off row."""
        return self.pieces.routes.whole

    @cached_property
    def reversed_sides(self) -> frozenset[int]:
        """Bottom sides that loops cross with exchanged legs, because the loops are slipped and twisted below."""
        found: set[int] = set()
        role = self.whole.side_role
        for loop in self.loops:
            crossings = self.pieces.ends[list(loop.pieces)].ravel()
            seen: set[int] = set()
            for crossing in crossings[role[crossings // SLOTS] == 0].tolist():
                if crossing // SLOTS not in seen and crossing % SLOTS != crossings[0] % SLOTS:
                    found.add(crossing // SLOTS)
                seen.add(crossing // SLOTS)
        return frozenset(found)

    @cached_property
    def slipping_pieces(self) -> frozenset[int]:
        """Pieces in faces that slip a loop."""
        codes = [stitch for stitch, definition in self.whole.makings.items() if "s" in definition.made]
        return frozenset(np.flatnonzero(np.isin(self.whole.stitch[self.pieces.face], codes)).tolist())

    @cached_property
    def chain_sides(self) -> dict[int, int]:
        """The wale side that the bound-off loop before crosses, for each face of a chain bind-off; -1 for first faces.

        Bound-off loops cross wale sides beside the yarn of the row.
        """
        crossings = self.pieces.ends
        is_leg = self.whole.is_wale[crossings // SLOTS] & (crossings % SLOTS > 0)
        found = dict.fromkeys(self.pieces.face[is_leg.any(axis=1)].tolist(), -1)
        over = is_leg.all(axis=1)
        return found | dict(zip(self.pieces.face[over].tolist(), (crossings[over, 0] // SLOTS).tolist(), strict=True))

    def chain_threadings(self, link: Arc) -> int | None:
        """How often a link threads the loop below it in a chain bind-off; None for a link that is in no chain."""
        face = int(self.pieces.face[link.pieces[0]])
        if face not in self.chain_sides:
            return None
        begins, ends = (crossing % SLOTS == 0 for crossing in link.ends)
        if begins and ends:
            return 1 if link.ends[0] // SLOTS == self.chain_sides[face] else -1
        return int(begins) - int(ends)

    @cached_property
    def loop_of_cut(self) -> dict[int, int]:
        """The number of the loop that starts or ends at each cut, by the sampled point of the cut."""
        return {point: number for number, loop in enumerate(self.loops) for point in (loop.first, loop.last)}

    @cached_property
    def loop_of_side(self) -> dict[int, int]:
        """The number of the loop at each course side.

        For a bottom side it is the loop that crosses the side; for a top side the loop that was made there or continues
        there.
        """
        found = {
            crossing // SLOTS: number
            for number, loop in enumerate(self.loops)
            for crossing in self.pieces.ends[list(loop.pieces)].ravel().tolist()
        }
        for link in self.links:
            for crossing, point in zip(link.ends, (link.first, link.last), strict=True):
                if point in self.loop_of_cut:
                    found[crossing // SLOTS] = self.loop_of_cut[point]
        return found


def cut_after(control_point: int) -> int:
    """The sampled point at which a yarn is cut after a control point, half way to the next one."""
    return control_point * SAMPLES_PER_POINT + SAMPLES_PER_POINT // 2


def find_arcs(fabric: StitchMesh, yarns: YarnSet, finish: YarnFinish = DEFAULT_FINISH) -> Arcs:
    """Cut yarns into loops and links.

    Args:
        fabric: the stitch mesh.
        yarns: the yarns generated from it, relaxed or not.
        finish: the finish with which the yarns were generated.

    Raises:
        YarnError: the yarns were not generated from this stitch mesh with this finish.
    """
    pieces = yarn_pieces(fabric, yarns, finish)
    cutter = _Cutter(pieces, yarns)
    starts = np.searchsorted(pieces.yarn, np.arange(yarns.yarn_count + 1)).tolist()
    found = [arc for yarn in range(yarns.yarn_count) for arc in cutter.arcs_of(yarn, *starts[yarn : yarn + 2])]
    loops = [arc for arc in found if cutter.is_loop[arc.pieces[0]]]
    links = [arc for arc in found if not cutter.is_loop[arc.pieces[0]]]
    return Arcs(pieces, loops, links)


class _Cutter:
    """Cuts yarns, given as sequences of pieces."""

    def __init__(self, pieces: YarnPieces, yarns: YarnSet) -> None:
        whole = pieces.routes.whole
        role = whole.side_role[pieces.ends // SLOTS]
        self.ends, self.last_point = pieces.ends.tolist(), (pieces.points[:, 1] - 1).tolist()
        self.before = points_before(pieces, yarns)
        self.is_loop = (role == BOTTOM).any(axis=1).tolist()
        self.leaves_course = (role[:, 1] % 2 == 0).tolist()
        self.is_drawn_through = np.isin(whole.stitch[pieces.face], DRAWN_THROUGH).tolist()
        self.row = whole.row[pieces.face].tolist()
        self.role = dict(zip(pieces.ends.ravel().tolist(), role.ravel().tolist(), strict=True))
        self.paths = pieces.routes.bridges.paths
        self.start, self.closed = yarns.start.tolist(), yarns.closed.tolist()

    def arcs_of(self, yarn: int, first: int, last: int) -> list[Arc]:
        """The arcs of one yarn, whose pieces have the numbers from ``first`` up to but not including ``last``."""
        order = list(range(first, last))
        cut = [self._is_cut(i, j) for i, j in zip(order, [*order[1:], first], strict=True)]
        if not self.closed[yarn]:
            cut[-1] = True
        elif not any(cut):
            return [self._ring(yarn, order)]
        turn = 0 if cut[-1] else cut.index(True) + 1
        order, cut = order[turn:] + order[:turn], cut[turn:] + cut[:turn]
        ends = [place + 1 for place, is_cut in enumerate(cut) if is_cut]
        return [self._arc(yarn, order, a, b) for a, b in pairwise([0, *ends])]

    def _is_cut(self, i: int, j: int) -> bool:
        """Whether the yarn is cut between piece i and the next piece j.

        Between two wale sides it is cut where it turns back, even if a short row has the same row number. Otherwise a
        link from a loop around the turn into the stitch above would thread the loop at which it begins.
        """
        if self.leaves_course[i]:
            return not (self.is_loop[i] and self.is_loop[j])
        if self.is_drawn_through[i] or self.is_drawn_through[j]:
            return True
        leaving, entered = self.ends[i][1], self.ends[j][0]
        return leaving in self.paths and (self.row[i] != self.row[j] or self.role[leaving] == self.role[entered])

    def _arc(self, yarn: int, order: list[int], begin: int, end: int) -> Arc:
        """The arc of the pieces from ``begin`` up to but not including ``end``.

        Points of a bridge beside a loop belong to the loop.
        """
        own, before, after = order[begin:end], order[begin - 1], order[end % len(order)]
        is_loop = self.is_loop[own[0]]
        first = self.last_point[before] if is_loop else self.before[own[0]]
        last = self.before[after] if is_loop else self.last_point[own[-1]]
        size = self.start[yarn + 1] - self.start[yarn]
        return Arc(
            yarn=yarn,
            first=cut_after(first),
            count=(last - first) % size * SAMPLES_PER_POINT + 1,
            last=cut_after(last),
            pieces=tuple(own),
            ends=(self.ends[own[0]][0], self.ends[own[-1]][1]),
            on_needle=(
                self._is_on_needle(yarn, before, begin == 0),
                self._is_on_needle(yarn, own[-1], end == len(order)),
            ),
        )

    def _ring(self, yarn: int, order: list[int]) -> Arc:
        """The arc of a closed yarn without cuts."""
        start = self.start[yarn] * SAMPLES_PER_POINT
        size = self.start[yarn + 1] * SAMPLES_PER_POINT - start
        ends = self.ends[order[0]][0], self.ends[order[-1]][1]
        return Arc(yarn, start, size, start + size - 1, tuple(order), ends, (False, False))

    def _is_on_needle(self, yarn: int, before: int, is_outer: bool) -> bool:
        """Whether the yarn is cut on a course side after a piece."""
        return self.leaves_course[before] and (self.closed[yarn] or not is_outer)
