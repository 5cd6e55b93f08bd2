# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The mesh of a garment is read from files in which it lies."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from pxr import Usd, UsdGeom

from stitchmesh.errors import ParameterError
from stitchmesh.io.garments import LYING, UNSURE, read_body, read_garment
from stitchmesh.io.mesh_reading import MeshReading
from stitchmesh.io.meshes import read_mesh, write_mesh
from stitchmesh.mesh.upright import Y, Z, upright_turn
from tests.gallery import ROOT, torus, tube
from tests.mesh.test_layers import with_thickness

SKIRT = tube(12, 4, radius=18.0, height=5.0)
"""A tube of 36 x 20 x 36 cm whose axis is y."""
LYING_SKIRT = replace(SKIRT, vertices=SKIRT.vertices @ upright_turn(Z))
"""The same tube, whose axis is z."""


def test_a_lying_mesh_stands_and_it_is_said(tmp_path):
    write_mesh(tmp_path / "skirt.ply", LYING_SKIRT)
    found = read_garment(tmp_path / "skirt.ply", MeshReading(), repaired=False)
    np.testing.assert_array_equal(found.mesh.vertices, SKIRT.vertices)
    assert (found.up, found.notes) == (Z, (LYING,))
    kept = read_garment(tmp_path / "skirt.ply", MeshReading(up=Y), repaired=False)
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


def scene(path, *objects):
    """Write named meshes into one OBJ file."""
    lines, count = [], 0
    for name, mesh in objects:
        lines += [f"o {name}", *(f"v {x!r} {y!r} {z!r}" for x, y, z in mesh.vertices.tolist())]
        lines += ["f " + " ".join(str(corner + 1 + count) for corner in face) for face in mesh.polygons]
        count += len(mesh.vertices)
    path.write_text("\n".join(lines) + "\n")
    return path


BODY = torus(12, 8)
"""A closed mesh, in the place of a body."""


@pytest.mark.parametrize("repaired", [False, True])
def test_a_body_beside_a_garment_is_left_out_unless_it_is_chosen(tmp_path, repaired):
    path = scene(tmp_path / "scene.obj", ("body", BODY), ("skirt", SKIRT))
    found = read_garment(path, MeshReading(), repaired=repaired)
    np.testing.assert_array_equal(found.mesh.vertices, SKIRT.vertices)
    assert found.objects == ("body", "skirt") and found.repairs in (None, ())
    (note,) = found.notes
    assert note.startswith("the file holds body, skirt; body was left out, because it is closed") and "--object" in note
    chosen = read_garment(path, MeshReading(objects=("body",)), repaired=repaired)
    assert chosen.mesh.face_count == BODY.face_count


def test_objects_that_can_all_be_garments_are_read_together_and_one_alone_by_its_name(tmp_path):
    path = scene(tmp_path / "scene.obj", ("skirt", SKIRT), ("hat", replace(SKIRT, vertices=SKIRT.vertices + 50.0)))
    together = read_garment(path, MeshReading(), repaired=False)
    assert together.mesh.face_count == 2 * SKIRT.face_count
    (note,) = together.notes
    assert note == "the file holds skirt, hat, which are knitted together; --object 'skirt' knits one alone"
    assert read_garment(path, MeshReading(objects=("hat",)), repaired=False).mesh.face_count == SKIRT.face_count
    with pytest.raises(ParameterError, match=r"object 'shirt': .* expected one of skirt, hat"):
        read_garment(path, MeshReading(objects=("shirt",)), repaired=False)


def test_parts_without_names_are_numbered(tmp_path):
    path = scene(tmp_path / "scene.obj", ("body", BODY), ("skirt", SKIRT))
    write_mesh(tmp_path / "scene.off", read_mesh(path))
    found = read_garment(tmp_path / "scene.off", MeshReading(), repaired=False)
    assert found.objects == ("part 1", "part 2") and found.mesh.face_count == SKIRT.face_count
    first = read_garment(tmp_path / "scene.off", MeshReading(objects=("part 1",)), repaired=False)
    assert first.mesh.face_count == BODY.face_count


def test_nodes_of_gltf_are_objects(tmp_path):
    built = trimesh.Scene()
    for name, mesh in (("body", BODY), ("skirt", SKIRT)):
        quads = mesh.face_vertex.reshape(-1, 4)
        triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
        part = trimesh.Trimesh(mesh.vertices / 100.0, triangles, process=False)
        built.add_geometry(part, node_name=name, geom_name=f"mesh of {name}")
    path = tmp_path / "model.gltf"
    for name, content in built.export(file_type="gltf").items():
        (tmp_path / name).write_bytes(content)
    found = read_garment(path, MeshReading(), repaired=False)
    assert found.objects == ("body", "skirt") and found.mesh.face_count == 2 * SKIRT.face_count
    by_mesh = read_garment(path, MeshReading(objects=("mesh of body",)), repaired=False)
    assert by_mesh.mesh.face_count == 2 * BODY.face_count


def test_prims_of_usd_are_objects_and_those_around_them_are_groups(tmp_path):
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    for place, mesh in (("/scene/wearer/body", BODY), ("/scene/skirt", SKIRT)):
        prim = UsdGeom.Mesh.Define(stage, place)
        prim.CreatePointsAttr(mesh.vertices.tolist())
        prim.CreateFaceVertexCountsAttr([4] * mesh.face_count)
        prim.CreateFaceVertexIndicesAttr(mesh.face_vertex.tolist())
    path = tmp_path / "scene.usda"
    stage.GetRootLayer().Export(str(path))
    found = read_garment(path, MeshReading(), repaired=False)
    assert found.objects == ("body", "skirt") and found.mesh.face_count == SKIRT.face_count
    wearer = read_garment(path, MeshReading(objects=("wearer",)), repaired=False)
    assert wearer.mesh.face_count == BODY.face_count


def test_one_layer_of_a_garment_with_a_thickness_is_read(tmp_path):
    skirt = with_thickness(tube(32, 4, radius=18.0, height=5.0), 0.5)
    path = scene(tmp_path / "scene.obj", ("body", BODY), ("skirt", skirt))
    found = read_garment(path, MeshReading(layer="middle"), repaired=False)
    # the middle layer is moved by half of the thickness between faces, which is 0.5 % smaller than between vertices
    np.testing.assert_allclose(np.ptp(found.mesh.vertices, axis=0), [35.5, 20.0, 35.5], atol=0.005)
    assert found.has_layers and len(found.mesh.boundary_loops) == 2
    assert "two layers 0.5 cm apart, of which the middle one is knitted" in found.notes[1]
