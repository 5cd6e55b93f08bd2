# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The direction of a mesh that points up is found by its openings, and becomes y."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.io import read_mesh
from stitchmesh.mesh.upright import Y, Z, turned_upright, up_of_openings, upright_turn
from tests.gallery import ROOT, grid


def lying(mesh):
    """The mesh as a program writes it in whose files z is up."""
    return replace(mesh, vertices=mesh.vertices @ upright_turn(Z))


def test_z_becomes_y_as_between_the_axes_of_blender_and_of_gltf():
    """glTF's x, y, z are Blender's x, z, -y; the numbers are exact."""
    assert (upright_turn(Z) @ [1.0, 2.0, 3.0]).tolist() == [1.0, 3.0, -2.0]
    assert (upright_turn(Y) == np.eye(3)).all()


@pytest.mark.parametrize("up", [Z, (0.0, -2.0, 0.0), (0.3, -0.5, 0.7), (1e-9, -1.0, 0.0)])
def test_each_direction_becomes_y_by_a_rotation(up):
    turn = upright_turn(up)
    # some roundings of numbers of size 1
    np.testing.assert_allclose(turn @ (np.array(up) / np.linalg.norm(up)), Y, atol=1e-14)
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-14)
    assert np.linalg.det(turn) > 0.0


@pytest.mark.parametrize("up", [(0.0, 0.0, 0.0), (np.nan, 0.0, 1.0)])
def test_no_direction_is_refused(up):
    with pytest.raises(ParameterError, match="expected three finite numbers that are not all zero"):
        upright_turn(up)


@pytest.mark.parametrize("name", ["sweater", "glove", "sock"])
def test_garments_stand_by_their_openings(name):
    mesh = read_mesh(ROOT / "assets" / "meshes" / f"{name}.obj")
    assert up_of_openings(mesh) == Y and up_of_openings(lying(mesh)) == Z
    np.testing.assert_array_equal(turned_upright(lying(mesh), Z).vertices, mesh.vertices)


def test_what_has_no_opening_or_openings_on_all_sides_is_left_as_it_lies():
    assert up_of_openings(grid(4, 4)) == Y and up_of_openings(lying(grid(4, 4))) == Y
    assert up_of_openings(read_mesh(ROOT / "assets" / "meshes" / "sheep.obj")) is None
