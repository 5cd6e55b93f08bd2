# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The outline of faces is their border."""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import BORDER
from stitchmesh.mesh.polygon_mesh import outline_sides
from tests.gallery import grid, torus, tube


def test_the_outline_of_all_faces_is_the_border_of_the_mesh():
    for mesh in (grid(4, 3), tube(8, 3), torus(6, 8)):
        assert outline_sides(mesh, np.arange(mesh.face_count)).tolist() == np.flatnonzero(mesh.twin == BORDER).tolist()


def test_the_outline_of_a_block_is_as_long_as_its_perimeter():
    mesh = grid(5, 4)
    block = np.array([row * 5 + column for row in (1, 2) for column in (1, 2, 3)])
    outline = outline_sides(mesh, block)
    assert mesh.side_length[outline].sum() == 2 * (3 + 2)
    assert set(mesh.side_face[outline].tolist()) <= set(block.tolist())


