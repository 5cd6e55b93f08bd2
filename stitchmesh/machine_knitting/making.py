# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Which stitches a V-bed machine makes, and how many needles each takes.

A loop is knit on its own bed, purled on the other one. Loops are stacked by transfers, so every decrease can be made;
an increase is a stitch with yarn-overs, tucked on empty needles beside it: a needle makes one loop at a time, so two
stitches cannot be worked into one loop.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from stitchmesh.errors import ParameterError, first_few
from stitchmesh.hand_knitting.pieces import Piece
from stitchmesh.machine_knitting.program import CARRIERS, MOST_RACK
from stitchmesh.mesh import BORDER, StitchMesh
from stitchmesh.mesh.cable_groups import CableGroup, cable_groups
from stitchmesh.mesh.stitch import VOCABULARY, Stitch

MOST_INCREASE = 1
"""Loops of a stitch that are no yarn-overs."""


def makeable(stitch: Stitch) -> bool:
    """Whether needles can make a stitch anywhere in a row."""
    if stitch == Stitch.CAST_ON:
        return True
    if stitch not in VOCABULARY or stitch == Stitch.WRAP:
        return False
    made = VOCABULARY[stitch].made
    worked = made.replace("y", "")
    return len(worked) <= MOST_INCREASE and (made == "s" or "s" not in made or "y" in made)


def check_makeable(fabric: StitchMesh, pieces: Sequence[Piece]) -> None:
    """Refuse a fabric that a machine cannot make, all that is wrong in one line.

    Raises:
        ParameterError: lists the stitches with their numbers and first faces, and what else cannot be made.
    """
    found = [*_stitches(fabric, pieces), *_marks(fabric), *_shapes(fabric, pieces)]
    if found:
        raise ParameterError(f"knitting machine: cannot make {'; '.join(found)}; change these, or knit them by hand")


def _stitches(fabric: StitchMesh, pieces: Sequence[Piece]) -> list[str]:
    ends = {face for piece in pieces if drawn_together(fabric, piece) for face in piece.rows[-1].faces}
    faces: dict[Stitch, list[int]] = defaultdict(list)
    for face, code in enumerate(fabric.stitch.tolist()):
        if not makeable(Stitch(code)) and face not in ends:
            faces[Stitch(code)].append(face)
    return [
        f"{len(where)} {VOCABULARY[stitch].code if stitch in VOCABULARY else stitch.name.lower()} "
        f"(face {first_few(where)})"
        for stitch, where in faces.items()
    ]


def drawn_together(fabric: StitchMesh, piece: Piece) -> bool:
    """Whether a piece ends in a row whose yarn is drawn through all loops: a machine binds them off instead."""
    return bool((fabric.stitch[list(piece.rows[-1].faces)] == Stitch.DRAW_THROUGH).all())


def _marks(fabric: StitchMesh) -> list[str]:
    found = []
    twisted = fabric.side_face[(fabric.twist != 0) & (fabric.stitch[fabric.side_face] != Stitch.CAST_ON)]
    if len(twisted):
        found.append(f"{len(twisted)} twisted loops (face {first_few(twisted)})")
    wide = [group for group in cable_groups(fabric) if not _within_reach(fabric, group)]
    if wide:
        faces = [int(fabric.side_face[group.sides[0]]) for group in wide]
        found.append(f"{len(wide)} cables (face {first_few(faces)})")
    if fabric.yarn.max() >= CARRIERS:
        found.append(f"{fabric.yarn.max() + 1} yarns, at most {CARRIERS}")
    return found


def _within_reach(fabric: StitchMesh, group: CableGroup) -> bool:
    """Whether the loops of a cable can be racked to their places; the stitches above take one loop each."""
    above = fabric.side_face[fabric.twin[group.sides]]
    moved = np.abs(group.destination - np.arange(len(group.sides))).max()
    single = (fabric.n_bottom[above] == 1) & (fabric.n_top[above] == 1) & (fabric.twin[group.sides] != BORDER)
    return bool(single.all()) and int(moved) <= MOST_RACK // 2


def _shapes(fabric: StitchMesh, pieces: Sequence[Piece]) -> list[str]:
    """Pieces that go on from others, or whose rows do not run over all their loops."""
    found = []
    joined = [piece.rows[0].faces[0] for piece in pieces if piece.sources]
    if joined:
        found.append(f"{len(joined)} pieces that go on from loops of others (face {first_few(joined)})")
    partial = [row.faces[0] for piece in pieces for row in piece.rows if row.left_over or row.bound_off or (
        row.passed and not piece.in_rounds)]  # fmt: skip
    if partial:
        found.append(f"{len(partial)} rows over a part of their loops (face {first_few(partial)})")
    held = [side for piece in pieces for side in piece.needle if fabric.twin[side] != BORDER]
    grafted = fabric.side_face[[side for side in held if fabric.mismatched[side]]]
    if len(grafted):
        found.append(f"{len(grafted)} loops that meet loops (face {first_few(grafted)})")
    return found
