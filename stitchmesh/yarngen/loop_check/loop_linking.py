# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Check that loops hold each other as their stitches define, by linking numbers of closed test curves.

Loops and links (``loops``) are closed to test curves (``closure``). The linking number of two closed curves is a whole
number that changes only where yarn passes through yarn or through a closure. The linking numbers are compared with the
threadings that the stitches define (``threadings``). A link and the loop into which it runs meet at a cut and have no
linking number. For yarn that is drawn through loops, only the defined threadings are checked.

This check applies to yarns as generated. After relaxation, closures could intersect yarn that has moved. For yarns at
other positions, the check is therefore whether the generated yarns can be deformed into them without crossings of yarn
through yarn (``pulled_through``).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array, diags_array

from stitchmesh.errors import YarnError, check_kind
from stitchmesh.linking.polygon_linking import linking_numbers
from stitchmesh.linking.pulled_through import check_pulled_through
from stitchmesh.mesh import StitchMesh
from stitchmesh.yarn import YarnSet
from stitchmesh.yarngen.bridges import SLOTS
from stitchmesh.yarngen.finish import DEFAULT_FINISH, YarnFinish
from stitchmesh.yarngen.generate import yarns_along_routes
from stitchmesh.yarngen.loop_check.closure import close_arcs
from stitchmesh.yarngen.loop_check.loops import Arc, Arcs, find_arcs
from stitchmesh.yarngen.loop_check.pieces import generation_radius, yarn_pieces
from stitchmesh.yarngen.loop_check.threadings import expected_threadings, is_drawn_through, slipped_legs
from stitchmesh.yarngen.loop_check.unrolled_loops import unroll_loops

WRONG_TEMPLATE = "the template of a stitch is wrong"
"""The cause that a message gives if a fabric on a lattice fails, because all stitches of such a fabric have room."""
ArcMask = NDArray[np.bool_] | None
"""Which arcs are checked; None for all arcs."""


@dataclass(frozen=True, eq=False)
class LoopLinking:
    """How links thread loops and wind around legs of slipped loops, with the signs of ``threadings``."""

    threadings: csr_array
    """How often each link threads each loop, shape (links, loops)."""
    turns: NDArray[Any]
    """How often the link that passes a leg of a slipped loop winds around that leg, shape (legs,).

    NaN where the link has no test curve, because it threads no loop.
    """


def expected_linking(arcs: Arcs) -> LoopLinking:
    """The linking that the stitches define."""
    return LoopLinking(expected_threadings(arcs), slipped_legs(arcs).turns)


def loop_linking(arcs: Arcs, yarns: YarnSet, *, links: ArcMask = None, loops: ArcMask = None) -> LoopLinking:
    """The linking of the yarns.

    Args:
        arcs: loops and links of the yarns.
        yarns: the yarns, as generated.
        links: which links are checked, shape (links,); all if not given.
        loops: which loops the links are checked against, shape (loops,); all if not given.
    """
    legs = slipped_legs(arcs)
    test_curves = close_arcs(arcs, yarns, legs)
    is_checked = np.array([len(curve) > 0 for curve in test_curves.links])
    if links is not None:
        is_checked &= links
    link_numbers = np.flatnonzero(is_checked)
    loop_numbers = np.arange(len(arcs.loops)) if loops is None else np.flatnonzero(loops)
    leg_numbers = np.flatnonzero(is_checked[legs.link])
    curves = [test_curves.links[k] for k in link_numbers]
    first_loop = len(curves)
    curves += [test_curves.loops[k] for k in loop_numbers]
    first_leg = len(curves)
    curves += [test_curves.legs[k] for k in leg_numbers]
    numbers = linking_numbers(test_curves.positions(yarns), curves)

    found = numbers[:first_loop, first_loop:first_leg].tocoo()
    shape = len(arcs.links), len(arcs.loops)
    threadings = coo_array((found.data, (link_numbers[found.row], loop_numbers[found.col])), shape=shape).tocsr()
    turns = np.full(len(legs.link), np.nan)
    passing = np.searchsorted(link_numbers, legs.link[leg_numbers])
    turns[leg_numbers] = numbers[passing][:, first_leg:].diagonal()
    return LoopLinking(_checkable(arcs, threadings), turns)


