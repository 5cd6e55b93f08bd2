# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What a project starts from: the mesh as it is labeled, and the mesh as rows are found on it."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.app.project.project import Project
from stitchmesh.app.project.source import Source, read_source, source_of
from stitchmesh.errors import MeshError
from stitchmesh.io.mesh_reading import MeshReading
from stitchmesh.io.meshes import read_mesh, read_repaired_mesh, write_mesh
from stitchmesh.mesh.upright import Y
from tests.gallery import tube


def obj(vertices, faces) -> bytes:
    """The text of an OBJ file."""
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in vertices]
    lines += ["f " + " ".join(str(vertex + 1) for vertex in face) for face in faces]
    return "\n".join([*lines, ""]).encode()


def with_a_button(mesh) -> bytes:
    """A mesh of quads with a triangle that stands on one of its inner edges, which then has three faces."""
    quads = mesh.face_vertex.reshape(-1, 4).tolist()
    return obj([*mesh.vertices, 1.2 * mesh.vertices[-1]], [*quads, [*quads[0][1:3], len(mesh.vertices)]])


def with_loose_faces(mesh) -> bytes:
    """A mesh of quads of which each has vertices of its own, as exporters write faces with texture seams."""
    return obj(mesh.vertices[mesh.face_vertex], np.arange(len(mesh.face_vertex)).reshape(-1, 4).tolist())


@pytest.mark.parametrize("spoil", [with_a_button, with_loose_faces])
def test_rows_are_found_on_the_mesh_that_the_command_line_repairs(tmp_path, spoil):
    path = tmp_path / "shirt.obj"
    path.write_bytes(spoil(tube(8, 4)))
    repaired = read_repaired_mesh(path)
    start = read_source(Source("shirt.obj", path.read_bytes(), MeshReading(up=Y)))
    assert repaired.actions and start.repairs == repaired.actions
    np.testing.assert_array_equal(start.surface.vertices, repaired.mesh.vertices)
    np.testing.assert_array_equal(start.surface.face_vertex, repaired.mesh.face_vertex)


def test_quads_that_form_a_surface_are_labeled_as_they_are_in_the_file(tmp_path):
    path = tmp_path / "shirt.obj"
    path.write_bytes(with_loose_faces(tube(8, 4)))  # 32 quads, each a surface of its own
    start = read_source(Source("shirt.obj", path.read_bytes(), MeshReading(up=Y)))
    np.testing.assert_array_equal(start.mesh.vertices, read_mesh(path).vertices)
    assert len(start.surface.vertices) == 40 and start.mesh is not start.surface


def test_a_sound_mesh_is_one_mesh(tmp_path):
    write_mesh(tmp_path / "tube.obj", tube(8, 4))
    start = read_source(source_of("tube.obj", (tmp_path / "tube.obj").read_bytes()))
    assert start.surface is start.mesh and start.repairs == ()


def test_the_surface_outlives_the_steps_of_the_labeling(tmp_path):
    project = Project.create(tmp_path / "one", source=source_of("shirt.obj", with_a_button(tube(8, 4))))
    surface, repairs = project.surface, project.repairs
    with pytest.raises(MeshError, match=r"^strip\.obj"):
        project.import_mesh("strip.obj", moebius_strip())
    assert project.surface is surface and project.repairs == repairs
    project.close()


def moebius_strip() -> bytes:
    """A strip of six quads with one side, which no repair makes a surface with two."""
    angle = np.arange(6) * np.pi / 3.0
    across = np.stack([np.cos(angle) * np.cos(angle / 2), np.sin(angle) * np.cos(angle / 2), np.sin(angle / 2)], axis=1)
    middle = 5.0 * np.stack([np.cos(angle), np.sin(angle), np.zeros(6)], axis=1)
    faces = [[i, i + 6, i + 7, i + 1] for i in range(5)] + [[5, 11, 0, 6]]
    return obj(np.concatenate([middle - across, middle + across]), faces)
