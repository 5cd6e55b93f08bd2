# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Do loops hold one another as their stitches say? Linking numbers with a probe.

Loops and the links between them (``loops``), closed to rings (``closings``), have linking numbers: whole numbers that
change only where yarn passes through yarn, or through a closing. They are compared with what the stitches name
(``passes``), for each pair whose boxes meet; others are not linked. A link and a loop that it runs into meet in a cut
and have none; yarn drawn through loops is told from these alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array
from scipy.spatial import cKDTree

from stitchmesh.errors import YarnError
from stitchmesh.mesh import IntArray, StitchMesh
from stitchmesh.yarn import YarnSet
from stitchmesh.yarngen.bridges import SLOTS
from stitchmesh.yarngen.closings import as_polygons, close_arcs
from stitchmesh.yarngen.finish import DEFAULT_FINISH, Finish
from stitchmesh.yarngen.loops import Arc, Arcs, find_arcs
from stitchmesh.yarngen.passes import expected_passes, is_drawn, slipped_legs, spanned_sides
from stitchmesh.yarngen.polygon_linking import Polygons, linking_numbers

WHOLE = 1e-6
"""How far a linking number may be from a whole number."""
REASONS = "a stitch is drawn wrongly, or yarn passed through yarn"


@dataclass(frozen=True, eq=False)
class LoopLinking:
    """How yarn passes through loops, signed as in ``passes``."""

    passes: csr_array
    """How often each link passes through each loop, shape (links, loops)."""
    turns: NDArray[Any]
    """How often the link that passes each leg of a slipped loop goes around it, shape (legs,)."""


def expected_linking(arcs: Arcs) -> LoopLinking:
    """What the stitches name."""
    return LoopLinking(expected_passes(arcs), slipped_legs(arcs).turns)


def loop_linking(arcs: Arcs, yarns: YarnSet, *, drawn_out: bool = False) -> LoopLinking:
    """What the yarns do.

    Args:
        arcs: loops and links of the yarns.
        yarns: those yarns, as generated, or relaxed since.
        drawn_out: whether to take half of the arcs beside it to each, as yarn that was relaxed has slid through loops;
            fewer pairs can then be told.
    """
    legs = slipped_legs(arcs)
    probes = close_arcs(arcs, yarns, legs, drawn_out=drawn_out)
    points = probes.positions(yarns)
    curves, tested = probes.links, np.flatnonzero([len(curve) > 0 for curve in probes.links])
    links, loops = as_polygons(points, [curves[k] for k in tested]), as_polygons(points, probes.loops)
    pairs = _near(links, loops)
    pairs = pairs[_can_be_told(arcs, tested[pairs[:, 0]], pairs[:, 1], drawn_out)]
    values = linking_numbers(loops, links, pairs[:, ::-1])
    shape = len(arcs.links), len(arcs.loops)
    passes = coo_array((values, (tested[pairs[:, 0]], pairs[:, 1])), shape=shape).tocsr()
    if len(legs.link) == 0:
        return LoopLinking(passes, np.zeros(0))
    each = np.arange(len(legs.link))
    legs_closed, passing = as_polygons(points, probes.legs), as_polygons(points, [curves[k] for k in legs.link])
    return LoopLinking(passes, linking_numbers(legs_closed, passing, np.stack([each, each], axis=1)))


def check_loops(
    fabric: StitchMesh, yarns: YarnSet, *, finish: Finish = DEFAULT_FINISH, relaxed: bool = False
) -> None:
    """Check that each loop holds, and is held by, exactly the loops that its stitch names.

    Args:
        fabric: the stitch mesh.
        yarns: the yarns generated from it, relaxed or not.
        finish: how its first and last rows were finished.
        relaxed: whether yarns were relaxed and have slid through loops. Then it is enough that arcs as they were cut,
            or drawn out, are linked as named; and of the ends of rows, whose turns slip into stitches, and of links
            that float past loops and should not pass through them, nothing is told.

    Raises:
        YarnError: the yarns were not generated from this stitch mesh, or a loop passes through another more or less
            often than its stitch says; it names both.
    """
    arcs = find_arcs(fabric, yarns, finish)
    expected, found = expected_linking(arcs), loop_linking(arcs, yarns)
    passes, turns = abs(found.passes - expected.passes) > WHOLE, np.abs(found.turns - expected.turns) > WHOLE
    if relaxed:
        again = loop_linking(arcs, yarns, drawn_out=True)
        passes = passes.multiply(abs(again.passes - expected.passes) > WHOLE)
        turns &= np.abs(again.turns - expected.turns) > WHOLE
    wrong = np.stack(passes.nonzero(), axis=1)
    wrong = wrong[~_has_slipped(arcs, wrong)] if relaxed else wrong
    if len(wrong):
        link, loop = (int(number) for number in wrong[0])
        raise YarnError(
            f"{_link_name(arcs, link)}: passes {found.passes[link, loop]:g} times through {_loop_name(arcs, loop)}, "
            f"expected {expected.passes[link, loop]:g} ({len(wrong)} such places); {REASONS}"
        )
    legs = np.flatnonzero(turns)
    if len(legs):
        face = arcs.pieces.course.face_below[arcs.pieces.face[slipped_legs(arcs).piece[legs[0]]]]
        raise YarnError(
            f"face {face}: yarn goes {found.turns[legs[0]]:g} times around a leg of its slipped loop, expected "
            f"{expected.turns[legs[0]]} ({len(legs)} such places); {REASONS}"
        )


