# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Threadings: which loops each link passes through, as the stitches of a fabric define.

A link threads a loop when it passes through it. A threading counts 1 if the link passes from the wrong side to the
right side, and -1 if it passes back. The loop is directed from its right leg over its top to its left leg, the link
along its yarn. Yarn that leads up into a knit loop threads each loop on which the stitch is worked, counting 1; the
yarn that leads down from the knit loop counts -1. Purl loops have the opposite signs. Yarn that leads up into a
yarn-over, or past a slipped loop, threads no loop. Yarn that is drawn through loops threads each of them once; this
counts 1 where the yarn runs from left to right. In a chain bind-off, the yarn leads up through each loop of the last
row and down again. How the loops of the chain hold each other is not checked.

A loop that is slipped and twisted on its way up is worked in reverse, and its threadings have the opposite sign.

The threadings of a slipped loop do not show whether the yarn passes behind it or in front of it, because its two legs
cancel. Each leg is therefore checked separately: how often the yarn winds around the leg, closed in front of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csr_array

from stitchmesh.mesh import BORDER, LEFT, RIGHT, IntArray, StitchMesh
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.yarngen.bridges import SLOTS
from stitchmesh.yarngen.loop_check.loops import DRAWN_THROUGH, Arc, Arcs

THREADINGS = {"k": 1, "p": -1, "y": 0, "s": 0}
"""Threadings of the yarn that leads up into a loop, by the letter of the loop in the code of its stitch."""
LEG_TURNS = {Stitch.SLIP_BACK: 1, Stitch.SLIP_FRONT: 0, Stitch.WRAP: 2, Stitch.SY: 1, Stitch.YS: 1}
"""Turns of the yarn around each leg of a slipped loop, for yarn that runs from left to right."""


def expected_threadings(arcs: Arcs) -> csr_array:
    """How often each link threads each loop, as the stitches define, shape (links, loops)."""
    rows, columns, values = [], [], []
    for number, link in enumerate(arcs.links):
        for loop, threadings in _threadings_of(arcs, link):
            rows.append(number)
            columns.append(loop)
            values.append(threadings)
    return coo_array((values, (rows, columns)), shape=(len(arcs.links), len(arcs.loops)), dtype=np.int64).tocsr()


