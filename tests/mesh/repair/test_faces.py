# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Faces that visit a vertex twice, have no area, cross themselves or occur twice."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.mesh.repair import repair_mesh
from tests.mesh.repair.soups import actions, cut, ring, shape

pytestmark = pytest.mark.decides

SQUARE = np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]], dtype=float)


def test_a_spike_is_left_out():
    repaired = repair_mesh([*SQUARE, [5, 2, 0]], [[0, 1, 2, 4, 2, 3]])
    assert repaired.mesh.polygons == [[0, 1, 2, 3]]


def test_a_polygon_that_touches_itself_becomes_two():
    """The two parts then meet in one vertex, which is split."""
    vertices = [[0, 0, 0], [-1, 1, 0], [-1, -1, 0], [1, -1, 0], [1, 1, 0]]
    repaired = repair_mesh(vertices, [[0, 1, 2, 0, 3, 4]])
    assert repaired.mesh.face_count == 2
    assert len(repaired.components) == 2


def test_a_face_with_a_hole_keeps_its_hole():
    """A program without holes in faces goes along a bridge to the inner border, around it, and back."""
    inner = np.array([[0.5, 0.5, 0], [1.5, 0.5, 0], [1.5, 1.5, 0], [0.5, 1.5, 0]])
    repaired = repair_mesh(np.concatenate([SQUARE, inner]), [[0, 1, 2, 3, 0, 4, 7, 6, 5, 4]])
    assert sorted(len(loop) for loop in repaired.mesh.boundary_loops) == [4, 4]
    total = np.linalg.norm(repaired.mesh.face_vector_area, axis=1).sum()
    assert total == pytest.approx(3.0, rel=1e-12)  # A sum of eight areas.


def test_a_sliver_leaves_no_crack():
    """A triangle whose middle corner lies on its long side: the neighbour there is divided at this corner."""
    vertices, faces = ring()
    a, b, _ = faces[0]
    middle = len(vertices)
    vertices = np.concatenate([vertices, [(vertices[a] + vertices[b]) / 2]])
    across = next(n for n, face in enumerate(faces) if n and {a, b} <= set(face))
    place = faces[across].index(b)
    d = faces[across][(place + 2) % 3]
    # The side a-b of the first face stays whole, its neighbour is divided, and the sliver lies between.
    faces[across : across + 1] = [[b, middle, d], [middle, a, d]]
    faces.append([b, a, middle])
    for soup in ((vertices, faces), cut(vertices, faces)):
        repaired = repair_mesh(*soup)
        assert shape(repaired.mesh) == (241, 482, 0, [])
        found = actions(repaired)
        assert (found["faces without area"], found["T-junctions"]) == (1, 1)


def test_a_needle_with_a_side_without_length_leaves_no_crack():
    vertices, faces = ring()
    a, b, _ = faces[0]
    vertices = np.concatenate([vertices, vertices[[a]]])
    twin = len(vertices) - 1
    across = next(n for n, face in enumerate(faces) if n and {a, b} <= set(face))
    faces[across] = [twin if vertex == a else vertex for vertex in faces[across]]
    faces.append([b, a, twin])
    repaired = repair_mesh(vertices, faces)
    assert shape(repaired.mesh) == (240, 480, 0, [])


def test_a_polygon_that_crosses_itself_is_divided():
    repaired = repair_mesh([*SQUARE, [4, 0, 0], [4, 2, 0]], [[0, 1, 3, 2], [1, 4, 5, 2]])
    assert actions(repaired)["folded faces"] == 1
    assert repaired.mesh.face_count == 3


def test_the_first_of_equal_faces_stays():
    vertices, faces = ring()
    repaired = repair_mesh(vertices, [*faces, faces[3], faces[3][::-1], faces[9]])
    assert repaired.mesh.polygons == faces
    assert [(action.text, action.where) for action in repaired.actions] == [
        ("3 faces with the same vertices as other faces were removed", (480, 481, 482))
    ]
