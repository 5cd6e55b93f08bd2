# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A mesh is drawn as its faces, lines along its sides, and crosses; what is not there is not drawn."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.app.scene.drawing import Colours, Lines, Surface
from stitchmesh.app.scene.mesh_drawing import MeshDrawing
from stitchmesh.mesh import Mesh
from tests.app.null_front import NullScene
from tests.gallery import grid, pentagon_row, tube

NONE = np.zeros(0, dtype=np.int64)
MESHES = {"grid": grid(4, 3), "tube": tube(8, 3), "pentagons": pentagon_row()}


@pytest.fixture(params=MESHES)
def mesh(request) -> Mesh:
    return MESHES[request.param]


def test_the_triangles_of_a_face_have_its_colour_and_its_area(mesh):
    scene = NullScene()
    colours = np.stack([np.arange(mesh.face_count)] * 3, axis=1).astype(np.uint8)
    MeshDrawing(scene, mesh).show_faces("faces", colours)
    surface = scene.drawings["faces"]
    assert isinstance(surface, Surface)
    assert isinstance(surface.colours, Colours)
    face = surface.colours.palette[surface.colours.index][:, 0]
    first, second, third = (surface.points[surface.triangles[:, corner]] for corner in range(3))
    areas = np.zeros((mesh.face_count, 3))
    np.add.at(areas, face, np.cross(second - first, third - first) / 2)
    assert areas == pytest.approx(mesh.face_vector_area)


def test_a_cross_has_a_line_to_each_corner(mesh):
    scene, faces = NullScene(), np.array([1, 2])
    MeshDrawing(scene, mesh).show_crosses("crosses", faces, (1, 2, 3), 4.0)
    lines = scene.drawings["crosses"]
    assert isinstance(lines, Lines)
    assert len(lines.segments) == len(mesh.sides_of(faces))
    assert len(np.unique(np.round(lines.segments[:, 0], 9), axis=0)) == 2


def test_the_whole_mesh_is_looked_at_and_what_is_not_there_any_more_is_removed(mesh):
    scene = NullScene()
    drawing = MeshDrawing(scene, mesh)
    drawing.look()
    low, high, _ = scene.shown
    assert (low <= mesh.vertices.min(axis=0)).all() and (high >= mesh.vertices.max(axis=0)).all()
    drawing.show_sides("lines", np.array([0]), (1, 2, 3), 4.0)
    drawing.show_sides("lines", NONE, (1, 2, 3), 4.0)
    drawing.show_crosses("crosses", NONE, (1, 2, 3), 4.0)
    drawing.show_arrowheads("arrows", np.zeros((0, 3, 3)), (1, 2, 3))
    assert scene.drawings == {}
