# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The mesh of a garment is read from files in which it lies."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.io.garments import LYING, UNSURE, MeshReading, read_body, read_garment
from stitchmesh.io.meshes import read_mesh, write_mesh
from stitchmesh.mesh.upright import Y, Z, upright_turn
from tests.gallery import ROOT, tube

SKIRT = tube(12, 4, radius=18.0, height=5.0)
"""A tube of 36 x 20 x 36 cm whose axis is y."""
LYING_SKIRT = replace(SKIRT, vertices=SKIRT.vertices @ upright_turn(Z))
"""The same tube, whose axis is z."""


@pytest.mark.parametrize("repaired", [False, True])
def test_a_lying_mesh_stands_and_it_is_said(tmp_path, repaired):
    write_mesh(tmp_path / "skirt.ply", LYING_SKIRT)
    found = read_garment(tmp_path / "skirt.ply", MeshReading(), repaired=repaired)
    np.testing.assert_array_equal(found.mesh.vertices, SKIRT.vertices)
    assert (found.up, found.notes) == (Z, (LYING,))
    kept = read_garment(tmp_path / "skirt.ply", MeshReading(up=Y), repaired=repaired)
    np.testing.assert_array_equal(kept.mesh.vertices, LYING_SKIRT.vertices)
    assert (kept.up, kept.notes) == (Y, ())


def test_a_mesh_that_does_not_tell_is_left_as_it_lies_and_it_is_said():
    found = read_garment(ROOT / "assets" / "meshes" / "sheep.obj", MeshReading(), repaired=False)
    assert (found.up, found.notes) == (Y, (UNSURE,))


def test_gltf_states_what_is_up_and_the_caller_can_say_another_direction(tmp_path):
    write_mesh(tmp_path / "skirt.glb", LYING_SKIRT)
    assert read_garment(tmp_path / "skirt.glb", MeshReading(), repaired=False).up == Y
    assert read_garment(tmp_path / "skirt.glb", MeshReading(up=Z), repaired=False).up == Z


def test_an_export_lands_on_the_mesh_in_blender(tmp_path):
    """Blender reads numbers of a file with z up as they are, and turns glTF's x, y, z to x, -z, y."""
    write_mesh(tmp_path / "skirt.obj", LYING_SKIRT, unit="m")
    in_blender = read_mesh(tmp_path / "skirt.obj").vertices
    write_mesh(tmp_path / "skirt.glb", read_garment(tmp_path / "skirt.obj", MeshReading(unit="m"), repaired=False).mesh)
    x, y, z = read_mesh(tmp_path / "skirt.glb").vertices.T / 100.0
    # glTF has triangles, whose corners are merged in the order of their first faces, and float32
    landed = np.array(sorted(np.stack([x, -z, y], axis=1).round(5).tolist()))
    np.testing.assert_allclose(landed, sorted(in_blender.round(5).tolist()), atol=2e-5)


def test_a_body_stands_as_its_garment_unless_its_format_says_it(tmp_path):
    write_mesh(tmp_path / "body.obj", LYING_SKIRT)
    write_mesh(tmp_path / "body.glb", SKIRT)
    np.testing.assert_array_equal(read_body(tmp_path / "body.obj", unit="cm", up=Z).vertices, SKIRT.vertices)
    stated = read_body(tmp_path / "body.glb", unit="cm", up=Z)
    np.testing.assert_allclose(np.ptp(stated.vertices, axis=0), [36.0, 20.0, 36.0], rtol=1e-6)  # float32