def _threadings_of(arcs: Arcs, link: Arc) -> list[tuple[int, int]]:
    """The loops that a link threads, and how often, for each of its two ends."""
    whole = arcs.whole
    first = link.pieces[0]
    face = int(arcs.pieces.face[first])
    if is_drawn_through(arcs, link):
        threadings = arcs.chain_threadings(link)
        if threadings is None:
            threadings = 1 if whole.side_role[link.ends[0] // SLOTS] == LEFT else -1
        return _held_loops(arcs, face, threadings) if threadings else []
    result = []
    for crossing, on_needle, sign in zip(link.ends, link.on_needle, (-1, 1), strict=True):
        face, threadings = threadings_of_made_loop(arcs, crossing // SLOTS) if on_needle else (0, 0)
        if threadings:
            result += _held_loops(arcs, face, sign * threadings)
    return result


def is_drawn_through(arcs: Arcs, link: Arc) -> bool:
    """Whether a link is drawn through loops."""
    return len(link.pieces) == 1 and int(arcs.whole.stitch[arcs.pieces.face[link.pieces[0]]]) in DRAWN_THROUGH


def threadings_of_made_loop(arcs: Arcs, side: int) -> tuple[int, int]:
    """The face of a top side, and the threadings of the yarn that leads up into the loop made there."""
    whole = arcs.whole
    face = int(whole.side_face[side])
    making = whole.makings.get(int(whole.stitch[face]))
    if making is None:
        return face, 0
    place = int(whole.n_bottom[face] + whole.n_top[face] - whole.side_place[side])
    return face, THREADINGS[making.made[place]]


def _held_loops(arcs: Arcs, face: int, threadings: int) -> list[tuple[int, int]]:
    """The loops on the bottom sides of a face, with the given threadings; reversed loops have the opposite sign."""
    first = int(arcs.whole.face_start[face])
    sides = range(first, first + int(arcs.whole.n_bottom[face]))
    return [(arcs.loop_of_side[side], -threadings if side in arcs.reversed_sides else threadings) for side in sides]


@dataclass(frozen=True, eq=False)
class SlippedLegs:
    """The legs of slipped loops."""

    piece: IntArray
    """Piece of each leg, shape (n,)."""
    link: IntArray
    """The link that passes each leg, shape (n,)."""
    turns: IntArray
    """How often the link winds around each leg, shape (n,)."""


def slipped_legs(arcs: Arcs) -> SlippedLegs:
    """The legs of slipped loops, and the turns of the links around them, as the stitches define."""
    pieces, stitch = arcs.pieces, arcs.whole.stitch.tolist()
    passing_links = {}
    for number, link in enumerate(arcs.links):
        for side, rightwards in spanned_sides(arcs, link):
            face = int(arcs.whole.side_face[side])
            if stitch[face] in LEG_TURNS:
                passing_links[face] = number, LEG_TURNS[Stitch(stitch[face])] * (1 if rightwards else -1)
    faces = pieces.face.tolist()
    legs = [
        (piece, *passing_links[faces[piece]])
        for loop in arcs.loops
        for piece in loop.pieces
        if faces[piece] in passing_links
    ]
    columns = np.array(legs, dtype=np.int64).reshape(-1, 3)
    return SlippedLegs(columns[:, 0], columns[:, 1], columns[:, 2])


def spanned_sides(arcs: Arcs, link: Arc) -> list[tuple[int, bool]]:
    """Top sides that a link passes without making a loop there, in its order, and whether it runs to the right.

    They belong to slipped loops, and to loops of another yarn behind which the link floats.
    """
    slips, paths, found = arcs.slipping_pieces, arcs.pieces.routes.bridges.paths, []
    for place, piece in enumerate(link.pieces):
        if piece in slips:
            found += _spanned_by_piece(arcs, piece)
        if place + 1 < len(link.pieces) and arcs.pieces.leaving[piece] in paths:
            entered = int(arcs.pieces.ends[link.pieces[place + 1], 0])
            found += _spanned_by_float(arcs.whole, arcs.pieces.leaving[piece] // SLOTS, entered // SLOTS)
    return found


def _spanned_by_piece(arcs: Arcs, piece: int) -> list[tuple[int, bool]]:
    """The top sides of slipped loops that one piece passes in its face."""
    whole, face = arcs.whole, int(arcs.pieces.face[piece])
    definition = whole.makings[int(whole.stitch[face])]
    last = int(whole.n_bottom[face]) + definition.n_top
    start, end = (last - int(whole.side_place[side]) for side in arcs.pieces.ends[piece] // SLOTS)
    # the right wale side lies to the right of all loops
    start = definition.n_top if start == last - definition.n_bottom else start
    end = definition.n_top if end == last - definition.n_bottom else end
    between = range(start + 1, end) if end > start else range(start - 1, end, -1)
    first = int(whole.face_start[face])
    return [(first + last - loop, end > start) for loop in between if definition.made[loop] == "s"]


def _spanned_by_float(whole: StitchMesh, leaving: int, entered: int) -> list[tuple[int, bool]]:
    """Top sides of the faces between two wale sides of one row, from the first wale side to the second."""
    rightwards = whole.side_role[leaving] == RIGHT
    found, side, begun = [], leaving, leaving
    while whole.twin[side] not in (BORDER, entered) and whole.side_role[side] in (RIGHT, LEFT):
        face = int(whole.side_face[whole.twin[side]])
        first, bottom, top = int(whole.face_start[face]), int(whole.n_bottom[face]), int(whole.n_top[face])
        tops = range(first + bottom + top, first + bottom, -1)
        found += [(place, rightwards) for place in (tops if rightwards else tops[::-1])]
        side = int(whole.right_wale[face] if rightwards else whole.left_wale[face])
        if side == begun:
            return []
    return found if whole.twin[side] == entered else []
