# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Closure of loops and links (``loops``): closed test curves for ``loop_linking``.

- A loop is closed by the straight line between its two cuts.
- A link is closed by the straight line between its two cuts, which is the needle that holds its row. Where other loops
  lie between the two cuts, slipped loops or loops of another yarn, the line passes in front of them.
- A link that ends beside its row is closed by a line that leaves the needle beyond its last loop.
- A link that is drawn through loops is extended by its neighbours on both sides and closed by a line beyond the edge of
  the fabric. If the yarn is a short ring, the whole yarn is the closed curve. In a chain bind-off the link is not
  extended.
- A downward leg of a slipped loop is closed by a line far behind the leg.

The front is the right side of the fabric, ``across x up``. ``across`` points from the left crossing of a top side to
its right crossing, and ``up`` points from one needle to the next.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.errors import YarnError
from stitchmesh.linking.yarn_polylines import SAMPLES_PER_POINT, sampled_points
from stitchmesh.mesh import BORDER, LEFT, RIGHT, FloatArray
from stitchmesh.mesh.arrays import unit_vectors
from stitchmesh.yarn import YarnSet
from stitchmesh.yarngen.bridges import SLOTS
from stitchmesh.yarngen.loop_check.loops import Arc, Arcs, cut_after
from stitchmesh.yarngen.loop_check.pieces import points_before
from stitchmesh.yarngen.loop_check.threadings import SlippedLegs, is_drawn_through, spanned_sides

IN_FRONT = 2.0
"""Distance in front of other loops at which a link is closed [radii]."""
BEHIND = 8.0
"""Distance behind a leg of a slipped loop at which the leg is closed [radii]; it is one stitch width."""
BEYOND = 3.0
"""Distance beyond a link that is drawn through loops at which the link is closed, over the height of a row."""
LINKS_BESIDE = 2
"""Number of links on either side by which a link that is drawn through loops is extended, because the yarn can slide
through the loops."""

Frame = tuple[int, int, int, int, int, int]
"""Sampled points: the left and the right crossing of a top side, two points below it and two points above it. The first
two define across, the other four define up."""


@dataclass(frozen=True)
class ClosurePoint:
    """A corner of a closure, at ``base + (base - inner) / 2 + lift front + rise up``."""

    base: int
    """Sampled point from which the corner is measured."""
    inner: int
    """Sampled point from which the corner is moved away; equal to ``base`` for no such displacement."""
    frame: Frame
    """The sampled points that define front and up."""
    lift: float = 0.0
    """Displacement to the front [radii]."""
    rise: float = 0.0
    """Displacement upwards, over the height of a row."""


@dataclass(frozen=True, eq=False)
class TestCurves:
    """Closed curves, as numbers of sampled points and of the closure points that follow them."""

    loops: list[list[int]]
    """One curve for each loop."""
    links: list[list[int]]
    """One curve for each link; it is empty for a link that threads no loop."""
    legs: list[list[int]]
    """One curve for each leg of a slipped loop."""
    corners: list[ClosurePoint]
    """The closure points."""

    def positions(self, yarns: YarnSet) -> FloatArray:
        """Positions of the sampled points and of the closure points [cm], shape (n, 3)."""
        points = sampled_points(yarns)
        columns = np.array([(corner.base, corner.inner) for corner in self.corners], dtype=np.int64).reshape(-1, 2)
        frames = np.array([corner.frame for corner in self.corners], dtype=np.int64).reshape(-1, 3, 2)
        base, inner = points[columns].swapaxes(0, 1)
        across = np.diff(points[frames[:, 0]], axis=1)[:, 0]
        up = np.diff(points[frames[:, 1:]].mean(axis=2), axis=1)[:, 0]
        lift = np.array([corner.lift for corner in self.corners]).reshape(-1, 1) * yarns.radius.mean()
        front = unit_vectors(np.cross(across, up))
        rise = np.array([corner.rise for corner in self.corners]).reshape(-1, 1)
        return np.concatenate([points, base + (base - inner) / 2 + lift * front + rise * up])


def close_arcs(arcs: Arcs, yarns: YarnSet, slipped: SlippedLegs) -> TestCurves:
    """Close all loops, all links and all legs of slipped loops.

    Args:
        arcs: loops and links of the yarns.
        yarns: the yarns.
        slipped: the legs of slipped loops.

    Raises:
        YarnError: the row of a face is worked on no loops, so that its front is undefined.
    """
    closer = _Closer(arcs, yarns)
    loops = [closer.points_of(loop)[:: -1 if loop.ends[0] % SLOTS == 0 else 1] for loop in arcs.loops]
    links = [closer.link(link) for link in arcs.links]
    legs = [closer.leg(piece) for piece in slipped.piece.tolist()]
    return TestCurves(loops, links, legs, closer.corners)


