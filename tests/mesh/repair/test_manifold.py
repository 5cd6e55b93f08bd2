# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Edges with more than two faces, vertices in which parts meet, and directions of faces."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import MeshError
from stitchmesh.mesh import BORDER, Mesh
from stitchmesh.mesh.orientation import turn_inside_out
from stitchmesh.mesh.repair import repair_mesh
from tests.gallery import grid, moebius, torus, tube
from tests.mesh.repair.soups import actions, cut, ring, same, shape, unchanged, volume

pytestmark = pytest.mark.decides


def book(degrees: list[float]) -> tuple[np.ndarray, list[list[int]]]:
    """Square pages along one edge from 0 to 1, at angles around it."""
    angle = np.radians(degrees)
    ends = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    pages = [[x, y, z] for x, y in ends.tolist() for z in (1.0, 0.0)]
    faces = [[0, 1, 2 + 2 * page, 3 + 2 * page] for page in range(len(degrees))]
    return np.array([[0, 0, 0], [0, 0, 1.0], *pages]), faces


def test_a_book_of_three_pages_becomes_a_flat_sheet_and_a_page():
    vertices, faces = book([0, 70, 180])
    repaired = repair_mesh(vertices, [faces[0], faces[1], faces[2][::-1]])
    assert [part.face_count for part in repaired.components] == [2, 1]
    np.testing.assert_allclose(repaired.components[0].vertices[:, 1], 0.0, atol=1e-15)  # Rounding of the sine.
    assert [(action.text, action.where) for action in repaired.actions] == [
        ("1 edge with more than two faces was split", ((0, 1),))
    ]
    assert len(repaired.mesh.vertices) == len(vertices) + 2


@pytest.mark.parametrize("count", [4, 9])
def test_a_book_of_any_number_of_pages_becomes_manifold(count):
    rng = np.random.default_rng(count)
    vertices, faces = book(np.sort(rng.uniform(0, 360, count)).tolist())
    repaired = repair_mesh(*cut(vertices, [face[::-1] if rng.random() < 0.5 else face for face in faces]))
    assert sorted(part.face_count for part in repaired.components) == [1] * (count % 2) + [2] * (count // 2)


def test_cubes_that_share_an_edge_stay_closed():
    box = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    vertices = np.concatenate([box, box + np.array([1.0, 1.0, 0.0])])
    both = faces + [[v + 8 for v in face] for face in faces]
    for order in (range(12), range(11, -1, -1)):
        repaired = repair_mesh(*cut(vertices, [both[place] for place in order]))
        assert [shape(part) for part in repaired.components] == [(8, 6, 2, [])] * 2
        assert volume(repaired.mesh) == pytest.approx(2.0, rel=1e-12)  # A sum of twelve volumes.


def test_a_pocket_leaves_the_garment_whole():
    """A patch whose upper edge is an edge of the sheet, which stays one component with one border."""
    sheet = grid(6, 6)
    patch = (
        grid(2, 2).vertices * [1.0, -0.5, 0.0]
        + [2.0, 4.0, 0.0]
        + np.repeat([[0, 0, 0], [0, 0, 0.5], [0, 0, 0.7]], 3, 0)
    )
    faces = sheet.polygons + [[v + 49 for v in face] for face in grid(2, 2).polygons]
    repaired = repair_mesh(*cut(np.concatenate([sheet.vertices, patch]), faces))
    assert [shape(part) for part in repaired.components] == [shape(sheet), shape(grid(2, 2))]
    assert actions(repaired)["crowded edges"] == 2


def test_parts_that_meet_in_a_vertex_are_separated():
    vertices = [[0, 0, 0], [1, 1, 0], [-1, 1, 0], [1, -1, 0], [-1, -1, 0]]
    repaired = repair_mesh(vertices, [[0, 1, 2], [0, 4, 3]])
    assert [(action.text, action.where) for action in repaired.actions] == [
        ("1 vertex in which separate parts of the surface met was split", (0,))
    ]
    np.testing.assert_array_equal(repaired.mesh.vertices, [*vertices, [0, 0, 0]])
    assert repaired.mesh.polygons == [[0, 1, 2], [5, 4, 3]]


def test_faces_of_the_wrong_direction_are_reversed():
    turned = range(0, 480, 3)
    vertices, faces = ring()
    repaired = repair_mesh(vertices, [face[::-1] if n in turned else face for n, face in enumerate(faces)])
    assert actions(repaired) == {"reversed faces": len(turned)}
    original = Mesh.from_polygons(vertices, faces)
    np.testing.assert_array_equal(repaired.mesh.twin == BORDER, original.twin == BORDER)
    # The same planes in another order of the sums.
    np.testing.assert_allclose(repaired.mesh.face_vector_area, original.face_vector_area, atol=1e-14)


@pytest.mark.parametrize("mesh", [torus(8, 12), tube(12, 8)], ids=["closed", "open"])
def test_a_surface_that_is_inside_out_is_turned(mesh):
    repaired = repair_mesh(mesh.vertices, turn_inside_out(mesh).polygons)
    assert actions(repaired) == {"turned components": 1}
    assert same(repaired.mesh, mesh)


def test_each_component_is_turned_by_itself():
    inner, outer = torus(8, 12), torus(8, 12)
    faces = turn_inside_out(inner).polygons + [[v + 96 for v in face] for face in outer.polygons]
    repaired = repair_mesh(np.concatenate([inner.vertices, outer.vertices + np.array([20.0, 0.0, 0.0])]), faces)
    assert actions(repaired) == {"turned components": 1}
    assert all(volume(part) > 0.0 for part in repaired.components)


def test_a_moebius_strip_is_refused():
    vertices, faces = moebius()
    with pytest.raises(MeshError, match=r"edge \d+-\d+: the surface has one side only .*cut it along an edge loop"):
        repair_mesh(*cut(vertices, faces))


def test_a_moebius_strip_that_was_cut_open_is_left_alone():
    """A weld of the two ends would undo what the message of the refusal asks for."""
    vertices, faces = moebius()
    ends = np.concatenate([vertices, vertices[[0, 8]]])
    assert unchanged(Mesh.from_polygons(ends, [*faces[:-1], [7, 17, 16, 15]]))
