# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Do loops hold one another as their stitches say? Linking numbers with a probe.

Loops and the links between them (``loops``), closed to rings (``closings``), have linking numbers: whole numbers that
change only where yarn passes through yarn, or through a closing. They are compared with what the stitches name
(``threadings``), for each pair whose boxes meet; others are not linked. A link and a loop that it runs into meet in a cut
and have none; yarn drawn through loops is told from these alone.

So it is told of yarns as they are drawn. Of yarns that moved since, where closings would be in the way, it is told
whether they can have come from there (``pulled_through``).
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
from stitchmesh.yarngen.finish import DEFAULT_FINISH, YarnFinish
from stitchmesh.yarngen.generate import yarns_along_routes
from stitchmesh.yarngen.loop_check.closure import as_polygons, close_arcs
from stitchmesh.yarngen.loop_check.loops import Arc, Arcs, find_arcs
from stitchmesh.yarngen.loop_check.pieces import generation_radius, yarn_pieces
from stitchmesh.yarngen.loop_check.polygon_linking import Polygons, linking_numbers
from stitchmesh.yarngen.loop_check.pulled_through import check_pulled_through
from stitchmesh.yarngen.loop_check.threadings import expected_threadings, is_drawn_through, slipped_legs
from stitchmesh.yarngen.loop_check.unrolled_loops import unroll_loops

WHOLE = 1e-6
"""How far a linking number may be from a whole number."""
ArcMask = NDArray[np.bool_] | None
"""Which arcs are told; None for all."""


@dataclass(frozen=True, eq=False)
class LoopLinking:
    """How yarn passes through loops, signed as in ``threadings``."""

    threadings: csr_array
    """How often each link passes through each loop, shape (links, loops)."""
    turns: NDArray[Any]
    """How often the link that passes each leg of a slipped loop goes around it, shape (legs,)."""


def expected_linking(arcs: Arcs) -> LoopLinking:
    """What the stitches name."""
    return LoopLinking(expected_threadings(arcs), slipped_legs(arcs).turns)


def loop_linking(arcs: Arcs, yarns: YarnSet, *, links: ArcMask = None, loops: ArcMask = None) -> LoopLinking:
    """What the yarns do.

    Args:
        arcs: loops and links of the yarns.
        yarns: those yarns, as generated.
        links: which links are told; all where not given.
        loops: which loops they may pass through; all where not given.
    """
    legs = slipped_legs(arcs)
    test_curves = close_arcs(arcs, yarns, legs)
    points = test_curves.positions(yarns)
    curves, tested = test_curves.links, np.array([len(curve) > 0 for curve in test_curves.links])
    tested = np.flatnonzero(tested if links is None else tested & links)
    held = np.arange(len(arcs.loops)) if loops is None else np.flatnonzero(loops)
    passing = as_polygons(points, [curves[k] for k in tested])
    passed = as_polygons(points, [test_curves.loops[k] for k in held])
    pairs = _near(passing, passed)
    pairs = pairs[_are_checkable(arcs, tested[pairs[:, 0]], held[pairs[:, 1]])]
    values = linking_numbers(passed, passing, pairs[:, ::-1])
    shape = len(arcs.links), len(arcs.loops)
    threadings = coo_array((values, (tested[pairs[:, 0]], held[pairs[:, 1]])), shape=shape).tocsr()
    if len(legs.link) == 0:
        return LoopLinking(threadings, np.zeros(0))
    each = np.arange(len(legs.link))
    legs_closed, beside = as_polygons(points, test_curves.legs), as_polygons(points, [curves[k] for k in legs.link])
    return LoopLinking(threadings, linking_numbers(legs_closed, beside, np.stack([each, each], axis=1)))


