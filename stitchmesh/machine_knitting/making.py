# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Check whether a V-bed knitting machine can make a fabric.

A machine makes a knit stitch on the bed that holds the loop, and a purl stitch on the other bed. It can make every
decrease, because transfers can stack loops on one needle. It makes an increase as a stitch with yarn-overs, which are
tucks on empty needles beside the stitch. The tuck of a make one, a yarn-over with crossed legs, runs against the
direction of the row, so that the yarn crosses itself below the hook. The program does not choose which leg lies in
front. It cannot work two stitches into one loop, because a needle makes one loop at a time.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from stitchmesh.errors import ParameterError, first_few
from stitchmesh.hand_knitting.pieces import Piece
from stitchmesh.hand_knitting.words import stitch_name
from stitchmesh.machine_knitting.program import CARRIERS, MOST_RACK
from stitchmesh.mesh import BORDER, StitchMesh
from stitchmesh.mesh.cable_groups import CableGroup, cable_groups
from stitchmesh.mesh.own_stitch import FIRST_OWN
from stitchmesh.mesh.stitch import VOCABULARY, Stitch


def makeable(stitch: Stitch) -> bool:
    """Return whether a machine can make a stitch at any place in a row."""
    if stitch == Stitch.CAST_ON:
        return True
    if stitch not in VOCABULARY or stitch == Stitch.WRAP:
        return False
    made = VOCABULARY[stitch].made
    worked = made.replace("y", "")
    # Largest number of loops on top of a stitch that are not yarn-overs.
    return len(worked) <= 1 and (made == "s" or "s" not in made or "y" in made)


def check_makeable(fabric: StitchMesh, pieces: Sequence[Piece]) -> None:
    """Check that a machine can make a fabric.

    Args:
        fabric: stitch mesh.
        pieces: pieces of the fabric (``find_pieces``).

    Raises:
        ParameterError: a machine cannot make some stitches, loops or shapes; the message lists all of them with their
            counts and first faces.
    """
    found = [*_stitches(fabric, pieces), *_marks(fabric), *_shapes(fabric, pieces)]
    if found:
        raise ParameterError(f"knitting machine: cannot make {'; '.join(found)}; change these, or knit them by hand")


def _stitches(fabric: StitchMesh, pieces: Sequence[Piece]) -> list[str]:
    """Names of the stitches that cannot be made, with their counts and first faces."""
    ends = {face for piece in pieces if drawn_together(fabric, piece) for face in piece.rows[-1].faces}
    faces: dict[int, list[int]] = defaultdict(list)
    for face, code in enumerate(fabric.stitch.tolist()):
        if (code >= FIRST_OWN or not makeable(Stitch(code))) and face not in ends:
            faces[code].append(face)
    names = {code: stitch_name(fabric.stitch_type(code)) for code in faces}
    return [f"{len(where)} {names[code]} (face {first_few(where)})" for code, where in faces.items()]


def drawn_together(fabric: StitchMesh, piece: Piece) -> bool:
    """Return whether the yarn of the last row of a piece is drawn through all loops.

    A machine binds these loops off instead.
    """
    return bool((fabric.stitch[list(piece.rows[-1].faces)] == Stitch.DRAW_THROUGH).all())


def _marks(fabric: StitchMesh) -> list[str]:
    """Twisted loops, wide cables and surplus yarns that cannot be made."""
    found = []
    twisted = [side for side in np.flatnonzero(fabric.twist) if letter_made(fabric, int(side)) != "y"]
    if twisted:
        found.append(f"{len(twisted)} twisted loops (face {first_few(fabric.side_face[twisted])})")
    wide = [group for group in cable_groups(fabric) if not _within_reach(fabric, group)]
    if wide:
        faces = [int(fabric.side_face[group.sides[0]]) for group in wide]
        found.append(f"{len(wide)} cables (face {first_few(faces)})")
    if fabric.yarn.max() >= CARRIERS:
        found.append(f"{fabric.yarn.max() + 1} yarns, at most {CARRIERS}")
    return found


def letter_made(fabric: StitchMesh, side: int) -> str:
    """Return the kind of the loop at a top side (``Making.made``); loops that are cast on are yarn-overs."""
    face = int(fabric.side_face[side])
    making = fabric.makings.get(int(fabric.stitch[face]))
    return making.made[int(fabric.left_wale[face]) - 1 - side] if making else "y"


def _within_reach(fabric: StitchMesh, group: CableGroup) -> bool:
    """Whether racking can move the loops of a cable to their places, and each stitch above takes one loop."""
    above = fabric.side_face[fabric.twin[group.sides]]
    moved = np.abs(group.destination - np.arange(len(group.sides))).max()
    single = (fabric.n_bottom[above] == 1) & (fabric.n_top[above] == 1) & (fabric.twin[group.sides] != BORDER)
    return bool(single.all()) and int(moved) <= MOST_RACK // 2


def _shapes(fabric: StitchMesh, pieces: Sequence[Piece]) -> list[str]:
    """Pieces that start from loops of other pieces, and rows that do not work all loops of their piece."""
    found = []
    joined = [piece.rows[0].faces[0] for piece in pieces if piece.sources]
    if joined:
        found.append(f"{len(joined)} pieces that start from loops of other pieces (face {first_few(joined)})")
    partial = [row.faces[0] for piece in pieces for row in piece.rows if row.left_over or row.bound_off or (
        row.passed and not piece.in_rounds)]  # fmt: skip
    if partial:
        found.append(f"{len(partial)} rows that work only a part of their loops (face {first_few(partial)})")
    held = [side for piece in pieces for side in piece.needle if fabric.twin[side] != BORDER]
    grafted = fabric.side_face[[side for side in held if fabric.mismatched[side]]]
    if len(grafted):
        found.append(f"{len(grafted)} loops that are grafted to loops (face {first_few(grafted)})")
    return found
