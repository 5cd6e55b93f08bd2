# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The time at which each place of a surface is knitted, counted in courses.

The first time comes from a steady flow: rain falls evenly on the surface and runs off at the roots,

    -laplace(u) = 1,    u = 0 at the roots,

so that every closed limb has one summit at its tip, every other end of rows is one level, and saddles appear only where
limbs meet. Then the slope of the time is made even. With X the unit vector along the gradient, the time minimises

    integral of w |grad(t) - X|^2,

and X is renewed from t; w is larger where the slope is above 1, because a row may be too high, and short rows fill it,
but never too low. The ends of rows then move to whole numbers of courses.

Sources: the alternation of a unit field and a Poisson equation follows Crane, Weischedel and Wardetzky, *Geodesics in
heat* (2013). A time whose level lines are rows: Narayanan, Albaugh, Hodgins, Coros and McCann, *Automatic machine
knitting of 3D meshes* (2018).

Small summits and hollows of the time are smoothed out. The height of a summit above its highest saddle (its
persistence) tells a limb from a bump; a bump beside an end of rows is measured from its saddle to that end, even if the
end is lower. The part of a small summit above its saddle, with some surface around it, gets the harmonic function that
has the given values at its rim. By the maximum principle it has no summit, whatever the triangles, because the weights
of the edges are positive.

Source: Edelsbrunner, Letscher and Zomorodian, *Topological persistence and simplification* (2002).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mesh.connectivity import linked_groups
from stitchmesh.shaping.ends import Ends
from stitchmesh.shaping.triangle_surface import TriangleSurface

if TYPE_CHECKING:
    from scipy.sparse import csr_array
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from stitchmesh.errors import MeshError
from stitchmesh.shaping.ends import End

if TYPE_CHECKING:
    from scipy.sparse import csr_array

SMALLEST_WEIGHT = 0.05
"""Smallest weight of an edge, over the weight between equilateral triangles."""
ROUNDS = 8
"""How often the direction of the gradient is renewed."""
STEEP_WEIGHT = 8.0
"""Weight of places where rows would be lower than a course, over the weight of places where they are higher."""
LOWEST_SUMMIT = 3.0
"""Height of a summit above its saddle, in courses, below which it is smoothed out."""


def neighbours(surface: TriangleSurface) -> tuple[IntArray, IntArray]:
    """Return the vertices next to each vertex as rows of a compressed array: starts, shape (V + 1,), and vertices."""
    ends = np.concatenate([surface.edges, surface.edges[:, ::-1]])
    order = np.lexsort((ends[:, 1], ends[:, 0]))
    start = np.concatenate([[0], np.cumsum(np.bincount(ends[:, 0], minlength=len(surface.vertices)))])
    return start, ends[order, 1]


def summits(
    surface: TriangleSurface, values: FloatArray, kept: NDArray[np.bool_] | None = None
) -> list[tuple[int, float, float]]:
    """Return the vertex of each summit, its height above the saddle where it joins a higher summit, and that saddle.

    The highest summit of a surface has infinite height. Equal values are ordered by vertex number, but vertices beside
    a higher value come last, so that the level border of an end has summits apart from a bump that touches it.

    Args:
        surface: the surface.
        values: the function, shape (V,).
        kept: whether a summit at each vertex counts as higher than the summits at all other vertices, shape (V,); no
            summit does if None.
    """
    start, beside = (part.tolist() for part in neighbours(surface))
    order = np.lexsort((np.arange(len(values)), _has_higher_neighbour(surface, values), -values)).tolist()
    rank = np.empty(len(values), dtype=np.int64)
    rank[order] = np.arange(len(order))
    place, parent, height = rank.tolist(), [-1] * len(values), values.tolist()
    order_of_summits = place if kept is None else (rank - len(rank) * kept).tolist()
    found = []
    for vertex in order:
        roots = []
        for other in beside[start[vertex] : start[vertex + 1]]:
            if place[other] < place[vertex]:
                root = _root(parent, other)
                if root not in roots:
                    roots.append(root)
        roots.sort(key=order_of_summits.__getitem__)
        parent[vertex] = roots[0] if roots else vertex
        for lower in roots[1:]:
            found.append((lower, height[lower] - height[vertex], height[vertex]))
            parent[lower] = roots[0]
    found += [(vertex, np.inf, -np.inf) for vertex in order if parent[vertex] == vertex]
    return found


