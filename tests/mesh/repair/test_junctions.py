# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""T-junctions: a vertex on the border edge of another face."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.mesh import Mesh
from stitchmesh.mesh.repair import RepairOptions, repair_mesh
from tests.gallery import grid
from tests.mesh.repair.soups import actions, shape, unchanged

pytestmark = pytest.mark.decides


def test_a_vertex_on_the_side_of_a_triangle_divides_it_into_triangles():
    vertices = [[0, 0, 0], [2, 0, 0], [1, 2, 0], [1, 0, 0], [1, -2, 0]]
    repaired = repair_mesh(vertices, [[0, 1, 2], [3, 0, 4], [1, 3, 4]])
    one, two, *rest = repaired.mesh.polygons
    assert {frozenset(one), frozenset(two)} == {frozenset({0, 3, 2}), frozenset({3, 1, 2})}
    assert rest == [[3, 0, 4], [1, 3, 4]]
    assert len(repaired.mesh.boundary_loops) == 1
    assert [(action.text, action.where) for action in repaired.actions] == [
        ("1 vertex on a border edge of another face was joined to this edge", (3,))
    ]


def test_rows_of_different_width_are_joined():
    """Wide faces above narrow ones; each wide face gets the corners of the narrow ones."""
    columns = 3
    above, below = grid(2, 1, width=21.0), grid(2 * columns, 1, width=21.0 / columns)
    vertices = np.concatenate([above.vertices, below.vertices - [0.0, 1.0, 0.0]])
    faces = above.polygons + [[v + 6 for v in face] for face in below.polygons]
    repaired = repair_mesh(vertices, faces)
    assert actions(repaired) == {"welded vertices": 3, "T-junctions": 2 * (columns - 1)}
    assert np.diff(repaired.mesh.face_start)[:2].tolist() == [3 + columns, 3 + columns]
    assert len(repaired.mesh.boundary_loops) == 1


def test_edges_that_overlap_in_part_are_joined_where_they_overlap():
    vertices = [[0, 0, 0], [2, 0, 0], [0, 2, 0], [1, 0, 0], [3, 0, 0], [3, -2, 0]]
    repaired = repair_mesh(vertices, [[0, 1, 2], [4, 3, 5]])
    assert shape(repaired.mesh) == (6, 4, 1, [6])


def test_a_vertex_that_only_touches_an_edge_divides_nothing():
    vertices = [[0, 0, 0], [2, 0, 0], [1, 2, 0], [1, 0, 0], [0, -2, 0], [2, -2, 0]]
    assert unchanged(Mesh.from_polygons(vertices, [[0, 1, 2], [3, 4, 5]]))


def test_a_vertex_beside_an_edge_is_joined_up_to_the_weld_distance():
    vertices = [[0, 0, 0], [2, 0, 0], [1, 2, 0], [1, -0.01, 0], [1, -2, 0]]
    faces = [[0, 1, 2], [3, 0, 4], [1, 3, 4]]
    assert actions(repair_mesh(vertices, faces)) == {"shared vertices": 2}
    assert actions(repair_mesh(vertices, faces, RepairOptions(weld_distance=0.02))) == {"T-junctions": 1}
