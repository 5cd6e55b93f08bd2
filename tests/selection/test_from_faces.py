# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Selections that list given faces."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.patterns.swatch_mesh import plain_piece
from stitchmesh.selection import select
from stitchmesh.selection.selection import selection_of_faces

FABRIC = plain_piece(6, 5, 1.0, 0.7)


@pytest.mark.parametrize("seed", range(3))
def test_the_selection_of_faces_selects_these_faces(seed):
    random = np.random.default_rng(seed)
    faces = random.permutation(FABRIC.face_count)[: random.integers(1, FABRIC.face_count)]
    selection = selection_of_faces(faces)
    assert select(FABRIC, selection).tolist() == sorted(faces.tolist())
    assert select(FABRIC, str(selection)).tolist() == sorted(faces.tolist())


def test_neighbouring_numbers_become_spans():
    assert str(selection_of_faces([12, 4, 5, 6, 3, 7, 5])) == "faces 3-7, 12"


def test_no_faces_are_no_selection():
    with pytest.raises(ParameterError, match="selection of faces: got none; expected at least one"):
        selection_of_faces([])
