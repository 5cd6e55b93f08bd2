# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Which loops each link passes through, as the stitches of a fabric name it.

A pass through a loop from the wrong side to the right side counts 1: a loop is run through from its right leg over its
top to its left leg, a link along its yarn. Yarn comes up into a knit loop through each loop that the stitch is worked
on, counting 1, and goes back down from it, counting -1; purl is the reverse; up into a yarn-over, and past a slipped
loop, it passes through none. What is drawn through loops passes through each once, and counts 1 where it runs from
left to right. Of a chain that binds off nothing is told.

A loop that is slipped and twisted on its way up is worked back to front, and passes through it count the other way.

Whether the yarn passes behind or in front of a slipped loop cannot be told from the loop as a whole, as its two legs
cancel. They are counted one by one: how often the yarn goes around each leg, closed in front of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csr_array

from stitchmesh.mesh import BORDER, LEFT, RIGHT, IntArray, StitchMesh
from stitchmesh.mesh.stitch import VOCABULARY, Stitch
from stitchmesh.yarngen.bridges import SLOTS
from stitchmesh.yarngen.loop_check.loops import DRAWN_THROUGH, Arc, Arcs

THREADINGS = {"k": 1, "p": -1, "y": 0, "s": 0}
"""Passes of the yarn that comes up into a loop of each making."""
LEG_TURNS = {Stitch.SLIP_BACK: 1, Stitch.SLIP_FRONT: 0, Stitch.WRAP: 2, Stitch.SY: 1, Stitch.YS: 1}
"""Turns of the yarn around each leg of a loop that is slipped, where it runs from left to right."""


def expected_threadings(arcs: Arcs) -> csr_array:
    """How often each link passes through each loop, shape (links, loops)."""
    rows, columns, values = [], [], []
    for number, link in enumerate(arcs.links):
        for loop, threadings in _threadings_of(arcs, link):
            rows.append(number)
            columns.append(loop)
            values.append(threadings)
    return coo_array((values, (rows, columns)), shape=(len(arcs.links), len(arcs.loops)), dtype=np.int64).tocsr()


def _threadings_of(arcs: Arcs, link: Arc) -> list[tuple[int, int]]:
    """Loops that a link passes through and how often, as each of its ends names them."""
    whole = arcs.whole
    first = link.pieces[0]
    face = int(arcs.pieces.face[first])
    if is_drawn_through(arcs, link):
        rightwards = whole.side_role[link.ends[0] // SLOTS] == LEFT
        return [] if face in arcs.chain_faces else _held_loops(arcs, face, 1 if rightwards else -1)
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
    """The face of a top side, and the passes of the yarn that comes up into the loop made there."""
    whole = arcs.whole
    face = int(whole.side_face[side])
    stitch = Stitch(int(whole.stitch[face]))
    if stitch not in VOCABULARY:
        return face, 0
    place = int(whole.n_bottom[face] + whole.n_top[face] - whole.side_place[side])
    return face, THREADINGS[VOCABULARY[stitch].made[place]]


def _held_loops(arcs: Arcs, face: int, threadings: int) -> list[tuple[int, int]]:
    """The loops on the bottom sides of a face with passes of the same sign, but through those that were turned."""
    first = int(arcs.whole.face_start[face])
    sides = range(first, first + int(arcs.whole.n_bottom[face]))
    return [(arcs.loop_of_side[side], -threadings if side in arcs.reversed_sides else threadings) for side in sides]


@dataclass(frozen=True, eq=False)
class SlippedLegs:
    """The legs of slipped loops."""

    piece: IntArray
    """Piece of each leg, shape (n,)."""
    link: IntArray
    """The link that passes it, shape (n,)."""
    turns: IntArray
    """How often the link goes around it, shape (n,)."""


def slipped_legs(arcs: Arcs) -> SlippedLegs:
    """The legs of slipped loops, and what their stitches say of the links that pass them."""
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
    """Top sides that a link passes beside without making a loop there, in its order, and whether rightwards.

    They are slipped loops, and the loops of another yarn that it floats past.
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
    whole, face = arcs.whole, int(arcs.pieces.face[piece])
    definition = VOCABULARY[Stitch(int(whole.stitch[face]))]
    last = int(whole.n_bottom[face]) + definition.n_top
    start, end = (last - int(whole.side_place[side]) for side in arcs.pieces.ends[piece] // SLOTS)
    start = (
        definition.n_top if start == last - definition.n_bottom else start
    )  # the right wale side lies right of all loops
    end = definition.n_top if end == last - definition.n_bottom else end
    between = range(start + 1, end) if end > start else range(start - 1, end, -1)
    first = int(whole.face_start[face])
    return [(first + last - loop, end > start) for loop in between if definition.made[loop] == "s"]


def _spanned_by_float(whole: StitchMesh, leaving: int, entered: int) -> list[tuple[int, bool]]:
    """Top sides of the faces between two wale sides of one row, walking from the first until the second."""
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