def check_loops(fabric: StitchMesh, yarns: YarnSet, *, finish: YarnFinish = DEFAULT_FINISH) -> None:
    """Check that each loop holds, and is held by, exactly the loops that its stitch names.

    Of the yarns as drawn, linking numbers tell; of the same yarns elsewhere, whether they can be where they are without
    passing through one another on their way from there.

    Args:
        fabric: the stitch mesh, a piece or one that repeats.
        yarns: the yarns generated from it, relaxed or not.
        finish: how its first and last rows were finished.

    Raises:
        YarnError: the yarns were not generated from this stitch mesh; a loop passes through another more or less
            often than its stitch says, or yarn passed through yarn; it names both.
    """
    if (fabric.lattice is None) != (yarns.lattice is None):
        raise YarnError("yarns: of yarns and stitch mesh one repeats on a lattice; expected both or neither")
    pieces = yarn_pieces(fabric, yarns, finish)
    radius = generation_radius(fabric, yarns)
    generated = yarns_along_routes(pieces.routes, radius)
    if fabric.lattice is None:
        _check_generated(find_arcs(fabric, generated, finish), generated)
    else:
        checkable = unroll_loops(fabric, radius, finish)
        _check_generated(checkable.arcs, checkable.yarns, checkable.links, checkable.loops)
    check_pulled_through(generated, yarns)


def _check_generated(arcs: Arcs, generated: YarnSet, links: ArcMask = None, loops: ArcMask = None) -> None:
    """Raise where linking numbers are not as named."""
    expected, found = expected_linking(arcs), loop_linking(arcs, generated, links=links, loops=loops)
    wrong = np.stack((abs(found.threadings - expected.threadings) > WHOLE).nonzero(), axis=1)
    wrong = wrong if links is None else wrong[links[wrong[:, 0]]]
    if len(wrong):
        link, loop = (int(number) for number in wrong[0])
        raise YarnError(
            f"{_link_name(arcs, link)}: passes {found.threadings[link, loop]:g} times through {_loop_name(arcs, loop)}, "
            f"expected {expected.threadings[link, loop]:g} ({len(wrong)} such places); a stitch is drawn wrongly"
        )
    legs = slipped_legs(arcs)
    wrong = np.flatnonzero(np.abs(found.turns - expected.turns) > WHOLE)
    wrong = wrong if links is None else wrong[links[legs.link[wrong]]]
    if len(wrong):
        face = arcs.pieces.routes.face_below[arcs.pieces.face[legs.piece[wrong[0]]]]
        raise YarnError(
            f"face {face}: yarn goes {found.turns[wrong[0]]:g} times around a leg of its slipped loop, expected "
            f"{expected.turns[wrong[0]]} ({len(wrong)} such places); a stitch is drawn wrongly"
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


def _are_checkable(arcs: Arcs, links: IntArray, loops: IntArray) -> NDArray[np.bool_]:
    """Which pairs can be told: all that are named; else no link and a loop it runs into, nor yarn drawn through."""
    drawn_through = np.array([is_drawn_through(arcs, link) for link in arcs.links])[links]
    checkable: NDArray[np.bool_] = (abs(expected_threadings(arcs))[links, loops] > 0) | (
        (_attached(arcs)[links, loops] == 0) & ~drawn_through
    )
    return checkable


def _attached(arcs: Arcs) -> csr_array:
    """Which links run into which loops, shape (links, loops)."""
    pairs = [
        (number, arcs.loop_of_cut[point])
        for number, link in enumerate(arcs.links)
        for point in (link.first, link.last)
        if point in arcs.loop_of_cut
    ]
    return _incidence(arcs, pairs)


def _incidence(arcs: Arcs, pairs: list[tuple[int, int]]) -> csr_array:
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
    return f"the ring that starts in face {arcs.pieces.routes.face_below[arcs.pieces.face[loop.pieces[0]]]}"


def _link_name(arcs: Arcs, number: int) -> str:
    """A link by the loops that it joins."""
    link: Arc = arcs.links[number]
    names = [_named(arcs, crossing) for crossing, on_needle in zip(link.ends, link.on_needle, strict=True) if on_needle]
    face = arcs.pieces.routes.face_below[arcs.pieces.face[link.pieces[0]]]
    return f"face {face}: its yarn at {' and '.join(names)}" if names else f"face {face}: the yarn drawn through it"


def _named(arcs: Arcs, crossing: int) -> str:
    side = crossing // SLOTS
    face = int(arcs.whole.side_face[side])
    place = int(arcs.whole.n_bottom[face] + arcs.whole.n_top[face] - arcs.whole.side_place[side])
    return f"loop {place + 1} of face {arcs.pieces.routes.face_below[face]}"