def check_loops(fabric: StitchMesh, yarns: YarnSet, *, finish: YarnFinish = DEFAULT_FINISH) -> None:
    """Check that each loop holds, and is held by, exactly the loops that its stitch defines.

    For yarns as generated, the check compares linking numbers. For the same yarns at other positions, it also checks
    that the generated yarns can be deformed into them without passing through each other.

    Args:
        fabric: the stitch mesh, with or without a lattice.
        yarns: the yarns generated from it, relaxed or not.
        finish: the finish with which the yarns were generated.

    Raises:
        YarnError: the yarns were not generated from this stitch mesh with this finish; a link threads a loop more or
            less often than its stitch defines; or yarn has passed through yarn. The message names both places.
    """
    check_kind("check_loops", fabric, StitchMesh)
    check_kind("check_loops, yarns", yarns, YarnSet)
    if (fabric.lattice is None) != (yarns.lattice is None):
        raise YarnError("yarns: of the yarns and the stitch mesh only one has a lattice; expected both or neither")
    pieces = yarn_pieces(fabric, yarns, finish)
    radius = generation_radius(fabric, yarns)
    generated = yarns_along_routes(pieces.routes, radius)
    if fabric.lattice is None:
        try:
            _check_generated(find_arcs(fabric, generated, finish), generated)
        except YarnError as error:
            assert error.face is not None  # It names the stitch.
            corners = fabric.face_vertex[fabric.sides_of(np.array([error.face]))]
            place = fabric.vertices[corners].mean(axis=0).round(1).tolist()
            room = f"near {place} cm, make room (sm.make_room), or use a thinner yarn"
            remedy = f"{room}; if neither helps, {WRONG_TEMPLATE}"
            raise YarnError(error.found, face=error.face, remedy=remedy) from error
    else:
        checkable = unroll_loops(fabric, radius, finish)
        _check_generated(checkable.arcs, checkable.yarns, checkable.links, checkable.loops)
    check_pulled_through(generated, yarns)


def _check_generated(arcs: Arcs, generated: YarnSet, links: ArcMask = None, loops: ArcMask = None) -> None:
    """Raise ``YarnError`` if the linking of generated yarns differs from the linking that the stitches define."""
    expected, found = expected_linking(arcs), loop_linking(arcs, generated, links=links, loops=loops)
    wrong = np.stack((found.threadings != expected.threadings).nonzero(), axis=1)
    wrong = wrong if links is None else wrong[links[wrong[:, 0]]]
    if len(wrong):
        link, loop = (int(number) for number in wrong[0])
        raise YarnError(
            f"{_link_name(arcs, link)}: passes {found.threadings[link, loop]} times through "
            f"{_loop_name(arcs, loop)}, expected {expected.threadings[link, loop]} ({len(wrong)} such places)",
            face=_face_of_link(arcs, link),
            remedy=WRONG_TEMPLATE,
        )
    legs = slipped_legs(arcs)
    wrong = np.flatnonzero(~np.isnan(found.turns) & (found.turns != expected.turns))
    if len(wrong):
        face = arcs.pieces.routes.face_below[arcs.pieces.face[legs.piece[wrong[0]]]]
        raise YarnError(
            f"face {face}: yarn winds {found.turns[wrong[0]]:g} times around a leg of its slipped loop, expected "
            f"{expected.turns[wrong[0]]} ({len(wrong)} such places)",
            face=int(face),
            remedy=WRONG_TEMPLATE,
        )


def _checkable(arcs: Arcs, threadings: csr_array) -> csr_array:
    """The threadings that can be checked, shape (links, loops).

    These are all that are defined, and others unless the link runs into the loop or is drawn through loops.
    """
    defined = threadings * (expected_threadings(arcs) != 0)
    others = threadings - defined
    others = others - others * (_attached(arcs) != 0)
    makes_loops = np.array([not is_drawn_through(arcs, link) for link in arcs.links], dtype=np.int64)
    return (defined + diags_array(makes_loops, dtype=np.int64) @ others).tocsr()


def _attached(arcs: Arcs) -> csr_array:
    """Which links run into which loops, shape (links, loops): not zero where they do."""
    pairs = [
        (number, arcs.loop_of_cut[point])
        for number, link in enumerate(arcs.links)
        for point in (link.first, link.last)
        if point in arcs.loop_of_cut
    ]
    rows, columns = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
    shape = len(arcs.links), len(arcs.loops)
    return coo_array((np.ones(len(rows), dtype=np.int64), (rows, columns)), shape=shape).tocsr()


def _loop_name(arcs: Arcs, number: int) -> str:
    """Name of a loop, by the top side on which it was made."""
    loop = arcs.loops[number]
    cuts = {loop.first, loop.last}
    for link in arcs.links:
        for crossing, point in zip(link.ends, (link.first, link.last), strict=True):
            if point in cuts:
                return _named(arcs, crossing)
    return f"the ring that starts in face {arcs.pieces.routes.face_below[arcs.pieces.face[loop.pieces[0]]]}"


def _face_of_link(arcs: Arcs, number: int) -> int:
    """The stitch in which a link begins."""
    return int(arcs.pieces.routes.face_below[arcs.pieces.face[arcs.links[number].pieces[0]]])


def _link_name(arcs: Arcs, number: int) -> str:
    """Name of a link, by the loops that it joins."""
    link: Arc = arcs.links[number]
    names = [_named(arcs, crossing) for crossing, on_needle in zip(link.ends, link.on_needle, strict=True) if on_needle]
    face = _face_of_link(arcs, number)
    return f"face {face}: its yarn at {' and '.join(names)}" if names else f"face {face}: the yarn drawn through it"


def _named(arcs: Arcs, crossing: int) -> str:
    """Name of the loop that was made at a crossing of a top side."""
    side = crossing // SLOTS
    face = int(arcs.whole.side_face[side])
    place = int(arcs.whole.n_bottom[face] + arcs.whole.n_top[face] - arcs.whole.side_place[side])
    return f"loop {place + 1} of face {arcs.pieces.routes.face_below[face]}"