class _Closer:
    """Closes arcs one at a time and collects the closure points."""

    def __init__(self, arcs: Arcs, yarns: YarnSet) -> None:
        self.arcs, self.pieces, self.whole = arcs, arcs.pieces, arcs.whole
        self.start = yarns.start.tolist()
        self.role = self.whole.side_role.tolist()
        self.corners: list[ClosurePoint] = []
        self.point_count = len(yarns.points) * SAMPLES_PER_POINT
        self.before = points_before(self.pieces, yarns)
        self.crossing_point = self._crossing_points()
        # arcs by the sampled point of a cut, and -1 if they start there or 1 if they end there
        self.arc_at_cut = {(arc.first, -1): arc for arc in (*arcs.loops, *arcs.links)}
        self.arc_at_cut |= {(arc.last, 1): arc for arc in (*arcs.loops, *arcs.links)}

    def points_of(self, arc: Arc) -> list[int]:
        """Sampled points of an arc in the order of the yarn."""
        return self._points(arc.yarn, arc.first, arc.count)

    def link(self, link: Arc) -> list[int]:
        """The closed curve of a link; empty if the link threads no loop."""
        if is_drawn_through(self.arcs, link):
            return [] if self.arcs.chain_threadings(link) == 0 else self._drawn_through_curve(link)
        if not any(link.on_needle):
            return self.points_of(link) if self._is_ring(link) else []
        spanned = [self._side_crossings(side, rightwards) for side, rightwards in spanned_sides(self.arcs, link)]
        return [*self.points_of(link), *self._needle_line(link, spanned)]

    def _drawn_through_curve(self, link: Arc) -> list[int]:
        """The closed curve of a link that is drawn through loops.

        It is a stretch of the yarn of the link, or the whole yarn if the yarn is a short ring. In a chain it is the
        link alone.
        """
        row = [link]
        links_beside = LINKS_BESIDE if self.arcs.chain_threadings(link) is None else 0
        for direction in (-1, 1):
            for _ in range(links_beside):
                beside = self.arc_at_cut.get((row[0].first, 1) if direction < 0 else (row[-1].last, -1))
                if beside is None or not is_drawn_through(self.arcs, beside):
                    break
                row = [beside, *row] if direction < 0 else [*row, beside]
        if row[0].first == row[-1].last or len({arc.first for arc in row}) < len(row):
            return self._points(link.yarn, self.start[link.yarn] * SAMPLES_PER_POINT, self._size(link.yarn))
        back = [(arc.last, self._side_below(arc, -1)) for arc in row[::-1]]
        back.append((row[0].first, self._side_below(row[0], 0)))
        points = [point for arc in row for point in self.points_of(arc)]
        return [*points, *(self._corner(ClosurePoint(end, end, self._frame(side), rise=BEYOND)) for end, side in back)]

    def _side_below(self, link: Arc, place: int) -> int:
        """The top side of the first (0) or the last (-1) loop through which a link is drawn."""
        first, bottom = (int(n[self.pieces.face[link.pieces[0]]]) for n in (self.whole.face_start, self.whole.n_bottom))
        sides: list[int] = self.whole.twin[first : first + bottom].tolist()
        return sides[place] if self.role[link.ends[0] // SLOTS] == LEFT else sides[-1 - place]

    def leg(self, piece: int) -> list[int]:
        """The closed curve of a leg of a slipped loop, directed downwards."""
        first, after = self.pieces.points[piece].tolist()
        count = (after - first) * SAMPLES_PER_POINT + 1
        points = self._points(int(self.pieces.yarn[piece]), cut_after(self.before[piece]), count)
        start, end = (int(crossing) // SLOTS for crossing in self.pieces.ends[piece])
        top = end if self.role[start] == 0 else start
        downwards = points if top == start else points[::-1]
        frame = self._frame(top)
        behind = [self._corner(ClosurePoint(point, point, frame, -BEHIND)) for point in (downwards[-1], downwards[0])]
        return [*downwards, *behind]

    def _needle_line(self, link: Arc, spanned: list[tuple[int, int, int]]) -> list[int]:
        """Closure points from the end of a link back to its start.

        Args:
            link: the link.
            spanned: the sides that the link passes, each with its near and far crossing point, in the order of the
                link.
        """
        in_front = [
            self._corner(ClosurePoint(point, point, self._frame(side), IN_FRONT))
            for side, near, far in reversed(spanned)
            for point in (far, near)
        ]
        if all(link.on_needle):
            return in_front
        starts_on_needle = link.on_needle[0]
        if spanned:
            outermost = spanned[-1 if starts_on_needle else 0]
        else:
            on_needle, beside_row = (0, 1) if starts_on_needle else (1, 0)
            outermost = self._side_crossings(link.ends[on_needle] // SLOTS, self._leaves_right(link, beside_row))
        side, first, second = outermost
        near, far = (first, second) if starts_on_needle else (second, first)
        outer = self._corner(ClosurePoint(far, near, self._frame(side), IN_FRONT if spanned else 0.0))
        return [outer, *in_front] if starts_on_needle else [*in_front, outer]

    def _leaves_right(self, link: Arc, end: int) -> bool:
        """Whether a link runs to the right at the wale side through which it enters (0) or leaves (1)."""
        return self.role[link.ends[end] // SLOTS] == (LEFT, RIGHT)[end]

    def _side_crossings(self, side: int, rightwards: bool) -> tuple[int, int, int]:
        """A top side and its two crossing points, in the order in which they are passed."""
        left, right = self._crossings(side)
        return (side, left, right) if rightwards else (side, right, left)

    def _frame(self, side: int) -> Frame:
        """The frame at a top side. Up leads to the needle above, or from the needle below if there is none above."""
        own, above = self._crossings(side), int(self.whole.twin[side])
        over = self._some_crossings(self._top_sides(int(self.whole.side_face[above]))) if above != BORDER else None
        return (*own, *own, *over) if over is not None else (*own, *self._from_below(int(self.whole.side_face[side])))

    def _from_below(self, face: int) -> tuple[int, int, int, int]:
        """Crossing points on the needles below and above a face, or the nearest face of its row that has both."""
        for wales in (self.whole.left_wale, self.whole.right_wale):
            beside, seen = face, {BORDER}
            while beside not in seen:
                seen.add(beside)
                first, bottom = int(self.whole.face_start[beside]), int(self.whole.n_bottom[beside])
                under = self._some_crossings(self.whole.twin[first : first + bottom].tolist())
                over = self._some_crossings(self._top_sides(beside))
                if under is not None and over is not None:
                    return (*under, *over)
                across = int(self.whole.twin[wales[beside]])
                beside = BORDER if across == BORDER else int(self.whole.side_face[across])
        raise YarnError(
            f"face {face}: its row is worked on no loops, so that its front cannot be determined", face=face
        )

    def _some_crossings(self, sides: list[int]) -> tuple[int, int] | None:
        """The crossing points of the middle side among the sides that have crossings; None if there is none."""
        some = [side for side in sides if side * SLOTS in self.crossing_point]
        return self._crossings(some[len(some) // 2]) if some else None

    def _crossings(self, side: int) -> tuple[int, int]:
        """Sampled points at the left and at the right crossing of a top side."""
        return self.crossing_point[side * SLOTS + 1], self.crossing_point[side * SLOTS]

    def _top_sides(self, face: int) -> list[int]:
        return list(range(int(self.whole.right_wale[face]) + 1, int(self.whole.left_wale[face])))

    def _corner(self, corner: ClosurePoint) -> int:
        """Add a closure point and return its number."""
        self.corners.append(corner)
        return self.point_count + len(self.corners) - 1

    def _points(self, yarn: int, first: int, count: int) -> list[int]:
        """Sampled points from ``first`` on, which may pass the end of a closed yarn."""
        start, size = self.start[yarn] * SAMPLES_PER_POINT, self._size(yarn)
        if start <= first and first + count <= start + size:
            return list(range(first, first + count))
        return [start + (point - start) % size for point in range(first, first + count)]

    def _is_ring(self, link: Arc) -> bool:
        """Whether a link is a whole closed yarn."""
        return link.count == self._size(link.yarn)

    def _size(self, yarn: int) -> int:
        """Number of sampled points of a yarn."""
        return (self.start[yarn + 1] - self.start[yarn]) * SAMPLES_PER_POINT

    def _crossing_points(self) -> dict[int, int]:
        """The sampled point at each crossing of a top side."""
        found: dict[int, int] = {}
        for link in self.arcs.links:
            found.update(zip(link.ends, (link.first, link.last), strict=True))
        for loop in self.arcs.loops:
            for piece in loop.pieces:
                points = self.before[piece], int(self.pieces.points[piece, 1]) - 1
                for crossing, point in zip(self.pieces.ends[piece].tolist(), points, strict=True):
                    found.setdefault(crossing, cut_after(point))
        return found