def _has_higher_neighbour(surface: TriangleSurface, values: FloatArray) -> NDArray[np.bool_]:
    one, other = surface.edges.T
    found = np.zeros(len(values), dtype=bool)
    found[one[values[other] > values[one]]] = True
    found[other[values[one] > values[other]]] = True
    return found


def _root(parent: list[int], vertex: int) -> int:
    """The summit of the part that a vertex belongs to; paths are shortened on the way."""
    while parent[vertex] != parent[parent[vertex]]:
        parent[vertex] = parent[parent[vertex]]
    return parent[vertex]


def lasting_extrema(surface: TriangleSurface, values: FloatArray, least: float) -> IntArray:
    """Return the vertices of all summits that are higher than ``least`` above their saddle."""
    return np.array([vertex for vertex, height, _ in summits(surface, values) if height > least], dtype=np.int64)


def smooth_out(surface: TriangleSurface, values: FloatArray, least: float, ends: Ends) -> FloatArray:
    """Return the function without summits and hollows that are lower than ``least``, shape (V,).

    Args:
        surface: the surface.
        values: the function, shape (V,).
        least: height of a summit above its saddle from which it stays.
        ends: ends, whose vertices keep their values.
    """
    kept = np.zeros(len(values), dtype=bool)
    kept[np.concatenate([end.vertices for end in ends.all])] = True
    # How often summits are looked for, because smoothing one out can lift another one above its saddle.
    for _ in range(8):
        region = np.zeros(len(values), dtype=bool)
        for sign in (1.0, -1.0):
            for vertex, height, saddle in summits(surface, sign * values, kept):
                if height < least and not kept[vertex]:
                    region |= _part_above(surface, sign * values, vertex, saddle, least)
        region &= ~kept
        if not region.any():
            break
        values = _harmonic(surface, values, region)
    return values


def _part_above(
    surface: TriangleSurface, values: FloatArray, summit: int, saddle: float, margin: float
) -> NDArray[np.bool_]:
    """Whether each vertex is connected to a summit strictly above its saddle, or is near such a vertex, shape (V,)."""
    above = values > saddle
    edges = surface.edges[above[surface.edges].all(axis=1)]
    part = linked_groups(len(values), *edges.T)
    region = above & (part == part[summit])
    for _ in range(2):
        ring = surface.edges[region[surface.edges].any(axis=1)]
        region[ring.ravel()] = True
    return region


def _harmonic(surface: TriangleSurface, values: FloatArray, region: NDArray[np.bool_]) -> FloatArray:
    """Replace values in a region by the harmonic function with the values around it."""
    from scipy.sparse.linalg import spsolve

    matrix = _positive_laplacian(surface)
    inner, outer = np.flatnonzero(region), np.flatnonzero(~region)
    if not len(outer):
        return values
    rows = matrix[inner]
    smooth = values.copy()
    smooth[inner] = spsolve(rows[:, inner].tocsc(), -(rows[:, outer] @ values[outer]))
    return smooth


def _positive_laplacian(surface: TriangleSurface) -> csr_array:
    """A Laplacian whose edges all have positive weights, shape (V, V)."""
    from scipy.sparse import coo_array, diags_array

    full = surface.stiffness().tocoo()
    off = full.row != full.col
    least = SMALLEST_WEIGHT / np.sqrt(3.0)
    weight = np.maximum(-full.data[off], least)
    shape = (len(surface.vertices),) * 2
    links = coo_array((weight, (full.row[off], full.col[off])), shape=shape).tocsr()
    return (diags_array(links.sum(axis=1)) - links).tocsr()


