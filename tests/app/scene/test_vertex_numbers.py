# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Numbers stand at the vertices that face the camera, and follow it around the mesh."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.app.scene.drawing import Labels
from stitchmesh.app.scene.mesh_drawing import VERTEX_NUMBERS, VertexNumbers
from stitchmesh.app.scene.scene import CameraView
from stitchmesh.mesh import Mesh
from tests.app.null_front import NullControls, NullScene
from tests.gallery import grid, tube


def scene_from(position: tuple[float, float, float]) -> NullScene:
    """A scene whose camera is at a place."""
    scene = NullScene()
    scene.views.append(CameraView(np.array(position), np.array([1.0, 0.0, 0.0, 0.0]), 0.6, 1.5))
    return scene


def shown(scene: NullScene, mesh: Mesh) -> list[int]:
    """The vertices whose numbers are shown, each where it stands."""
    labels = scene.drawings[VERTEX_NUMBERS]
    assert isinstance(labels, Labels)
    numbers = [int(text) for text in labels.texts]
    assert labels.points == pytest.approx(mesh.vertices[numbers])
    return numbers


def numbers_on(scene: NullScene, mesh: Mesh, wanted: bool = True) -> tuple[VertexNumbers, NullControls]:
    controls = NullControls()
    numbers = VertexNumbers(scene, controls)
    numbers.show(mesh)
    controls.set("Vertex numbers", wanted)
    return numbers, controls


@pytest.mark.parametrize("z", [50.0, -50.0])
def test_a_flat_piece_is_numbered_from_both_sides(z):
    mesh, scene = grid(4, 3), scene_from((2.0, 1.5, z))
    numbers_on(scene, mesh)
    assert shown(scene, mesh) == list(range(len(mesh.vertices)))


def test_only_the_front_is_numbered_and_the_numbers_follow_a_camera_that_turns():
    mesh, scene = tube(12, 3), scene_from((0.0, 1.5, 50.0))
    numbers, _ = numbers_on(scene, mesh)
    before = scene.drawings[VERTEX_NUMBERS]
    assert (mesh.vertices[shown(scene, mesh), 2] > 0.0).all()
    scene.views[:] = scene_from((1.0, 1.5, 50.0)).views
    numbers.camera_moved()
    assert scene.drawings[VERTEX_NUMBERS] is before
    scene.views[:] = scene_from((0.0, 1.5, -50.0)).views
    numbers.camera_moved()
    assert (mesh.vertices[shown(scene, mesh), 2] < 0.0).all()


def test_numbers_that_are_not_wanted_are_not_drawn():
    scene = scene_from((0.0, 1.5, 50.0))
    numbers, controls = numbers_on(scene, tube(12, 3), wanted=False)
    numbers.camera_moved()
    assert VERTEX_NUMBERS not in scene.drawings
    controls.set("Vertex numbers", True)
    controls.set("Vertex numbers", False)
    numbers.camera_moved()
    assert VERTEX_NUMBERS not in scene.drawings


def test_without_a_browser_all_vertices_are_numbered():
    mesh, scene = tube(12, 3), NullScene()
    numbers_on(scene, mesh)
    assert shown(scene, mesh) == list(range(len(mesh.vertices)))
