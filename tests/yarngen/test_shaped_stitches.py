# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A decrease has as much yarn as plain stitches: a knitter works the same length into every loop."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh import generate_yarns
from stitchmesh.editing.edit import Edit, apply_edit
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.yarn import YarnSet
from stitchmesh.yarngen.edge_tension import HELD
from tests.editing.fabrics import face_at, flat


def yarn_in_face(yarns: YarnSet, face: int) -> float:
    """Rest length of the yarn in a face [cm]."""
    return float(yarns.rest_length[yarns.face[yarns.segment_points[:, 1]] == face].sum())


def shaped() -> tuple[StitchMesh, int]:
    """A flat piece in which one column begins in an increase and ends in a decrease."""
    fabric = flat(9, 8)
    side = int(fabric.left_wale[face_at(fabric, 3, 4)])
    made = apply_edit(fabric, Edit("insert_wale", {"side": side, "courses": 2})).fabric
    (decrease,) = np.flatnonzero((made.n_bottom == 2) & (made.n_top == 1))
    return made, int(decrease)


def test_a_decrease_has_the_yarn_of_two_heads_and_one_loop():
    """A plain face holds a head and its own feet and legs; a decrease has one head more."""
    fabric, decrease = shaped()
    yarns = generate_yarns(fabric, quality="standard")
    plain = face_at(fabric, 1, 1)
    loop = yarn_in_face(yarns, plain)
    drawn = yarns.lengths[yarns.face[yarns.segment_points[:, 1]] == decrease].sum()
    # A head is about half of a loop. Stitches of the row of the decrease are wider or narrower by a tenth.
    assert yarn_in_face(yarns, decrease) == pytest.approx(HELD * 1.5 * loop, rel=0.15)
    assert drawn > 1.2 * yarn_in_face(yarns, decrease)


def test_plain_stitches_keep_their_drawn_length():
    fabric, decrease = shaped()
    yarns = generate_yarns(fabric, quality="standard")
    beside = np.unique(fabric.side_face[fabric.twin[fabric.sides_of(np.array([decrease]))]])
    edges = np.flatnonzero(np.isin(fabric.row, [fabric.row.min(), fabric.row.max()]))  # Edges are worked with tension.
    near = [decrease, *beside, *edges, *np.flatnonzero(fabric.n_top > 1)]
    far = ~np.isin(yarns.face[yarns.segment_points], near).any(axis=1)
    np.testing.assert_array_equal(yarns.rest_length[far], yarns.lengths[far])
    assert fabric.stitch[decrease] in (Stitch.D12K, Stitch.D21K)