def _near(first: Polygons, second: Polygons) -> IntArray:
    """Pairs of polygons whose boxes meet, shape (n, 2)."""
    (low, high), (other_low, other_high) = first.bounds(), second.bounds()
    reach, other_reach = (np.linalg.norm(b - a, axis=1) / 2 for a, b in ((low, high), (other_low, other_high)))
    tree = cKDTree((other_low + other_high) / 2)
    found = tree.query_ball_point((low + high) / 2, reach + other_reach.max(), return_sorted=True)
    pairs = np.array([(i, j) for i, near in enumerate(found) for j in near], dtype=np.int64).reshape(-1, 2)
    i, j = pairs.T
    return pairs[((low[i] <= other_high[j]) & (other_low[j] <= high[i])).all(axis=1)]


def _can_be_told(arcs: Arcs, links: IntArray, loops: IntArray, drawn_out: bool) -> NDArray[np.bool_]:
    """Which pairs can be told.

    All that are named; else not a link and a loop that it runs into, nor yarn that is drawn through other loops. Drawn
    out, nor a link and a loop made on one that it runs into or passes, or worked together with it or beside it.
    """
    expected = abs(expected_passes(arcs))
    runs_into = _attached(arcs)
    hangs_by = runs_into + _spanned(arcs)
    near = hangs_by @ expected.T @ runs_into + runs_into @ expected.T @ expected
    shared = runs_into + near if drawn_out else runs_into
    drawn = np.array([is_drawn(arcs, link) for link in arcs.links])[links]
    told: NDArray[np.bool_] = (expected[links, loops] > 0) | ((shared[links, loops] == 0) & ~drawn)
    return told


def _has_slipped(arcs: Arcs, pairs: IntArray) -> NDArray[np.bool_]:
    """Which pairs of a link and a loop cannot be told once yarns are relaxed, shape (n,)."""
    ends = np.array([sum(link.hangs) == 1 for link in arcs.links])
    floats, named = np.diff(_spanned(arcs).indptr) > 0, expected_passes(arcs)
    return np.array([ends[link] or (floats[link] and named[link, loop] == 0) for link, loop in pairs], dtype=bool)


def _attached(arcs: Arcs) -> csr_array:
    """Which links run into which loops, shape (links, loops)."""
    pairs = [
        (number, arcs.loop_at[point])
        for number, link in enumerate(arcs.links)
        for point in (link.first, link.last)
        if point in arcs.loop_at
    ]
    return _marked(arcs, pairs)


def _spanned(arcs: Arcs) -> csr_array:
    """Which links pass beside which loops, shape (links, loops)."""
    spans = [(number, side) for number, link in enumerate(arcs.links) for side, _ in spanned_sides(arcs, link)]
    return _marked(arcs, [(number, arcs.loop_over[side]) for number, side in spans])


def _marked(arcs: Arcs, pairs: list[tuple[int, int]]) -> csr_array:
    rows, columns = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
    shape = len(arcs.links), len(arcs.loops)
    return coo_array((np.ones(len(rows), dtype=np.int64), (rows, columns)), shape=shape).tocsr()


def _loop_name(arcs: Arcs, number: int) -> str:
    """A loop by the top side that it was made on."""
    loop = arcs.loops[number]
    cuts = {loop.first, loop.last}
    for link in arcs.links:
        for crossing, point in zip(link.ends, (link.first, link.last), strict=True):
            if point in cuts:
                return _named(arcs, crossing)
    return f"the ring that starts in face {arcs.pieces.course.face_below[arcs.pieces.face[loop.pieces[0]]]}"


def _link_name(arcs: Arcs, number: int) -> str:
    """A link by the loops that it joins."""
    link: Arc = arcs.links[number]
    names = [_named(arcs, crossing) for crossing, hangs in zip(link.ends, link.hangs, strict=True) if hangs]
    face = arcs.pieces.course.face_below[arcs.pieces.face[link.pieces[0]]]
    return f"face {face}: its yarn at {' and '.join(names)}" if names else f"face {face}: the yarn drawn through it"


def _named(arcs: Arcs, crossing: int) -> str:
    side = crossing // SLOTS
    face = int(arcs.whole.side_face[side])
    place = int(arcs.whole.n_bottom[face] + arcs.whole.n_top[face] - arcs.whole.side_place[side])
    return f"loop {place + 1} of face {arcs.pieces.course.face_below[face]}"
