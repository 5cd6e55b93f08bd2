# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The mean winding number of surfaces, and meshes that are turned inside out."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.io import read_mesh
from stitchmesh.mesh import Mesh
from stitchmesh.mesh.orientation import INSIDE_OUT, is_inside_out, mean_winding_number, turn_inside_out
from tests.gallery import GARMENTS, grid, shared

pytestmark = pytest.mark.decides


def arc(degrees: float) -> Mesh:
    """A long part of a tube that goes round by an angle, with outward normals."""
    flat = grid(24, 40, width=1.0 / 24, height=0.5)
    angle = np.radians(degrees) * flat.vertices[:, 0]
    return Mesh(
        np.stack([np.sin(angle), flat.vertices[:, 1], np.cos(angle)], axis=1),
        flat.face_start, flat.face_vertex, flat.twin,
    )  # fmt: skip


@pytest.mark.parametrize("degrees", [60, 270])
def test_a_part_of_a_tube_has_its_angle_over_four_pi(degrees):
    """By the inscribed angle theorem, if the tube is long; the ends of this one take up to a tenth."""
    assert mean_winding_number(arc(degrees)) == pytest.approx(np.radians(degrees) / (4 * np.pi), rel=0.1)


@pytest.mark.parametrize("path", [path for path in GARMENTS if path.stem in ("sweater", "poncho", "swatch")])
def test_no_garment_is_called_inside_out_and_each_turned_one_is(path):
    mesh = read_mesh(path)
    assert not is_inside_out(mesh)
    assert mean_winding_number(turn_inside_out(mesh)) == pytest.approx(-mean_winding_number(mesh), abs=1e-9)
    assert is_inside_out(turn_inside_out(mesh)) == (path.stem != "swatch")


def test_real_clothes_are_the_right_side_out():
    assert mean_winding_number(read_mesh(shared("meshes/makehuman-helper-tights.obj"), unit="dm")) > -INSIDE_OUT