@dataclass(frozen=True, eq=False)
class Knots:
    """Vertices that share one value: the vertices of an end are one unknown, each other vertex is its own."""

    unknown: IntArray
    """Unknown of each vertex, shape (V,); the unknowns of the ends come first, in their order."""
    count: int
    """Number of unknowns."""

    def matrix(self, full: csr_array) -> csr_array:
        """Return the matrix of the unknowns from the matrix of the vertices."""
        from scipy.sparse import coo_array

        entries = full.tocoo()
        place = (self.unknown[entries.row], self.unknown[entries.col])
        return coo_array((entries.data, place), shape=(self.count, self.count)).tocsr()

    def total(self, values: FloatArray) -> FloatArray:
        """Return the sum over the vertices of each unknown, shape (count,)."""
        total = np.bincount(self.unknown, values, self.count)
        return np.asarray(total, dtype=np.float64)

    def solve(self, full: csr_array, right: FloatArray, known: dict[int, float]) -> FloatArray:
        """Solve for the value of each vertex, shape (V,).

        Args:
            full: matrix of the vertices, shape (V, V).
            right: right-hand side of each unknown, shape (count,).
            known: values of unknowns that are not solved for; at least one.
        """
        from scipy.sparse.linalg import splu

        matrix, value = self.matrix(full), np.zeros(self.count)
        value[list(known)] = list(known.values())
        free = np.setdiff1d(np.arange(self.count), list(known))
        inner = matrix[free][:, free].tocsc()
        solver = splu(inner, diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        value[free] = solver.solve((right - matrix @ value)[free])
        return value[self.unknown]


def knots(surface: TriangleSurface, ends: Ends) -> Knots:
    """Return the unknowns of a time on a surface: first one for each end, then one for each other vertex."""
    unknown = np.full(len(surface.vertices), -1)
    for number, end in enumerate(ends.all):
        unknown[end.vertices] = number
    free = unknown < 0
    unknown[free] = len(ends.all) + np.arange(free.sum())
    return Knots(unknown, len(ends.all) + int(free.sum()))


def first_flow(surface: TriangleSurface, ends: Ends) -> FloatArray:
    """Return the height of a steady flow to the roots, shape (V,): 0 at the roots and positive everywhere else.

    Water also enters at the other ends, so that the flow does not stand still there.
    """
    parts = knots(surface, ends)
    source = parts.total(surface.vertex_area)
    size = float(np.sqrt(surface.area.sum()))
    for number, end in enumerate(ends.others, start=len(ends.roots)):
        points = surface.vertices[end.vertices]
        # Water that enters at an end, over the length of the end times the size of the surface.
        source[number] += 0.25 * size * float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    return parts.solve(surface.stiffness(), source, dict.fromkeys(range(len(ends.roots)), 0.0))


def given_times(ends: Ends) -> dict[int, float]:
    """Return the times [cm] of the ends that have one, by number, as heights above the roots.

    If none has one, the first root has the time 0.
    """
    sign = 1.0 if ends.begins else -1.0
    given = {number: sign * end.time for number, end in enumerate(ends.all) if end.time is not None}
    return given or {0: 0.0}


def even_slope(surface: TriangleSurface, time: FloatArray, ends: Ends, rounds: int = ROUNDS) -> FloatArray:
    """Return a time [cm] whose slope is near 1, from a time whose gradient has the right directions, shape (V,)."""
    parts, known = knots(surface, ends), given_times(ends)
    weight = np.ones(len(surface.triangles))
    for _ in range(rounds):
        gradient = surface.gradient(time)
        slope = np.linalg.norm(gradient, axis=1)
        # Slope of the first flow, over its median, below which the direction of the gradient counts less.
        least = 0.15 * float(np.median(slope))
        direction = gradient / np.maximum(slope, least)[:, None]
        right = parts.total(surface.divergence(direction, weight))
        time = parts.solve(surface.stiffness(weight), right, known)
        slope = np.linalg.norm(surface.gradient(time), axis=1)
        weight = 1.0 + (STEEP_WEIGHT - 1.0) / (1.0 + np.exp(-20.0 * (slope - 1.0)))
    return time


def whole_rows(surface: TriangleSurface, time: FloatArray, ends: Ends) -> FloatArray:
    """Move the times of all ends to whole numbers; elsewhere the gradient changes as little as possible.

    The times of grafts become halves.

    Args:
        surface: the surface.
        time: time in courses, shape (V,).
        ends: the ends.
    """
    parts = knots(surface, ends)
    # The last rows at both sides of a graft are one course apart.
    shift = np.repeat([0.0, 0.5], [len(ends.all) - len(ends.grafts), len(ends.grafts)])
    at_end = np.array([time[end.vertices].mean() for end in ends.all])
    known = dict(enumerate((np.rint(at_end - shift) + shift).tolist()))
    right = parts.total(surface.divergence(surface.gradient(time)))
    return parts.solve(surface.stiffness(), right, known)


def knitting_time(
    surface: TriangleSurface, ends: Ends, course_height: float, report_part: Callable[[float], None] = lambda _: None
) -> tuple[FloatArray, Ends]:
    """Return the time of each vertex in courses, shape (V,), and the ends.

    Slits in which the flow has a summit, such as the open toe of a sock, become ends. Borders of limbs without
    a row of their own, such as the cut sleeves of a vest, are no ends but sides, if no mark chose them.

    Args:
        surface: a connected surface.
        ends: the ends.
        course_height: height of a course [cm].
        report_part: called with the completed part, from 0 to 1, before each step.

    Raises:
        MeshError: no place of the surface is far enough from where knitting begins; the message names the place.
    """
    sides: tuple[End, ...] = ()
    time, found = _even_time(surface, ends, sides, course_height, report_part)
    while len((lasting := _without_short_limbs(surface, time, found)).others) < len(found.others):
        sides = (*sides, *(end for end in found.others if end not in lasting.others))
        # Without reports, which would begin at 0 again.
        time, found = _even_time(surface, lasting, sides, course_height, lambda _: None)
    return (time if found.begins else -time), found


def _even_time(
    surface: TriangleSurface, ends: Ends, sides: Sequence[End], course_height: float,
    report_part: Callable[[float], None],
) -> tuple[FloatArray, Ends]:  # fmt: skip
    """The time above the roots in courses, shape (V,), and the ends with added tips in slits that are no sides."""
    report_part(0.0)
    flow = first_flow(surface, ends)
    tips = _tips_in_slits(surface, flow, ends, sides)
    if tips:
        ends = replace(ends, others=(*ends.others, *tips))
        flow = first_flow(surface, ends)
    report_part(0.2)
    time = even_slope(surface, flow, ends)
    report_part(0.6)
    rough, time = time, smooth_out(surface, time / course_height, LOWEST_SUMMIT, ends) * course_height
    if not np.ptp(time) > 0.0:
        raise _pinched(surface, rough / course_height)
    report_part(0.7)
    # How often the direction is renewed after small summits are smoothed out.
    time = even_slope(surface, time, ends, 3)
    report_part(0.9)
    time = whole_rows(surface, time / course_height, ends)
    return smooth_out(surface, time, LOWEST_SUMMIT, ends), ends


def _pinched(surface: TriangleSurface, time: FloatArray) -> MeshError:
    """Return the error of a part on which no place is far enough from where knitting begins; times are in courses."""
    place, found = surface.vertices[int(np.argmax(time))], float(np.ptp(time))
    return MeshError(
        f"near {place.round(1).tolist()} cm: the mesh is pinched: no place is more than {found:.1f} courses from the "
        f"borders where knitting begins, expected {LOWEST_SUMMIT:g}; choose a smaller stitch, join the borders that "
        "meet there, or mark where knitting begins and ends"
    )


def _without_short_limbs(surface: TriangleSurface, time: FloatArray, ends: Ends) -> Ends:
    """The ends without the ends of limbs on which no row closes, if no mark chose them.

    All leg openings of briefs are such ends; knitting then begins at the crotch between them.

    Args:
        surface: the surface.
        time: time above the roots in courses, shape (V,).
        ends: the ends.
    """
    if not ends.automatic:
        return ends
    kept = np.zeros(len(time), dtype=bool)
    kept[np.concatenate([end.vertices for end in ends.all])] = True
    height = np.zeros(len(time))
    for vertex, above_saddle, _ in summits(surface, time, kept):
        height[vertex] = above_saddle
    of_end = np.array([height[end.vertices].max() for end in ends.others])
    time_of_end = np.array([time[end.vertices[0]] for end in ends.others])
    saddle = (time_of_end - of_end).max(initial=-np.inf)  # the highest summit joins another one at its saddle
    # Of two equal limbs, one can be a row higher than the other because ends are at whole rows.
    of_end = np.where(np.isinf(of_end), time_of_end - saddle - 1.0, of_end)
    # Height of an end above its saddle, in courses, below which its limb has no row of its own on its short side.
    lasting = (end for end, above in zip(ends.others, of_end, strict=True) if above >= 0.25)
    return replace(ends, others=tuple(lasting))


def _tips_in_slits(surface: TriangleSurface, flow: FloatArray, ends: Ends, sides: Sequence[End]) -> list[End]:
    """The borders, other than the ends and some sides, in which the flow has a summit."""
    # Height of a summit of the first flow above its saddle, over the range of the flow, that makes a slit a tip.
    lasting = lasting_extrema(surface, flow, 0.3 * float(np.ptp(flow)))
    used = np.concatenate([end.vertices for end in (*ends.all, *sides)])
    free = [border for border in surface.borders if not np.isin(border, used).any()]
    return [End(border) for border in free if np.isin(lasting, border).any()]
