# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Holes are filled, and openings and outlines are not."""

from __future__ import annotations

import math

import numpy as np
import pytest

from stitchmesh.mesh.repair import RepairOptions, repair_mesh
from tests.gallery import grid, torus, tube
from tests.mesh.repair.soups import actions, ring, shape, volume

pytestmark = pytest.mark.decides


def test_a_missing_triangle_is_filled():
    vertices, faces = ring()
    repaired = repair_mesh(vertices, faces[1:])
    assert shape(repaired.mesh) == (240, 480, 0, [])
    assert sorted(repaired.mesh.polygons[-1]) == sorted(faces[0])
    assert [(action.text, action.where) for action in repaired.actions] == [("1 hole was filled", (min(faces[0]),))]


def test_a_missing_quad_is_filled_on_demand():
    mesh = torus(12, 20)
    faces = mesh.polygons[1:]
    assert repair_mesh(mesh.vertices, faces).actions == ()
    around = mesh.side_length[:4].sum()
    filled = repair_mesh(mesh.vertices, faces, RepairOptions(largest_hole=1.01 * around))
    assert shape(filled.mesh) == shape(mesh)
    assert volume(filled.mesh) == pytest.approx(volume(mesh), rel=1e-12)  # The same quad from another corner.
    assert repair_mesh(mesh.vertices, faces, RepairOptions(largest_hole=0.99 * around)).actions == ()


def test_a_larger_hole_is_filled_around_its_centre():
    mesh = tube(10, 6, radius=1.0)
    repaired = repair_mesh(mesh.vertices, mesh.polygons, RepairOptions(largest_hole=7.0))
    assert actions(repaired) == {"filled holes": 2}
    assert shape(repaired.mesh) == (72, 80, 2, [])
    np.testing.assert_allclose(repaired.mesh.vertices[-2:], [[0, 0, 0], [0, 6, 0]], atol=1e-15)  # Means of the rings.
    assert volume(repaired.mesh) > 0.0


@pytest.mark.parametrize("mesh", [grid(1, 1), grid(4, 5), grid(9, 1)], ids=["one face", "sheet", "strip"])
def test_the_outline_of_a_flat_piece_is_no_hole(mesh):
    assert repair_mesh(mesh.vertices, mesh.polygons, RepairOptions(largest_hole=math.inf)).actions == ()


def test_a_hole_of_a_sheet_is_filled_and_its_outline_stays():
    mesh = grid(6, 6)
    faces = [face for number, face in enumerate(mesh.polygons) if number not in (14, 15)]
    repaired = repair_mesh(mesh.vertices, faces, RepairOptions(largest_hole=1e3))
    assert len(repaired.mesh.boundary_loops) == 1
    assert np.linalg.norm(repaired.mesh.face_vector_area, axis=1).sum() == pytest.approx(36.0, rel=1e-12)  # 40 areas.
