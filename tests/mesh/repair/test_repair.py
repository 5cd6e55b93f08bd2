# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Valid meshes come back unchanged, and meshes cut into soups come back as they were."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import MeshError, ParameterError
from stitchmesh.io import read_mesh
from stitchmesh.mesh import Mesh
from stitchmesh.mesh.repair import RepairOptions, repair_mesh
from tests.gallery import FLAT_AND_ROUND, GARMENTS, shared, torus, two_tubes
from tests.mesh.repair.soups import actions, cut, ring, shape, triangles, unchanged, volume

pytestmark = pytest.mark.decides

SQUARE = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]


@pytest.mark.parametrize("path", GARMENTS[:2], ids=lambda path: path.stem)
def test_garments_come_back_unchanged(path):
    assert unchanged(read_mesh(path))


@pytest.mark.parametrize("make", FLAT_AND_ROUND.values(), ids=FLAT_AND_ROUND)
def test_valid_meshes_come_back_unchanged(make):
    assert unchanged(make())


@pytest.mark.parametrize("path", GARMENTS[:2], ids=lambda path: path.stem)
def test_polygons_cut_apart_are_joined_again(path):
    mesh = read_mesh(path)
    repaired = repair_mesh(*cut(mesh.vertices, mesh.polygons))
    assert shape(repaired.mesh) == shape(mesh)
    assert actions(repaired) == {"welded vertices": mesh.side_count - len(mesh.vertices)}


def test_real_clothes_come_back_unchanged_and_their_triangles_are_joined_again():
    mesh = read_mesh(shared("meshes/makehuman-helper-tights.obj"), unit="dm")
    assert unchanged(mesh)
    whole = Mesh.from_polygons(mesh.vertices, triangles(mesh))
    assert shape(repair_mesh(*cut(mesh.vertices, triangles(mesh))).mesh) == shape(whole)


def damaged(seed: int) -> tuple[np.ndarray, list[list[int]]]:
    """A torus of triangles with every fault that can be repaired without a trace in its shape."""
    rng = np.random.default_rng(seed)
    vertices, faces = ring()
    faces.pop(0)  # A missing triangle.
    vertices, faces = cut(vertices, faces)
    faces += [list(reversed(face)) for face in faces[5:9]]  # Faces that occur twice.
    flipped = rng.random(len(faces)) < 0.3
    faces = [face[::-1] if flip else face for face, flip in zip(faces, flipped, strict=True)]
    speck = len(vertices) + 1 + np.arange(3)  # A vertex without a face, and a very small component.
    vertices = np.concatenate([vertices, [[0, 0, 9]], 1e-4 * np.eye(3)])
    faces += [speck.tolist(), [7, 7, 8], [3, 4]]
    return vertices, [faces[place] for place in rng.permutation(len(faces))]


def test_many_faults_at_once_leave_the_surface_as_it_was():
    repaired = repair_mesh(*damaged(0))
    original = torus(12, 20)
    assert shape(repaired.mesh) == (240, 480, 0, [])
    # The corners of the missing triangle and of all others are the same points.
    points = np.unique(np.round(repaired.mesh.vertices, 9), axis=0)
    np.testing.assert_array_equal(points, np.unique(np.round(original.vertices, 9), axis=0))
    assert volume(repaired.mesh) > 0.0
    found = actions(repaired)
    assert {name: found[name] for name in ("isolated vertices", "duplicate faces", "small components")} == {
        "isolated vertices": 1, "duplicate faces": 4, "small components": 1,
    }  # fmt: skip
    assert found["faces without area"] == 2
    assert found["filled holes"] == 1


def test_a_repaired_mesh_needs_no_repair():
    assert unchanged(repair_mesh(*damaged(0)).mesh)


def test_the_order_of_the_faces_does_not_matter():
    mesh = read_mesh(GARMENTS[0])
    faces = triangles(mesh)
    faces[4] = faces[4][::-1]
    order = np.random.default_rng(5).permutation(len(faces))
    first = repair_mesh(*cut(mesh.vertices, faces))
    second = repair_mesh(*cut(mesh.vertices, [faces[place] for place in order]))
    assert shape(first.mesh) == shape(second.mesh)
    assert actions(first) == actions(second)
    assert len(first.components) == len(second.components)


def test_components_come_with_the_largest_area_first():
    mesh = two_tubes()
    repaired = repair_mesh(mesh.vertices, mesh.polygons)
    areas = [np.linalg.norm(part.face_vector_area, axis=1).sum() for part in repaired.components]
    assert areas == sorted(areas, reverse=True)
    assert sum(part.face_count for part in repaired.components) == mesh.face_count
    assert [len(part.boundary_loops) for part in repaired.components] == [2, 2]


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        ([[0, 0, 0], [1, 0, np.nan], [0, 1, 0]], [[0, 1, 2]], "vertex 1: coordinates are not finite"),
        (SQUARE, [], "got no faces"),
        (SQUARE, [[], []], "got faces without corners"),
        (SQUARE, [[0, 1, 2], [0, 2, 4]], "face 1: vertex 4 does not exist; got 4 vertices"),
        (SQUARE, [[0, 1, 2], [0, 2, -1]], "face 1: vertex -1 does not exist"),
        (SQUARE, [[0, 1, 1], [2, 2, 2]], "none of the 2 faces has an area"),
        ([[0, 0, 0], [1, 1, 1], [2, 2, 2]], [[0, 1, 2]], "none of the 1 faces has an area"),
        ([[5, 5, 5]] * 3, [[0, 1, 2]], "none of the 1 faces has an area"),
        ([[0, 0], [1, 0]], [[0, 1, 0]], r"vertices: got shape \(2, 2\)"),
        ([[0, 0, 0], [1, 0]], [[0, 1, 0]], "vertices: got values that form no array of numbers"),
        (SQUARE, [[0.0, 1.0, 2.5]], "vertex numbers of type float64"),
    ],
)
def test_what_no_repair_can_mend_is_refused(vertices, faces, message):
    with pytest.raises(MeshError, match=message) as caught:
        repair_mesh(vertices, faces)
    assert "\n" not in str(caught.value)


def test_other_options_are_refused():
    with pytest.raises(ParameterError, match=r"repair_mesh: options: got 0.5"):
        repair_mesh(SQUARE, [[0, 1, 2, 3]], 0.5)


@pytest.mark.parametrize("values", [{"weld_distance": -1.0}, {"largest_hole": np.nan}, {"weld_distance": np.inf}])
def test_lengths_that_are_none_are_refused(values):
    with pytest.raises(ParameterError, match=next(iter(values))):
        RepairOptions(**values)
