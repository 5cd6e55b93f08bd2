# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Cloths of stitch meshes: areas and edges at rest, panels by rows, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.labeling import label
from stitchmesh.mesh import BORDER
from stitchmesh.mixed.cloth.from_stitches import cloth_from_stitches, stitch_triangles, triangle_start
from stitchmesh.tessellate import tessellate
from tests.gallery import GARMENTS, grid

WIDTH, HEIGHT = 1.6, 1.2


def garment(name: str):
    from stitchmesh.io import read_mesh

    path = next(path for path in GARMENTS if path.stem == name)
    return tessellate(label(read_mesh(path)), stitch_width=WIDTH)


@pytest.mark.parametrize("name", ["hat", "sock"])
def test_a_garment_becomes_a_cloth_whose_edges_agree_at_rest(name):
    fabric = garment(name)
    cloth = cloth_from_stitches(fabric, stitch_width=WIDTH, course_height=HEIGHT)
    np.testing.assert_array_equal(cloth.vertices, fabric.vertices)
    assert len(cloth.triangles) == (fabric.n_bottom + fabric.n_top).sum()
    length = np.linalg.norm(np.diff(cloth.side_rest, axis=1)[:, 0], axis=1)
    inner = cloth.twin != BORDER
    np.testing.assert_allclose(length[inner], length[cloth.twin[inner]], rtol=1e-12)


def test_the_area_at_rest_is_that_of_the_trapezoids():
    fabric = garment("hat")
    cloth = cloth_from_stitches(fabric, stitch_width=WIDTH, course_height=HEIGHT)
    area = np.add.reduceat(cloth.rest_area, triangle_start(fabric)[:-1])
    lean = (fabric.n_bottom - fabric.n_top) * WIDTH / 2
    expected = (fabric.n_bottom + fabric.n_top) / 2 * WIDTH * np.sqrt(HEIGHT**2 - lean**2)
    np.testing.assert_allclose(area, expected, rtol=1e-12)


def test_triangles_cover_their_face():
    fabric = garment("sock")
    corners = stitch_triangles(fabric)
    start = triangle_start(fabric)
    face = np.repeat(np.arange(fabric.face_count), np.diff(start))
    assert (fabric.side_face[corners] == face[:, None]).all()
    normal = np.cross(*(fabric.corner_position[corners[:, k]] - fabric.corner_position[corners[:, 0]] for k in (1, 2)))
    total = np.add.reduceat(0.5 * normal, start[:-1], axis=0)
    np.testing.assert_allclose(total, fabric.face_vector_area, atol=1e-12)  # the area vector depends on the border only


def test_panels_are_rows_and_x_runs_along_them():
    fabric = tessellate(label(grid(4, 3, width=8.0, height=6.0)), stitch_width=1.0)
    cloth = cloth_from_stitches(fabric, stitch_width=1.0, course_height=0.75)
    assert cloth.panel_names[:2] == ("row 0", "row 1")
    face = np.repeat(np.arange(fabric.face_count), 2)
    assert len(np.unique(fabric.row[face][cloth.panel == 3])) == 1
    assert cloth.rest[..., 0].max() == 32.0 and cloth.rest[..., 1].max() == 0.75
    edge = np.unique(np.round(cloth.rest[cloth.panel == 0][..., 0], 12))
    np.testing.assert_allclose(edge, np.arange(33), atol=1e-12)


def test_diagonals_alternate():
    fabric = tessellate(label(grid(4, 4, width=4.0, height=4.0)), stitch_width=1.0, stitch_height=1.0)
    cloth = cloth_from_stitches(fabric, stitch_width=1.0, course_height=1.0)
    long = np.linalg.norm(np.diff(cloth.side_rest, axis=1)[:, 0], axis=1) > 1.1
    along = np.diff(cloth.side_rest[long], axis=1)[:, 0]
    rises = along[:, 0] * along[:, 1] > 0
    assert np.count_nonzero(rises) * 2 == len(rises)


def test_meshes_and_lengths_that_are_refused():
    labeled = label(grid(2, 2))
    with pytest.raises(ParameterError, match="expected a positive number of cm"):
        cloth_from_stitches(garment("hat"), stitch_width=0.0, course_height=1.0)
    with pytest.raises(ParameterError, match=r"face 0, 1, 2 \(\+1 more\): is no stitch; .* tessellate the mesh first"):
        cloth_from_stitches(labeled, stitch_width=1.0, course_height=1.0)
    with pytest.raises(ParameterError, match="expected a StitchMesh"):
        cloth_from_stitches(grid(2, 2), stitch_width=1.0, course_height=1.0)
